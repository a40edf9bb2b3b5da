"""Which slip explains best why joints do not bear what the robot's description expects: one after the other."""

from __future__ import annotations

from collections.abc import Sequence, Set
from dataclasses import dataclass, replace
from itertools import combinations, dropwhile
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.examining import Comparing
from exogauge.plausibility.expectation import Expected
from exogauge.plausibility.pooling import pooled, stands_out, together, without_the_worst
from exogauge.plausibility.relatives import coupled, related
from exogauge.plausibility.remedies import (
    Remedy,
    alike_limbs,
    exchanged,
    misread_positions,
    other_gravity,
    reversals,
    scaled_effort,
    shifted,
    without_gravity,
    zeros_in_eighths,
)
from exogauge.plausibility.screening import Screen
from exogauge.plausibility.snapshot import Snapshot
from exogauge.plausibility.summit import climb
from exogauge.plausibility.unlike import Unlike, unlike_axes
from exogauge.robots.description import Robot

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Slip:
    """remedy: what undoes it. evidence: gain in log likelihood. before, after: share of the axis' effort that is left.

    as_good: a remedy of the same joint between which and this one the data do not decide. logs: in which it is.
    rivals: other joints of which the same may be true as well.
    settled: once all that was found is undone, the joint bears what is described. Otherwise it was the nearest of what
    is tried to something else.
    """

    remedy: Remedy
    evidence: float
    before: float
    after: float
    as_good: Remedy | None = None
    logs: tuple[str, ...] = ()
    settled: bool = True
    rivals: tuple[int, ...] = ()


def find_slips(robot: Robot, seen: Sequence[Snapshot]) -> tuple[list[Slip], list[Unlike], list[Expected]]:
    """What is wrong in all of the logs, the slip that explains most first; then, with it undone, in single ones.

    And axes that no slip makes like their description; and what is expected of each log as it was handed in.
    """
    as_read = [Expected(robot, each) for each in seen]
    criteria = seen[0].criteria if seen else Comparing()
    first = _beyond_limits(robot, seen)
    slips, undone = list(first), list(seen)
    for slip in slips:
        undone = [slip.remedy.undo(each) for each in undone]
    state = _State(robot, [Expected(robot, each) for each in undone] if slips else as_read)
    every = tuple(range(len(seen)))
    for logs in [every, *((k,) for k in every if len(seen) > 1)]:
        while len(slips) < criteria.most_slips:
            part = _State(robot, [state.expected[k] for k in logs], state.others(logs))
            best = part.best_remedy()
            if best is None:
                break
            slips.append(replace(best, logs=tuple(seen[k].log for k in logs)))
            now = {k: Expected(robot, best.remedy.undo(state.expected[k].seen)) for k in logs}
            state = _State(robot, [now.get(k, each) for k, each in enumerate(state.expected)])
    slips = [replace(each, settled=each in first or state.explains(each)) for each in slips]
    said = [each for each in slips if each.settled or state.halves(each, as_read)]
    touched = {(joint, log) for slip in said for joint in slip.remedy.joints for log in slip.logs}
    sought = len(said) < criteria.most_slips  # else there is more to find
    mended = state.expected if said == slips else [Expected(robot, _mended(each, said)) for each in seen]
    unlike = [*unlike_axes(mended, touched)] if sought else []
    odd = {(log,) for each in unlike for log in each.logs} if len(seen) > 1 else set()  # wrong otherwise as well
    return [replace(each, settled=each.settled and each.logs not in odd) for each in said], unlike, as_read


def gravity_left_out(robot: Robot, expected: Sequence[Expected]) -> Slip | None:
    """Bodies that are off by what is stated may hide that efforts bear no weight: so it is asked for where nothing
    else is wrong, too."""
    if robot.tree.floating or not expected:
        return None
    state, remedy = _State(robot, expected), without_gravity(robot)
    evidence = state.gain(remedy)
    if evidence < state.criteria.decisive or not state.mends(remedy):
        return None
    return Slip(remedy, evidence, *state.worst_of(remedy), logs=tuple(each.seen.log for each in expected))


def unsure_signs(robot: Robot, expected: Sequence[Expected]) -> dict[int, bool]:
    """Joints of which neither these logs nor robot.yaml tell whether position and effort are both turned, as the last
    of an arm that is round about its axis, and whether they fit better so. Friction does not tell: both turn."""
    if not expected:
        return {}
    state = _State(robot, expected)
    checked = {joint for joint, its in enumerate(robot.joints) if its.sign_checked}
    gains, least = state.gains_of_turned(checked), state.criteria.undecided
    return {remedy.joints[0]: gain > least for remedy, gain in gains.items() if gain > -least}


def reversed_efforts(one: Expected) -> list[Slip]:
    """Of one log, whatever else acts in it: efforts that fit with their sign turned, and as they are neither with any
    factor nor half as well. A device would have to pull with twice what the joint bears, and feed its friction."""
    criteria, found = one.seen.criteria, list[Slip]()
    coupled_axes = coupled(one.robot)
    for axis in range(len(one.robot.joints)):
        if not one.tells(axis) or len(coupled_axes[axis]) > 1:
            continue
        now, turned = one.likelihood(axis), one.likelihood(axis, -1.0, near=True)
        before, evidence = one.left(axis)[0], turned.described - now.any
        if evidence > criteria.decisive and turned.misfit <= criteria.halved * before:
            found.append(Slip(reversals(axis)[0], evidence, before, turned.misfit, logs=(one.seen.log,)))
    return found


def _mended(seen: Snapshot, slips: Sequence[Slip]) -> Snapshot:
    for slip in slips:
        seen = slip.remedy.undo(seen) if seen.log in slip.logs else seen
    return seen


def _beyond_limits(robot: Robot, seen: Sequence[Snapshot]) -> list[Slip]:
    """Positions far beyond their joint's limits, or far faster, that are neither in another unit: that needs no
    comparison of loads, which such positions put out of reason everywhere.
    """
    slips = []
    for joint in range(len(robot.joints)):
        fits = [
            remedy
            for remedy in misread_positions(robot, joint)
            if remedy.rule == "position_scale" and (remedy.value or 0.0) > 1.0
            and all(_impossible(robot, each, joint) for each in seen)
            and not any(_impossible(robot, remedy.undo(each), joint) for each in seen)
        ]  # fmt: skip
        if fits and seen:
            slips.append(Slip(fits[0], np.inf, 1.0, 0.0, logs=tuple(each.log for each in seen)))
    return slips


def _impossible(robot: Robot, seen: Snapshot, joint: int) -> bool:
    tree = robot.tree
    span, fastest = tree.upper[joint] - tree.lower[joint], tree.velocity_limit[joint]
    too_wide = 0.0 < span < np.inf and float(np.ptp(seen.q[:, joint])) > seen.criteria.far * span
    too_fast = 0.05 < fastest < np.inf and float(np.abs(seen.dq[:, joint]).max()) > seen.criteria.far * fastest
    return bool(too_wide or too_fast)


@final
class _State:
    """The logs as they would be, with what was found so far undone."""

    def __init__(self, robot: Robot, expected: Sequence[Expected], others: Sequence[Expected] = ()) -> None:
        """others: the logs beside these, where these are some of several."""
        self.robot, self.expected, self._others, self._every = robot, expected, others, not others
        self.seen = [each.seen for each in expected]
        self.criteria = self.seen[0].criteria if self.seen else Comparing()
        self._undone: tuple[Remedy, list[Expected]] | None = None
        self._first = _of_the_base(robot)
        self._related, self._coupled, self._limbs = related(robot), coupled(robot), alike_limbs(robot)

    def others(self, logs: Sequence[int]) -> list[Expected]:
        """All but these, by number."""
        return [each for k, each in enumerate(self.expected) if k not in logs]

    def best_remedy(self) -> Slip | None:
        doubted = self.doubted()
        unseen = self.gains_of_turned(set(doubted)) | self._gains_of_exchanged() if self._every else {}
        tried, kinds = list(unseen.items()), (self.plain_remedies, self.rare_remedies) if doubted else ()
        for kind in (None, *kinds):
            tried += [(remedy, self.gain(remedy)) for remedy in self.worth_trying(kind(doubted))] if kind else []
            tried = sorted((each for each in tried if each[1] > self.criteria.decisive), key=lambda each: -each[1])
            tried = list(dropwhile(lambda each: not self.mends(each[0]), tried))
            if kind and tried and self.explained_with(tried[0][0]):
                break  # nothing else need be tried
        if not tried:
            return None
        remedy, evidence = tried[0]
        rivals = self._turned_as_well(remedy, tried)
        return Slip(
            self.sharpened(remedy), evidence, *self.worst_of(remedy), self.as_good(remedy, tried), rivals=rivals
        )

    def _turned_as_well(self, best: Remedy, tried: Sequence[tuple[Remedy, float]]) -> tuple[int, ...]:
        """Other joints that may be turned in its place: an arm whose base and wrist are turned is its mirror image."""
        least = dict(tried)[best] - self.criteria.undecided
        rivals = [each for each, gain in tried if each.rule == best.rule == "joint_reversed" and gain > least]
        return tuple(each.joints[0] for each in rivals if each is not best and self.mends(each))

    def gains_of_turned(self, but: Set[int] = frozenset()) -> dict[Remedy, float]:
        """Of every joint that moves, what it gains with position and effort turned; not of those that by bodies as
        described are surely as they should be. A joint that bears little is in no doubt even so: other bodies make up
        for most of it, and friction does not tell, as both turn. but: joints that are left out."""
        likely = -self.criteria.decisive
        remedies = [reversals(j)[2] for j in self.axes() if len(self._coupled[j]) == 1 and j not in but]
        if not remedies:
            return {}
        screened = Screen(self.robot, self.seen, self.axes()).gains(
            remedies, [self._touched(each) for each in remedies]
        )
        return {each: self.gain(each) for each, gain in zip(remedies, screened, strict=True) if gain > likely}

    def _gains_of_exchanged(self) -> dict[Remedy, float]:
        """Of two joints of which one carries the other, positions and efforts of both: two of an arm may be so alike
        that neither is in doubt, as other bodies make up for it."""
        single = [j for j in self.axes() if len(self._coupled[j]) == 1]
        remedies = [exchanged([i], [j])[2] for i, j in combinations(single, 2) if j in self._related[i]]
        return {each: self.gain(each) for each in self.worth_trying(remedies)} if remedies else {}

    def worst_of(self, remedy: Remedy) -> tuple[float, float]:
        """What is left at the worst of its joints, as it is and with the remedy."""
        axis = max(remedy.joints, key=lambda each: pooled(self.expected, each).misfit)
        return pooled(self.expected, axis).misfit, pooled(self.undone(remedy), axis).misfit

    def sharpened(self, remedy: Remedy) -> Remedy:
        """Of a zero that was tried in wide steps, the angle itself."""
        if remedy.rule != "position_offset" or remedy.value is None:
            return remedy
        (joint,) = remedy.joints

        def at(angle: float) -> Remedy:
            return replace(remedy, undo=shifted(joint, angle), value=-angle)

        _, angle = climb(lambda angle: self.gain(at(angle)), -remedy.value, self.criteria.zero_step)
        return at(angle)

    def undone(self, remedy: Remedy) -> list[Expected]:
        """The logs with a remedy; kept for the next question about the same."""
        if self._undone is None or self._undone[0] is not remedy:
            self._undone = remedy, [Expected(self.robot, remedy.undo(seen)) for seen in self.seen]
        return self._undone[1]

    def mends(self, remedy: Remedy) -> bool:
        """No more is left at its own joints than before: what only others gain by is something else that is missing.
        So it is where none of its own moves then: what is left of them nobody sees.
        A factor of an effort leaves its joint in no doubt: of what is not described a large load explains a part, too.
        """
        then = self.undone(remedy)
        before, after = (
            [pooled(each, axis).misfit for axis in remedy.joints if any(one.tells(axis) for one in each)]
            for each in (self.expected, then)
        )
        most = self.criteria.misfit if remedy.rule == "effort_scale" else max(before, default=0.0)
        return bool(after) and max(after) <= most

    def as_good(self, best: Remedy, tried: Sequence[tuple[Remedy, float]]) -> Remedy | None:
        """Of the same joints, one that the data do not tell from the best."""
        if best.rule == "efforts_exchanged":  # two that are built alike bear alike: the positions may be the other's
            half = len(best.joints) // 2
            other = exchanged(best.joints[:half], best.joints[half:])[1]
            moving = [Expected(self.robot, other.undo(each.seen)).moving & each.moving for each in self.expected]
            close = self.gain(best, moving) - self.gain(other) < self.criteria.undecided
            return other if close else None
        least = dict(tried)[best] - self.criteria.undecided
        if best.up is not None:  # the zero of a joint that carries all turns gravity, too
            zeros = (each for j in self._first for each in zeros_in_eighths(j))
            return next((each for each in zeros if self.gain(each) > least), None)
        rivals = (each for each, its in tried if each is not best and its > least and each.joints == best.joints)
        return next(rivals, None)

    def explained_with(self, remedy: Remedy) -> bool:
        """Whether no axis stays in doubt with it that is now, or that it touches; a factor of an effort hides much."""
        then = _State(self.robot, self.undone(remedy), self._others)
        asked = {*self._touched(remedy), *self.doubted()}
        return remedy.rule != "effort_scale" and not any(then.in_doubt(axis) for axis in asked)

    def explains(self, slip: Slip) -> bool:
        """Whether its joints are in no doubt, in its logs."""
        logs = [k for k, each in enumerate(self.seen) if each.log in slip.logs]
        part = _State(self.robot, [self.expected[k] for k in logs])
        return not any(part.in_doubt(axis) for axis in slip.remedy.joints if axis in part.axes())

    def halves(self, slip: Slip, as_read: Sequence[Expected]) -> bool:
        """Whether what is left of its joints' efforts, in its logs, falls by half at one of them: else it was of no
        use, and what it undoes is no name for what is wrong.
        """
        logs = [k for k, each in enumerate(self.seen) if each.log in slip.logs]
        before, after = ([every[k] for k in logs] for every in (as_read, self.expected))
        axes = [a for a in slip.remedy.joints if any(each.tells(a) for each in (*before, *after))]
        return any(
            pooled(after, a, near=True).misfit <= self.criteria.halved * pooled(before, a, near=True).misfit
            for a in axes
        )

    def axes(self) -> list[int]:
        return [a for a in range(len(self.robot.joints)) if any(each.tells(a) for each in self.expected)]

    def doubted(self) -> list[int]:
        """Axes that do not bear what is described, the worst first."""
        found = dict[int, float]()
        for axis in self.axes():
            if self.in_doubt(axis):
                found[axis] = pooled(self.expected, axis).misfit
        return sorted(found, key=lambda axis: -found[axis])[: self.criteria.most_doubted]

    def in_doubt(self, axis: int) -> bool:
        """Too much is left, another factor or the other sign explains more, or in other logs far less is left."""
        now = pooled(without_the_worst(self.expected, axis), axis)
        if now.any - now.described > self.criteria.doubted or now.misfit > self.criteria.misfit:
            return True
        turned = pooled(without_the_worst(self.expected, axis), axis, -1.0, near=True)
        if turned.described - now.described > self.criteria.doubted:
            return True
        return now.misfit > min(self.criteria.unmodelled) and self.is_odd(axis)

    def is_odd(self, axis: int) -> bool:
        """Far more of it is left here than in the other logs."""
        return any(stands_out(each, self._others, axis) for each in self.expected)

    def plain_remedies(self, doubted: Sequence[int]) -> list[Remedy]:
        """Signs, factors of efforts, exchanged efforts: what most often is wrong, and soon tried.

        A factor is in all logs, as a unit is: of a single one among several none is tried.
        """
        found = [remedy for joint in doubted for remedy in reversals(joint)]
        if self._every and not self.robot.tree.floating:
            found += [*other_gravity(self.robot), without_gravity(self.robot)]
        found += [exchanged([one], [other])[0] for one, other in combinations(doubted, 2)]
        found += [exchanged(*limbs)[0] for limbs in self._limbs]
        for joint in doubted:
            for sign in (1.0, -1.0) if self._every and len(self._coupled[joint]) == 1 else ():
                beyond = pooled(self.expected, joint, sign)
                if beyond.any > beyond.described and self.over_other_bodies(joint, sign) > 0.0:
                    found.append(scaled_effort(joint, sign * beyond.gain))
        return found

    def over_other_bodies(self, joint: int, sign: float) -> float:
        """Log likelihood of a factor of an effort over bodies that are off by as much: these are as free as a factor
        leaves them, and explain what has nothing to do with the joint.
        """
        telling = [each.with_other_bodies(joint, sign) for each in self.expected if each.tells(joint)]
        return pooled(self.expected, joint, sign).any - together(telling, self.criteria.as_good_as).any

    def rare_remedies(self, doubted: Sequence[int]) -> list[Remedy]:
        """Of all joints whose position moves the load of one in doubt: what is wrong there may show elsewhere alone.

        Of a single log among several those in doubt alone, and exchanges with one that stands out: a mapping's slip is
        in all of them.
        """
        near = [j for j in range(len(self.robot.joints)) if not self._related[j].isdisjoint(doubted)]
        about = near if self._every else list(doubted)
        found = [remedy for joint in about for remedy in misread_positions(self.robot, joint)]
        found += [remedy for joint in set(about) - set(doubted) for remedy in reversals(joint)[1:]]
        sure = {j for j in about if self._every or self.is_odd(j)}
        either = [each for each in combinations(near, 2) if set(each) & sure or set(each) <= set(about)]
        pairs = [*(((one,), (other,)) for one, other in either), *self._limbs]
        return found + [remedy for ones, others in pairs for remedy in exchanged(ones, others)[1:]]

    def worth_trying(self, remedies: Sequence[Remedy]) -> list[Remedy]:
        """Without those of positions that a fit with bodies as described holds for worse than others."""
        efforts = [each for each in remedies if each.kind == "effort"]
        positions = [each for each in remedies if each.kind != "effort"]
        touched = [self._touched(each) for each in positions]
        return efforts + Screen(self.robot, self.seen, self.axes()).best(positions, touched)

    def gain(self, remedy: Remedy, moving: Sequence[NDArray[np.bool_]] | None = None) -> float:
        """In log likelihood of all that the remedy changes, less what its rarity costs.

        moving: the moments of each log that count, (N, A) each; default those in which axes move by both readings.
        """
        axes = self._touched(remedy)
        if remedy.rule == "effort_scale":
            (joint,), value = remedy.joints, remedy.value or 1.0
            beyond = pooled(self.expected, joint, float(np.sign(value)))
            return beyond.any - pooled(self.expected, joint).described - remedy.cost
        undone = [remedy.undo(each) for each in self.seen]
        if remedy.kind == "effort":
            now = self.expected
            if moving is not None:
                now = [each.at(some) for each, some in zip(now, moving, strict=True)]
            then = [each.with_effort(seen) for each, seen in zip(now, undone, strict=True)]
        elif len(remedy.joints) == 1:
            now = self.expected
            then = [Expected(self.robot, seen, each.moving) for each, seen in zip(now, undone, strict=True)]
        else:  # the same moments count for both
            then = [Expected(self.robot, seen) for seen in undone]
            both = [one.moving & other.moving for one, other in zip(self.expected, then, strict=True)]
            now, then = (
                [each.at(some) for each, some in zip(each_way, both, strict=True)] for each_way in (self.expected, then)
            )
        change = (pooled(then, axis, near=True).described - pooled(now, axis, near=True).described for axis in axes)
        return sum(change) - remedy.cost

    def _touched(self, remedy: Remedy) -> list[int]:
        telling = set(self.axes())
        if remedy.kind == "effort":
            return sorted(telling & set().union(*(self._coupled[joint] for joint in remedy.joints)))
        return sorted(telling & set().union(*(self._related[joint] for joint in remedy.joints)))


def _of_the_base(robot: Robot) -> list[int]:
    """Joints that no other carries."""
    carried, tree = robot.tree.subtree, robot.tree
    moved = [int(i) for i in np.flatnonzero(tree.dof >= 0)]
    return [int(tree.dof[i]) for i in moved if not any(carried[k, i] for k in moved if k != i)]
