"""What is asked for where poor logs leave rivals, against a plain sweep; what is named once it is recorded.

`python -m tests.bench.tell_apart_poor [HIDES:STYLE:SEED:JOINT:TIMES[:i] …]`, `i` where currents are logged: arms of
`tests.bench.poor_logs`. Evidence per 10 s of the rival that is told worst: `sweep`, of the best single joint that is
swept as the list of sweeps has it; `offered`, promised of the motion that is asked for; `given`, by which the hidden
effect then leads the other one, less its lead before, where it is one of the two. It is played twice, one held out, as
the finding's sentence says.
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before numpy is imported

import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

import mujoco
import numpy as np
from scipy.interpolate import CubicSpline
from tests.bench.poor_logs import JOINTS, PoorArm
from tests.bench.tell_apart import rates

from exogauge.detect.pipeline import Found, find_missing_effects
from exogauge.effects.catalogue import missing_effects, shaped_effects
from exogauge.experiment import design
from exogauge.experiment.design import Outcome
from exogauge.findings.planned_motion import PlannedMotion
from exogauge.identification.identify import identify
from exogauge.identification.settings import Recording, Settings
from exogauge.identification.sites import AxisSite
from exogauge.logs.model import Log
from exogauge.motion.robot_file import load_motion_robot
from exogauge.robots.moving.robot import MotionRobot
from exogauge.search.ambiguity import Contender, Undecided
from exogauge.search.baseline import lay_ground
from exogauge.search.refine import closest
from exogauge.search.site_rows import collect_rows
from exogauge.studies.intake.robot_file import load_robot

DOUBT = 0.03  # share by which a maker whose number is wrong may be off in all others
CASES = ("stribeck:fast:1:1:1",)
SETTINGS, SECONDS = Settings(cutoff_hz=8.0), 20.0  # one cut-off, so that evidence before and after is comparable
Asked = tuple[Undecided, Sequence[Log], MotionRobot | None, Outcome]


def report(cases: Sequence[str]) -> None:
    print("case | named, rivals | sweep | offered | times | given | after | CPU s of planning | kept", flush=True)
    for case in cases:
        print(" | ".join([case, *_case(case)]), flush=True)


def _case(case: str) -> list[str]:
    hides, style, seed, joint, times, *currents = case.split(":")
    doubt_of_maker = DOUBT if hides in ("kt_gain", "link_mass") else None
    arm = PoorArm(int(seed), hides, int(joint), float(times), doubt_of_maker, bool(currents))
    logs = [arm.poor(name, style, SECONDS, 10 * int(seed) + k) for k, name in enumerate(("id_1", "id_2", "val"))]
    recordings = [Recording(log, log.name == "val") for log in logs]
    with tempfile.TemporaryDirectory() as folder:
        path = arm.folder(Path(folder))
        before, asked, spent = _found(path, recordings)
        if not asked:
            return [_named(before), *["-"] * 7]
        doubt, fitted, moving, outcome = asked[0]
        sweep, offered = rates(doubt, fitted, moving, outcome)
        motions = outcome.motions
        more = list(recordings)
        for n, motion in enumerate(motions):
            table, rate = np.concatenate([motion.q] * motion.repeats), 1.0 / (motion.time[1] - motion.time[0])
            for k, name in enumerate(("planned", "again")):
                more.append(Recording(arm.played(f"{name}_{n}", table, rate, 77 + 2 * n + k), k == 1))
        after, _, _ = _found(path, more)
        first, names = doubt.contenders[0], [each.name for each in doubt.contenders]
        site = first.candidate.site if isinstance(first, Contender) else None
        given = "-"
        if hides in names and isinstance(site, AxisSite):
            lead = [_leads(path, some, site, hides, names) for some in (recordings, more)]
            given = f"{10.0 * (lead[1] - lead[0]) / sum(each.duration for each in motions):.1f}"
        assert moving is not None
        kept = "; ".join(_broken(arm, moving, each) for each in motions)
        times = f"{offered / sweep:.2f}" if sweep > 0.0 else "-"
        return [_named(before), f"{sweep:.1f}", f"{offered:.1f}", times, given, _named(after),
                f"{spent:.1f}", kept]  # fmt: skip


def _found(path: Path, recordings: list[Recording]) -> tuple[Found, list[Asked], float]:
    """And what was asked of the planner, with [s] that it took."""
    asked, kept, spent = list[Asked](), design.tell_apart, 0.0

    def listening(doubt: Undecided, logs: Sequence[Log], moving: MotionRobot | None = None) -> Outcome | None:
        nonlocal spent
        begun = time.process_time()
        outcome = kept(doubt, logs, moving)
        spent += time.process_time() - begun
        if outcome is not None and outcome.motions:
            asked.append((doubt, logs, moving, outcome))
        return outcome

    design.tell_apart = listening
    try:
        robot, moving = load_robot(path.parent, path.name), load_motion_robot(path)
        first = identify(robot, recordings, SETTINGS)
        found = find_missing_effects(first, recordings, missing_effects(), SETTINGS, moving=moving)
    finally:
        design.tell_apart = kept
    return found, asked, spent


def _named(found: Found) -> str:
    said = [f"{each.effect} {each.place.name}" + "".join(f" or {also.effect}" for also in each.also_possible)
            for each in found.discrepancy.findings]  # fmt: skip
    return ", ".join(said) or "nothing"


def _leads(path: Path, recordings: list[Recording], site: AxisSite, hides: str, names: Sequence[str]) -> float:
    """Evidence by which the hidden effect leads the best of the others."""
    model = identify(load_robot(path.parent, path.name), recordings, SETTINGS).model
    ground = lay_ground(model, recordings, [shaped_effects()[name] for name in names], lambda *_: None)
    rows = collect_rows(model, recordings, [site])[site]
    found = {}
    for name in names:
        scores = [each for each in ground.scores if each.candidate.key == (name, site)]
        found[name] = closest(ground.baseline, scores, rows).evidence if scores else 0.0
    return found[hides] - max(value for name, value in found.items() if name != hides)


def _broken(arm: PoorArm, moving: MotionRobot, motion: PlannedMotion) -> str:
    """Bounds that the written motion exceeds at 1 kHz, by MuJoCo, of the robot as stated; torque of the true one."""
    rate, limits, order = 1000.0, moving.limits, [motion.joints.index(name) for name in moving.joints]
    path = CubicSpline(motion.time, motion.q[:, order])
    t = np.arange(int(motion.time[-1] * rate) + 1) / rate
    q, v, a = (path(t, k) for k in range(3))
    found = []
    if (q < limits.lower).any() or (q > limits.upper).any():
        found.append("position")
    for what, most in (("velocity", np.abs(v).max(axis=0) / limits.velocity),
                       ("acceleration", np.abs(a).max(axis=0) / limits.acceleration)):  # fmt: skip
        found.append(f"{what} {100 * most.max():.0f} %")
    table = np.concatenate([motion.q] * motion.repeats)
    drive = arm.moved(table, 1.0 / (motion.time[1] - motion.time[0])).drive
    found.append(f"torque {100 * (np.abs(drive) / limits.torque).max():.0f} %")
    found.append(f"apart {1e3 * _nearest(arm, q[::20]):.0f} mm")
    return ", ".join(found)


def _nearest(arm: PoorArm, q: np.ndarray) -> float:
    """[m] of links that no one joint lies between."""
    model = arm.model
    data, nearest = mujoco.MjData(model), 0.5
    geoms = {model.body(model.geom_bodyid[g]).name: g for g in range(model.ngeom)}
    first, second, third = (f"l{name}" for name in JOINTS)
    base = "base" if "base" in geoms else "world"
    far = [(base, second), (base, third), (first, third)]
    for posture in q:
        data.qpos[:] = posture
        mujoco.mj_kinematics(model, data)
        nearest = min(nearest, *(mujoco.mj_geomDistance(model, data, geoms[a], geoms[b], 0.5, None) for a, b in far))
    return float(nearest)


if __name__ == "__main__":
    report(sys.argv[1:] or CASES)
