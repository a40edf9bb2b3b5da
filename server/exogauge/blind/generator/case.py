"""One case: a robot, its motions, what is hidden in it, its study folder, and its answer.

Logs are as the robot would have stored them: the contract's columns, every sensor with its own error.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import yaml
from numpy.typing import NDArray

from exogauge.blind.generator import sensors
from exogauge.blind.generator.axis_run import AxisRun, axis_runs
from exogauge.blind.generator.cut import AXES
from exogauge.blind.generator.dynamics import carrier
from exogauge.blind.generator.hidden.log_filter import BandLimitedLog
from exogauge.blind.generator.hidden.outside import EncoderEccentricity
from exogauge.blind.generator.motion import DURATION_S, Motion, excitations
from exogauge.blind.generator.placed import Placed, clutter, hide, motor_torque, pull, sensed
from exogauge.blind.generator.plan import CasePlan, plan_case
from exogauge.blind.generator.robot_files import Built, built, robot_file, robot_urdf
from exogauge.blind.generator.robot_kind import WristOrBase
from exogauge.blind.generator.scene import Scene, scene
from exogauge.blind.generator.true_robot import K_T_STD, draw_robot, record
from exogauge.blind.generator.wear import draw_wear
from exogauge.synthetic.random_streams import stream
from exogauge.synthetic.robot_facts import Joint, Link

Array = NDArray[np.float64]

_LABEL = "SYNTHETIC: computed, measured on no robot"


def write_case(
    folder: Path, seed: int, number: int, robots: str = "both", effects: tuple[str, ...] = ()
) -> dict[str, Any]:
    """Write the study into `folder`, and give its answer; the same arguments make the same bytes."""
    plan = plan_case(seed, number, robots, effects)
    maker, here, hidden, small = drawn(plan, seed)
    write_logs(folder, plan, maker, here, [*hidden, *small], seed)
    (folder / "robot.urdf").write_text(robot_urdf(plan.robot.name, maker.links), encoding="utf-8")
    _write_yaml(folder / "robot.yaml", robot_file(plan.robot, maker.links, plan.actuation, K_T_STD[plan.k_T]))
    if here.wear is not None:
        _write_yaml(folder / "device.yaml", here.wear.device_file(f"SYNTHETIC bands on {plan.robot.name}"))
    _write_yaml(folder / "study.yaml", _study_file(plan))  # last: a folder with it is whole
    return {
        "case": plan.name,
        "robot": plan.robot.name,
        "actuation": plan.actuation,
        "effects": [each.record() for each in hidden],
        "clutter": [each.record() for each in small],
        "joints": record(here.robot, here.joints),
        "bands": here.wear.record() if here.wear is not None else {},
        "rigid": _rigid(maker.links),
    }


def drawn(plan: CasePlan, seed: int) -> tuple[Built, Scene, Sequence[Placed], Sequence[Placed]]:
    """What the maker states, the case with nothing hidden, what is hidden in it, and the clutter beside that."""
    maker = built(stream(seed, f"maker {plan.number}"), plan.robot)
    here = undisturbed(plan, maker, seed)
    hidden = hide(stream(seed, f"hidden {plan.number}"), plan, here)
    small = clutter(stream(seed, f"clutter {plan.number}"), here, hidden) if plan.clutter else []
    return maker, here, hidden, small


def undisturbed(plan: CasePlan, maker: Built, seed: int) -> Scene:
    """The case as it would be with nothing hidden."""
    number, kind = plan.number, plan.robot
    robot = draw_robot(stream(seed, f"robot {number}"), maker.links, kind.sensor.frame, K_T_STD[plan.k_T])
    paths = [log.path for log in plan.logs]
    own = excitations(stream(seed, f"motion {number}"), maker.joints, max(paths) + 1, DURATION_S)
    motion = Motion(own.time, own.q[paths], own.dq[paths], own.ddq[paths])
    wear = None
    if kind.wires:
        worn = np.array([log.worn for log in plan.logs])
        rng = stream(seed, f"wear {number}")
        wear = draw_wear(rng, kind.wires, maker.size, maker.links, robot.tree, motion, worn)
    runs = axis_runs(stream(seed, f"run {number}"), robot, motion, wear.pull() if wear is not None else None)
    k_T_std = K_T_STD[plan.k_T] if plan.actuation == "current" else 0.0
    return scene(kind, maker.links, robot, motion, plan.logs, runs, wear, sensors.current_std(), k_T_std)


def disturbed_runs(here: Scene, effects: Sequence[Placed], plan: CasePlan, seed: int) -> Sequence[AxisRun]:
    """The joints under what bodies, base and bands ask beside: friction at rest takes its part of that too."""
    more = pull(here, effects)
    if more is None:
        return here.runs
    more = more + (here.wear.pull() if here.wear is not None else 0.0)
    return axis_runs(stream(seed, f"run {plan.number}"), here.robot, here.motion, more)


def write_logs(
    folder: Path, plan: CasePlan, maker: Built, here: Scene, effects: Sequence[Placed], seed: int, first: int = 0
) -> None:
    """first: of the scene's logs that are written. Those that are written later have noise of their own, and the
    sensor's zero error of the case."""
    runs = disturbed_runs(here, effects, plan, seed)
    torques = [motor_torque(run, effects, joint) for joint, run in enumerate(runs)]
    wrench = sensed(here, effects)
    (folder / "logs").mkdir(parents=True, exist_ok=True)
    rng, motion = stream(seed, f"sensors {plan.number}"), as_read(here.motion, effects)
    zero = sensors.ZERO * here.cut_baseline.std * rng.standard_normal(6)
    rng = stream(seed, f"sensors {plan.number} from {first}") if first else rng
    for n, log in list(enumerate(here.logs))[first:]:
        columns = joint_columns(rng, plan, maker.joints, motion, runs, torques, n)
        columns |= sensor_columns(rng, plan.robot.sensor, wrench, zero, n)
        for each in effects:
            if isinstance(each.effect, BandLimitedLog) and each.effect.hits(n):
                columns = {name: each.effect.filtered(values, each.size) for name, values in columns.items()}
        labelled = table(here.motion.time, columns).replace_schema_metadata({"exogauge": _LABEL})
        pq.write_table(labelled, folder / "logs" / f"{log.name}.parquet", compression="zstd")


def as_read(motion: Motion, effects: Sequence[Placed]) -> Motion:
    """With what encoders say of the angles, steps and noise left out."""
    q = motion.q.copy()
    for each in effects:
        if isinstance(each.effect, EncoderEccentricity):
            q[:, :, each.joint] = each.effect.read(q[:, :, each.joint], each.size)
    return replace(motion, q=q)


def _study_file(plan: CasePlan) -> Mapping[str, Any]:
    logs = [
        {"file": f"logs/{log.name}.parquet", "role": log.role} | ({"motion": log.motion} if log.motion else {})
        for log in plan.logs
    ]
    device, steps = dict[str, str](), ["identify", "discrepancy"]
    if plan.robot.wires:
        device, steps = {"device": "device.yaml"}, ["identify", "support", "stiffness", "discrepancy"]
    name = f"SYNTHETIC {plan.robot.name}, blind {plan.name}"
    return {"version": 1, "name": name, "robot": "robot.yaml", **device, "logs": logs, "steps": steps}


def _rigid(links: Sequence[Link]) -> list[list[str]]:
    """Links that are fixed to each other, the moving one first: names of the same body."""
    groups: dict[str, list[str]] = {}
    for link in links:
        groups.setdefault(carrier(links, link.name)[0], []).append(link.name)
    return [names for names in groups.values() if len(names) > 1]


def _write_yaml(path: Path, content: object) -> None:
    head = "# SYNTHETIC: written by `exogauge blind make`, measured on no robot\n"
    text = yaml.safe_dump(content, sort_keys=False, width=120, default_flow_style=None)
    path.write_text(head + text, encoding="utf-8")


def joint_columns(
    rng: np.random.Generator,
    plan: CasePlan,
    joints: Sequence[Joint],
    motion: Motion,
    runs: Sequence[AxisRun],
    torques: Sequence[Array],
    log: int,
) -> dict[str, Array]:
    """Angles, currents or torques, temperatures. torques: (L, T) each, k_T i."""
    q = {f"q.{j.name}": sensors.encoder(rng, motion.q[log, :, n], j.drive.gear_ratio) for n, j in enumerate(joints)}
    logged: dict[str, Array] = {}
    for joint, run, torque in zip(joints, runs, torques, strict=True):
        current = sensors.current(rng, torque[log] / run.drive.k_T)
        if plan.actuation == "current":
            logged[f"i.{joint.name}"] = current
        else:  # a drive that knows its own constant
            logged[f"tau.{joint.name}"] = current * run.drive.k_T
    if plan.temperature:
        for joint, run in zip(joints, runs, strict=True):
            logged[f"temp.{joint.name}"] = sensors.thermometer(rng, run.temperature[log])
    return {**q, **logged}


def sensor_columns(
    rng: np.random.Generator, sensor: WristOrBase, wrench: Array, zero: Array, log: int
) -> dict[str, Array]:
    """Force, then moment, with the sensor's zero error (6,); wrench: (L, T, 6)."""
    felt, std = wrench[log] + zero, np.repeat([sensor.force, sensor.moment], 3)
    return {f"ft.{sensor.name}.{axis}": sensors.noisy(rng, felt[:, n], float(std[n])) for n, axis in enumerate(AXES)}


def table(time: Array, columns: Mapping[str, Array]) -> pa.Table:
    """Angles in double precision, what carries more noise in single."""
    exact = {name: pa.array(values) for name, values in columns.items() if name.startswith("q.")}
    rest = {name: pa.array(v.astype(np.float32)) for name, v in columns.items() if not name.startswith("q.")}
    return pa.table({"t": pa.array(time), **exact, **rest})
