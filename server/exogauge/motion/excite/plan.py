"""From robot.yaml to a motion from which that robot is identified well, and what will be known then."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.motion_excite import USUAL, MotionExcite
from exogauge.errors import BadMotion, BadRobot, Fault
from exogauge.experiment.envelope import within
from exogauge.motion.excite.excited import Excited
from exogauge.motion.excite.known import Known, of_result, of_study
from exogauge.motion.excite.promise import COUNTED, Promise, promised
from exogauge.motion.excite.search import Report, best_motion
from exogauge.motion.excite.task import task_of
from exogauge.motion.plan.judge import judge
from exogauge.motion.plan.outcome import may_touch, unseen
from exogauge.motion.robot_file import load_motion_robot
from exogauge.robots.moving.robot import MotionRobot
from exogauge.robots.moving.stance import Standing
from exogauge.studies.csv_table import csv_table
from exogauge.studies.intake.robot_file import load_robot

Array = NDArray[np.float64]

PLACES = 8  # decimals of what is written
SHORTEST_S, LONGEST_S = 3.0, 120.0  # of a motion that is planned
SEARCH = 0.05, 0.8  # judgement: of what is shown as done, where the search begins and ends; it takes most of the time
Progress = Callable[[float, str], None]


@final
@dataclass(frozen=True)
class ExcitationPlan:
    """nearest: share of the bound that is nearest, at `MotionExcite.check_hz` from rest to rest, and which.

    judged: what `plan.judge` says is broken of a standing robot, whose legs share the load.
    """

    robot: MotionRobot
    planned: Excited
    nearest: tuple[float, str]
    judged: tuple[str, ...]
    promise: Promise


def plan_excitation(
    path: Path, seconds: float, *, study: Path | None = None, result: Path | None = None, seed: int = 0,
    criteria: MotionExcite = USUAL, report: Report | None = None, say: Progress = lambda share, words: None,
    beside: bool = False,
) -> ExcitationPlan:  # fmt: skip
    """path: robot.yaml. study, result: whose logs, or whose results.json, say what is known already. say: told what is
    done beside the search, and the share of the whole that lies before it; the search takes those of `SEARCH`. beside:
    meshes as `load_motion_robot` looks for them.

    Raises BadInput; NotIdentifiable where no motion is within the bounds.
    """
    if not SHORTEST_S <= seconds <= LONGEST_S:
        advice = f"From {SHORTEST_S:g} to {LONGEST_S:g} s"
        raise BadMotion(Fault(f"a motion of {seconds:g} s is not planned", "bad_seconds", advice,
                              column="seconds", value=f"{seconds:g}"))  # fmt: skip
    robot, moving = load_robot(path.parent, path.name), load_motion_robot(path, beside=beside)
    if not robot.contacts and all(joint.actuation == "none" for joint in robot.joints):
        detail = "neither a torque, a current nor a foot's force is logged: nothing can be identified"
        advice = "Say `actuation: torque`, or `current` with prior.k_T, or give ft_sensors with role contact"
        raise BadRobot(Fault(detail, "nothing_logged", advice, path.name, column="joints"))
    task = task_of(robot, moving, seconds, criteria)
    known: Known | None = None
    if study is not None:
        say(0.01, "identifying from the study's logs")
        known = of_study(robot, study)
    elif result is not None:
        known = of_result(task.information.equations, result)
    if known is not None:
        task = task_of(robot, moving, seconds, criteria, known.information)
    x = best_motion(task, np.random.default_rng(seed), report)
    say(SEARCH[1], "every bound from rest to rest")
    for _ in range(criteria.shrinks):
        planned = Excited(task, x)
        nearest, judged = planned.largest(), _judged(planned)
        if nearest[0] <= 1.0 and not judged:
            break
        x = within(task, task.still + criteria.smaller * (x - task.still))  # the way there and back has bounds too
    say(0.9, "what will be known")
    promise = promised(robot, [planned], known.logs if known else (), known.before if known else None)
    return ExcitationPlan(moving, planned, nearest, judged, promise)


def _judged(planned: Excited) -> tuple[str, ...]:
    stance = planned.task.stance
    if not isinstance(stance, Standing):
        return ()
    return judge(stance.robot, planned, stance.place, rate=planned.task.criteria.check_hz).broken


def motion_table(plan: ExcitationPlan, rate_hz: float) -> bytes:
    """t [s], then `q.<joint>` [rad, or m of a prismatic joint]."""
    robot = plan.robot
    time = np.arange(int(plan.planned.duration * rate_hz + 1e-6) + 1) / rate_hz
    q = plan.planned.at(time)[0][:, robot.base :]
    rows: Sequence[Sequence[float]] = np.round(np.column_stack([time, q]), PLACES).tolist()
    return csv_table(("t", *(f"q.{name}" for name in robot.joints)), rows)


def summarise(plan: ExcitationPlan) -> dict[str, str | float | list[str]]:
    """In a few lines."""
    begins, ends = plan.planned.edges[1:3]
    share, name = plan.nearest
    said: dict[str, str | float | list[str]] = {
        "robot": plan.robot.name,
        "seconds": round(plan.planned.duration, 3),
        "motion": f"{begins:.2f} to {ends:.2f} s; before and after it, rest at home and the way there",
        "nearest bound": f"{100 * share:.1f} % of {name}, at {plan.planned.task.criteria.check_hz:g} Hz",
        "identified up to": f"{plan.promise.cutoff_hz:.1f} Hz",
    }
    for count in plan.promise.counts:
        said[f"{count.kind} parameters"] = (f"{count.decided} of {count.of} will be decided; median "
                                            f"{100 * count.left:.2g} % of the doubt before is left")  # fmt: skip
    said["undecided"] = [each.name for kind in COUNTED for each in plan.promise.open(kind) if not each.decided]
    said |= unseen(plan.robot) | may_touch(plan.robot, plan.planned.task.bounds.pairs.left_out)
    broken = [*([f"{name}: {100 * share:.1f} % of its bound"] if share > 1.0 else []), *plan.judged]
    if broken:
        said["broken"] = broken
    return said
