"""All logs of a study: each is one run of the simulation, alone or in a pool of processes, with the same bytes.

A log holds the contract's columns, every sensor with its own error.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait
from dataclasses import dataclass, field
from multiprocessing import get_context
from multiprocessing.queues import SimpleQueue
from pathlib import Path
from typing import final

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from exogauge.blas_threads import limit_children
from exogauge.errors import BadMotion, Fault
from exogauge.synthetic import motion
from exogauge.synthetic.lab import Lab
from exogauge.synthetic.log_plans import LogPlan
from exogauge.synthetic.mjcf import TIME_STEP, mujoco_model
from exogauge.synthetic.played import PlayedMotion
from exogauge.synthetic.random_streams import stream
from exogauge.synthetic.robot_facts import FEET, JOINT_NAMES
from exogauge.synthetic.sensors import Sensing, encoder, noisy
from exogauge.synthetic.simulation import FellOver, Recording, simulate
from exogauge.synthetic.suit import Suit
from exogauge.synthetic.true_robot import TrueRobot, a_priori_robot

Progress = Callable[[float, str], None]
Tell = Callable[[str, float], None]  # log, seconds of it simulated

LATEST_START_S = 0.08  # of a repetition's log, after the motion's own beginning
_ASK_EVERY_S = 0.1
_MOTIONS = {"excitation": motion.excitation, "bend": motion.bend, "twist": motion.twist}


@final
@dataclass(frozen=True)
class Bench:
    """What all runs of a study share. suits: by kind, as worn by this robot; lab: what disturbs them; played: motions
    from files, by their names."""

    seed: int
    robot: TrueRobot
    suits: Mapping[str, Suit]
    lab: Lab
    played: Mapping[str, PlayedMotion] = field(default_factory=dict)


def write_logs(folder: Path, bench: Bench, plans: Sequence[LogPlan], progress: Progress, processes: int) -> None:
    """`folder/logs/<name>.parquet` of every plan, and what a suit did in it in `folder/truth/<name>.parquet`;
    progress(share done, what is being done) comes from this process."""
    (folder / "logs").mkdir(parents=True, exist_ok=True)
    if any(plan.suit for plan in plans):
        (folder / "truth").mkdir(exist_ok=True)
    whole, simulated = sum(plan.duration_s for plan in plans), dict.fromkeys((plan.name for plan in plans), 0.0)

    def tell(name: str, seconds: float) -> None:
        simulated[name] = max(seconds, simulated[name])
        progress(min(sum(simulated.values()) / whole, 1.0), f"simulating {name}")

    if min(processes, len(plans)) < 2:
        for plan in plans:
            _make(folder, bench, plan, tell)
    else:
        _make_in_pool(folder, bench, plans, tell, min(processes, len(plans)))
    progress(1.0, "simulated")


def run_log(
    bench: Bench, plan: LogPlan, rng: np.random.Generator, tick: Callable[[float], None] = lambda seconds: None
) -> Recording:
    """The true robot's run of one log, before any sensor; rng: of this log.

    A repetition follows the same plan as the others of its motion; its log begins up to `LATEST_START_S` later, by
    whole steps of the simulation, and it arrives at the first posture a little differently.
    """
    lab = bench.lab
    planner, late_steps = mujoco_model(a_priori_robot()), 0
    given = bench.played.get(plan.motion)
    if plan.repeats:
        motions, varied = stream(bench.seed, plan.motion), lab.variation(plan)
        path = (
            _MOTIONS[plan.motion](motions, plan.duration_s, planner, rng, varied)
            if given is None
            else given.plan(motions, rng, varied, planner)
        )
        late_steps = int(rng.integers(round(LATEST_START_S / TIME_STEP) + 1))
    else:
        path = _MOTIONS[plan.motion](rng, plan.duration_s, planner)
    model = mujoco_model(bench.robot, lab.worn(bench.suits[plan.suit], plan) if plan.suit else None)
    try:
        return simulate(model, bench.robot, path, tick, late_steps, lab.drives(plan), lab.encoder_step)
    except FellOver as fell:
        if given is None:
            raise
        advice = "Plan it slower, or with a wider margin of balance; `exogauge motion check` tells its margins"
        raise BadMotion(Fault(f"{fell}, in {plan.name}", "fell_over", advice, plan.motion)) from fell


def _make(folder: Path, bench: Bench, plan: LogPlan, tell: Tell) -> None:
    rng = stream(bench.seed, plan.name)
    recording = run_log(bench, plan, rng, lambda seconds: tell(plan.name, seconds))
    write_log(folder / "logs" / f"{plan.name}.parquet", recording, rng, bench.seed, bench.lab.sensing(plan))
    if plan.suit:
        write_torque(folder / "truth" / f"{plan.name}.parquet", recording)
    tell(plan.name, plan.duration_s)


def _make_in_pool(folder: Path, bench: Bench, plans: Sequence[LogPlan], tell: Tell, processes: int) -> None:
    """Processes that are started anew, so that no thread or lock of this one comes along."""
    limit_children()
    context = get_context("spawn")
    told: SimpleQueue[tuple[str, float]] = context.SimpleQueue()
    with ProcessPoolExecutor(processes, context, initializer=_speak_into, initargs=(told,)) as pool:
        running = {pool.submit(_make_and_tell, folder, bench, plan) for plan in plans}
        try:
            while running:
                done, running = wait(running, timeout=_ASK_EVERY_S, return_when=FIRST_COMPLETED)
                while not told.empty():
                    tell(*told.get())
                for each in done:
                    each.result()
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise


_told: SimpleQueue[tuple[str, float]]  # of a process in the pool: queues are handed over at its start only


def _speak_into(told: SimpleQueue[tuple[str, float]]) -> None:
    global _told
    _told = told


def _make_and_tell(folder: Path, bench: Bench, plan: LogPlan) -> None:
    _make(folder, bench, plan, lambda name, seconds: _told.put((name, seconds)))


Array = NDArray[np.float64]

LABEL = {"exogauge": "SYNTHETIC: simulated with MuJoCo, measured on no robot"}


def write_log(
    path: Path, recording: Recording, rng: np.random.Generator, seed: int, sensing: Sensing | None = None
) -> None:
    """Contract columns; angles and time as float64, what carries sensor noise as float32. sensing: what is wrong."""
    time, angle = recording.time, encoder(recording.q)
    acc, gyro, wrenches = recording.acc, recording.gyro, recording.wrench
    if sensing is not None:
        time, angle = sensing.stamps(time), sensing.angles(recording.q)
        acc, gyro = (sensing.inertial(each, recording.time) for each in (acc, gyro))
        wrenches = sensing.wrench(wrenches, recording.time)
    columns = {"t": pa.array(time)}
    columns |= {f"q.{name}": pa.array(a) for name, a in zip(JOINT_NAMES, angle.T, strict=True)}

    def add(names: Sequence[str], values: Array, kind: str) -> None:
        logged = noisy(values, kind, rng).astype(np.float32)
        columns.update({name: pa.array(column) for name, column in zip(names, logged.T, strict=True)})

    add([f"i.{name}" for name in JOINT_NAMES], recording.current, "i")
    add([f"acc.{axis}" for axis in "xyz"], acc, "acc")
    add([f"gyro.{axis}" for axis in "xyz"], gyro, "gyro")
    for foot, wrench in zip(FEET, np.moveaxis(wrenches, 1, 0), strict=True):
        add([f"ft.{foot}.f{axis}" for axis in "xyz"], wrench[:, :3], "force")
        add([f"ft.{foot}.m{axis}" for axis in "xyz"], wrench[:, 3:], "moment")
    label = {**LABEL, "seed": str(seed)}
    pq.write_table(pa.table(columns).replace_schema_metadata(label), path, compression="zstd")


def write_torque(path: Path, recording: Recording) -> None:
    """The true supporting torque [N·m] at the log's samples, of the joints that the bands act on; for scoring only."""
    columns = {"t": pa.array(recording.time)}
    for name, torque in zip(JOINT_NAMES, recording.band_torque.T, strict=True):
        if torque.any():
            columns[name] = pa.array(torque.astype(np.float32))
    pq.write_table(pa.table(columns).replace_schema_metadata(LABEL), path, compression="zstd")
