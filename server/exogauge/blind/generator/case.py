"""One case: a robot, its motions, what is hidden in it, its study folder, and its answer."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq
import yaml

from exogauge.blind.generator import sensors
from exogauge.blind.generator.axis_run import axis_runs
from exogauge.blind.generator.excess import baselines
from exogauge.blind.generator.log_columns import joint_columns, mount_columns
from exogauge.blind.generator.maker import built
from exogauge.blind.generator.motion import excitations
from exogauge.blind.generator.placed import Bench, clutter, hide, motor_torque
from exogauge.blind.generator.plan import CasePlan, plan_case
from exogauge.blind.generator.robot_files import robot_file, robot_urdf
from exogauge.blind.generator.true_robot import draw_robot, record
from exogauge.synthetic.random_streams import stream

DURATION_S = 25.0
LOGS = ("id_1", "id_2", "id_3", "id_4", "val_1", "val_2")
_LABEL = "SYNTHETIC: computed, measured on no robot"


def write_case(folder: Path, seed: int, number: int, robots: str = "both") -> dict[str, Any]:
    """Write the study into `folder`, and give its answer; the same arguments make the same bytes."""
    plan = plan_case(seed, number, robots)
    links = built(stream(seed, f"maker {number}"), plan.robot.links)
    joints = [link.joint for link in links if link.joint is not None]
    robot = draw_robot(stream(seed, f"robot {number}"), links)
    motion = excitations(stream(seed, f"motion {number}"), joints, len(LOGS), DURATION_S)
    runs = axis_runs(stream(seed, f"run {number}"), robot, motion)
    floors = [run.drive.k_T * sensors.current_std() for run in runs]
    bench = Bench(runs, baselines(robot.tree, motion, runs), floors)
    hidden = hide(stream(seed, f"hidden {number}"), plan, bench)
    small = clutter(stream(seed, f"clutter {number}"), bench) if plan.clutter else []
    torques = [motor_torque(run, [*hidden, *small], joint) for joint, run in enumerate(runs)]

    (folder / "logs").mkdir(parents=True, exist_ok=True)
    rng = stream(seed, f"sensors {number}")
    for n, name in enumerate(LOGS):
        columns = joint_columns(rng, plan, joints, motion, runs, torques, n)
        if plan.robot.mount is not None:
            columns |= mount_columns(rng, plan.robot.mount, links, robot, motion, n)
        table = pa.table(columns).replace_schema_metadata({"exogauge": _LABEL})
        pq.write_table(table, folder / "logs" / f"{name}.parquet", compression="zstd")
    (folder / "robot.urdf").write_text(robot_urdf(plan.robot.name, links), encoding="utf-8")
    _write_yaml(folder / "robot.yaml", robot_file(plan.robot, links, plan.actuation))
    _write_yaml(folder / "study.yaml", _study_file(plan))  # last: a folder with it is whole
    names = [joint.name for joint in joints]
    return {
        "case": plan.name,
        "robot": plan.robot.name,
        "actuation": plan.actuation,
        "effects": [each.record(names) for each in hidden],
        "clutter": [each.record(names) for each in small],
        "joints": record(robot, names),
    }


def _study_file(plan: CasePlan) -> Mapping[str, Any]:
    roles = {"id": "identification", "val": "validation"}
    return {
        "version": 1,
        "name": f"SYNTHETIC {plan.robot.name}, blind {plan.name}",
        "robot": "robot.yaml",
        "logs": [{"file": f"logs/{name}.parquet", "role": roles[name.split("_")[0]]} for name in LOGS],
        "steps": ["identify", "discrepancy"],
    }


def _write_yaml(path: Path, content: object) -> None:
    head = "# SYNTHETIC: written by `exogauge blind make`, measured on no robot\n"
    text = yaml.safe_dump(content, sort_keys=False, width=120, default_flow_style=None)
    path.write_text(head + text, encoding="utf-8")
