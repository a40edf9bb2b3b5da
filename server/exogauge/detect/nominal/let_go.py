"""Numbers of the maker that the logs contradict by far more than he doubts them: no longer held to what he says.

A free parameter takes a wrong number up, and the prior shares what is left among the neighbours, as sure of each as of
a number that is right. So what explains the contradiction best is believed less, by as much as it is off, and the
robot is identified anew.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.detect.nominal.contradicted import row_memory, tilting
from exogauge.detect.nominal.nominal_values import Stated, gain_columns, stated_numbers
from exogauge.identification.identify import identify
from exogauge.identification.model import RobotModel
from exogauge.identification.prior import relative_std
from exogauge.identification.result import Identification
from exogauge.identification.settings import Recording, Settings
from exogauge.logs.model import Log
from exogauge.remarks import About, Remark
from exogauge.robots.description import Joint, Robot

SAID = {"centre": About.CENTRE_LET_GO, "scaled": About.MASS_LET_GO, "gain": About.GAIN_LET_GO}


@final
@dataclass(frozen=True)
class LetGo:
    """stated: which number; doubt: relative, as it is stated; found: how far the logs are off, in the same measure."""

    stated: Stated
    doubt: float
    found: float


def let_go(found: Identification, recordings: Sequence[Recording], settings: Settings) -> Identification:
    """Identified anew where a number is let go, and told; else as it was."""
    model = found.model
    gone = contradicted_by_far(model, [each.log for each in recordings if not each.held_out])
    if not gone:
        return found
    alike = replace(settings, cutoff_hz=found.cutoff_hz)
    again = identify(believed_less(model.robot, gone), recordings, alike, extension=model.extension)
    return replace(again, remarks=(*again.remarks, *_told(model.robot, gone)))


def contradicted_by_far(model: RobotModel, logs: Sequence[Log]) -> list[LetGo]:
    """One after the other, with all that would explain as much. A number is off by more than its doubt, or not let go.

    None where a gain that all feet share would do as well, as then nothing says which of them it is; no motor's where
    one factor on all of them would, nor of one that hardly moved: what friction holds says nothing of gain or weight.
    """
    criteria = model.criteria
    asked, data = stated_numbers(model, tilting(model, logs), row_memory(model, logs))
    long = _moved_s(model, logs) >= criteria.judging.needed_s
    numbers = [each for each in asked if each.sort in SAID and _doubt(model, each) > 0.0]
    numbers = [each for each in numbers if (long[each.index] if each.sort == "gain" else long.any())]
    common = [each for each in asked if each.sort in ("gains", "feet")]
    gone = list[LetGo]()
    while numbers:
        evidence = [data.let(each.columns).evidence for each in numbers]
        best, alike = max(evidence), max((data.let(each.columns).evidence for each in common), default=-np.inf)
        if best < criteria.nominal.sure or alike > best - criteria.judging.open:
            break
        together = [each for each, own in zip(numbers, evidence, strict=True) if own > best - criteria.judging.open]
        for each in together:
            size = float(np.linalg.norm(data.let(each.columns).change * each.broad))
            if size > _doubt(model, each):
                gone.append(LetGo(each, _doubt(model, each), size))
        data = data.without(np.concatenate([each.columns for each in together]))
        numbers = [each for each in numbers if not any(each is one for one in together)]
    return gone


def _moved_s(model: RobotModel, logs: Sequence[Log]) -> NDArray[np.float64]:
    """(A,) [s] of steady motion of each axis."""
    return np.asarray(sum(model.prepare(log).steady.sum(axis=0) / log.rate_hz for log in logs), dtype=np.float64)


def believed_less(robot: Robot, gone: Sequence[LetGo]) -> Robot:
    """As doubtful as what was found is large."""
    inertial, joints = dict(robot.inertial_std), list(robot.joints)
    for each in gone:
        if each.stated.sort == "gain":
            joints[each.stated.index] = _with_doubt(joints[each.stated.index], each.found)
        else:
            link = robot.tree.bodies[each.stated.index]
            inertial[link] = max(
                each.found, float(relative_std(replace(robot, inertial_std=inertial))[each.stated.index])
            )
    return replace(robot, inertial_std=inertial, joints=tuple(joints))


def _with_doubt(joint: Joint, share: float) -> Joint:
    return replace(joint, prior_std={**joint.prior_std, "k_T": share * abs(joint.prior["k_T"])})


def _doubt(model: RobotModel, stated: Stated) -> float:
    """Relative. 0: known, or nothing is stated."""
    if stated.sort != "gain":
        return float(relative_std(model.robot)[stated.index])
    joint, prior = model.robot.joints[stated.index], model.solution.prior
    if joint.actuation != "current":
        return 0.0
    column = gain_columns(model.equations)[stated.index]
    return float(np.sqrt(prior.seen_covariance[column, column]) / abs(prior.seen_mean[column]))


def _told(robot: Robot, gone: Sequence[LetGo]) -> list[Remark]:
    names: Mapping[str, Sequence[str]] = {"gain": [joint.name for joint in robot.joints]}
    found = list[Remark]()
    for sort, about in SAID.items():
        own = [each for each in gone if each.stated.sort == sort]
        if own:
            called = tuple(names.get(sort, robot.tree.bodies)[each.stated.index] for each in own)
            found.append(Remark(about, called, tuple((each.found / each.doubt, 100.0 * each.found) for each in own)))
    return found
