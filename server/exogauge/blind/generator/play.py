"""A case's robot plays motions that were planned for it: more logs of what is hidden, beside those that it had."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import yaml
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from exogauge.blind.generator import sensors
from exogauge.blind.generator.axis_run import axis_runs
from exogauge.blind.generator.case import drawn, write_logs
from exogauge.blind.generator.motion import RATE_HZ, LogPlan, Motion
from exogauge.blind.generator.plan import plan_case
from exogauge.blind.generator.scene import scene
from exogauge.blind.generator.true_robot import K_T_STD
from exogauge.errors import BadInput, Fault
from exogauge.synthetic.random_streams import stream

Array = NDArray[np.float64]

TWICE = (("", "identification"), ("_again", "validation"))  # name, role


def play(
    folder: Path, seed: int, number: int, tables: Sequence[tuple[Array, Array, int]], robots: str = "both",
    effects: tuple[str, ...] = (),
) -> None:  # fmt: skip
    """Adds two logs for each table to the case in `folder`, which the other arguments made: one of identification, and
    one that is held out, as a finding asks for them.

    tables: (T,) [s] and (T, J) [rad] of one repeat in the order of the robot's joints, and how often it is repeated.
    Raises BadInput for a robot that wears bands: what they do hangs on all motions of its case.
    """
    plan = plan_case(seed, number, robots, effects)
    if plan.robot.wires:
        raise BadInput(Fault("no motion is played by a robot that wears bands", "no_play", value=plan.robot.name))
    maker, here, hidden, small = drawn(plan, seed)
    played = [LogPlan(f"planned_{k + 1}{again}", role, -1) for k in range(len(tables)) for again, role in TWICE]
    logs = (*plan.logs, *played)
    motion = _beside(here.motion, [_at_rate(*each) for each in tables for _ in TWICE])
    runs = axis_runs(stream(seed, f"run {number}"), here.robot, motion, None)
    k_T_std = K_T_STD[plan.k_T] if plan.actuation == "current" else 0.0
    after = scene(plan.robot, maker.links, here.robot, motion, logs, runs, None, sensors.current_std(), k_T_std)
    write_logs(folder, plan, maker, after, [*hidden, *small], seed, first=len(plan.logs))
    file = folder / "study.yaml"
    study = yaml.safe_load(file.read_text(encoding="utf-8"))
    study["logs"] += [{"file": f"logs/{log.name}.parquet", "role": log.role} for log in played]
    file.write_text(yaml.safe_dump(study, sort_keys=False), encoding="utf-8")


def _at_rate(time: Array, q: Array, repeats: int) -> Array:
    """(3, T, J) position, velocity, acceleration at `RATE_HZ` of all repeats, which are one path from rest to rest."""
    step = float(time[1] - time[0])
    every = np.concatenate([q] * repeats)
    path = CubicSpline(step * np.arange(len(every)), every, bc_type="clamped")
    at = np.arange(int((len(every) - 1) * step * RATE_HZ) + 1) / RATE_HZ
    return np.stack([path(at, k) for k in range(3)])


def _beside(motion: Motion, more: Sequence[Array]) -> Motion:
    """All logs as long as the longest: what ends before stands still."""
    old = np.stack([motion.q, motion.dq, motion.ddq], axis=1)
    logs = [*old, *more]
    longest = max(each.shape[1] for each in logs)
    q, dq, ddq = np.moveaxis(np.stack([_rested(each, longest) for each in logs]), 1, 0)
    return Motion(np.arange(longest) / RATE_HZ, q, dq, ddq)


def _rested(log: Array, samples: int) -> Array:
    rest = np.zeros((3, samples - log.shape[1], log.shape[2]))
    rest[0] = log[0, -1]
    return np.concatenate([log, rest], axis=1)
