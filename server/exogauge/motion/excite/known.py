"""What is known of a robot before a motion is planned: from a study's logs, or from what a result says."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

from exogauge.errors import BadStudy, Fault
from exogauge.identification.equations import Equations
from exogauge.identification.identify import identify
from exogauge.identification.result import Identification
from exogauge.identification.settings import Recording, Settings
from exogauge.logs.model import Log
from exogauge.motion.excite.promise import white_std
from exogauge.progress import Progress, unwatched
from exogauge.robots.description import Robot
from exogauge.robots.parameters import parameter_names
from exogauge.studies.intake.admit import admit
from exogauge.studies.intake.open import open_study

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Known:
    """information: (P, P) of base and joint parameters. logs: that hold it. before: name -> standard deviation."""

    information: Array
    logs: tuple[Log, ...]
    before: Mapping[str, float]


def of_study(robot: Robot, path: Path, progress: Progress = unwatched) -> Known:
    """path: study.yaml, its folder or a zip of it, of the same robot. Raises BadInput."""
    with open_study(path) as study:
        if study.robot.tree.joints != robot.tree.joints or not np.array_equal(study.robot.tree.phi, robot.tree.phi):
            raise BadStudy(Fault("the study is of another robot", "another_robot", "Name the study's own robot.yaml",
                                 path.name, None, "robot", study.robot.name))  # fmt: skip
        logs = [each.log for each in admit(study, worn=False, progress=progress).recordings if not each.held_out]
    found = identify(robot, [Recording(log, False) for log in logs], Settings(prior_strength=1.0), progress)
    stated = zip(found.parameters, white_std(found).tolist(), strict=True)
    return Known(information_of(found), tuple(logs), {each.name: max(each.std, white) for each, white in stated})


def information_of(found: Identification) -> Array:
    """(P, P) that logs, by the noise that their weights state, and prior hold of base and joint parameters.

    Zero of what is known exactly; what was added (zeros of sensors, loads) is doubted along.
    """
    model = found.model
    size, solved = model.equations.first_added, model.solution.unbounded
    free = model.solution.prior.free
    whole = solved.information.T @ solved.information + model.solution.prior.information(1.0)
    own = free < size
    if not own.all():
        beside = whole[np.ix_(own, ~own)]
        whole = whole[np.ix_(own, own)] - beside @ np.linalg.solve(whole[np.ix_(~own, ~own)], beside.T)
    out = np.zeros((size, size))
    out[np.ix_(free[own], free[own])] = whole
    return out


def of_result(equations: Equations, path: Path) -> Known:
    """path: results.json or its folder. It holds standard deviations alone: errors count as independent. Raises
    BadStudy."""
    path = path / "results.json" if path.is_dir() else path
    try:
        content: Any = json.loads(path.read_bytes())
        stated = {each["name"]: float(each["std"]) for each in content["identification"]["parameters"]}
    except (OSError, ValueError, KeyError, TypeError):
        raise BadStudy(Fault("no identified parameters can be read", "no_parameters",
                             "Give results.json of `exogauge run`", path.name)) from None  # fmt: skip
    names = list(parameter_names(equations.robot.tree))
    order = [f"base[{names[k]}]" for k in equations.base.columns]
    order += [f"{effect.coefficient.name}[{joint.name}]" for joint in equations.robot.joints
              for effect in equations.effects]  # fmt: skip
    lacking = [name for name in order if name not in stated]
    if lacking:
        raise BadStudy(Fault("a parameter of this robot is missing", "another_robot",
                             "Give a result of this robot", path.name, None, "name", lacking[0]))  # fmt: skip
    std = np.array([stated[name] for name in order])
    return Known(np.diag(1.0 / np.maximum(std, 1e-12) ** 2), (), stated)
