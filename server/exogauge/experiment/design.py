"""Which motion would tell a finding from what else it may be, computed before anybody moves the robot.

What sets two effects apart is what is left of one once the whole baseline and the other one, in whichever of its shapes
fits best, are fitted again. Every motion adds its rows, by the model's own regressor, to those of the logs; the Schur
complement of both together then says what would be left.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.effects.order import LOG
from exogauge.experiment.motion_choices import Choice, choices
from exogauge.experiment.moving_choices import Moving, moving_choices
from exogauge.experiment.planned_rows import NewRows, as_log, new_rows, with_next_log
from exogauge.experiment.reach import Reach, asked_of, reach_of
from exogauge.experiment.varied import climbed, nearby
from exogauge.experiment.workspace_limits import Room, room
from exogauge.findings.planned_motion import Apart, Bound, PlannedMotion
from exogauge.findings.result import Finding, Place
from exogauge.identification.model import RobotModel
from exogauge.identification.sites import AxisSite, SensorSite
from exogauge.logs.model import Log
from exogauge.robots.moving.robot import MotionRobot
from exogauge.search.ambiguity import Contender, Undecided

Array = NDArray[np.float64]
IntArray = NDArray[np.intp]

OVER_TIME = ("time", "temperature")  # coordinates of effects that need minutes


@final
@dataclass(frozen=True)
class Outcome:
    """pairs: one for every rival. motions: that tell those apart that can be told apart, one where one will do."""

    pairs: tuple[Apart, ...]
    motions: tuple[PlannedMotion, ...]


def tell_apart(doubt: Undecided, logs: Sequence[Log], moving: MotionRobot | None = None) -> Outcome | None:
    """logs: that were fitted. moving: the robot with soles, shapes and home, as far as its file tells them; without it
    one joint is swept, and within its own bounds alone. None where no motion can be planned: the joint carries the
    robot, its feet's sensors are in question, only one log has the effect, or the logs move too little to say what the
    robot may do."""
    if not can_be_planned(doubt):
        return None
    here, known = room(doubt.model, logs), Known.of(doubt)
    reach = None if moving is None else reach_in(moving, doubt.model, here)
    weighing = Weighing.of(known, here, reach)
    tried = weighing.tries()
    if not tried:
        return None
    everyone, criteria = range(1, len(doubt.contenders)), doubt.model.criteria.planning
    apart: dict[int, Apart] = {}
    motions: list[PlannedMotion] = []
    closest = {k: known.pair(k, _closest(tried, k), 1) for k in everyone}
    climbed_for = set[int]()
    while left := {k for k in everyone if k not in apart and any(each.repeats[k] is not None for each in tried)}:
        if left != climbed_for:
            tried, climbed_for = [*tried, *weighing.better(tried, left)], left
        best = min(tried, key=lambda each: each.cost(left, weighing.priced))
        told = {k for k in left if best.repeats[k] is not None}
        many = max(criteria.shortest_s / best.seconds, *(best.repeats[k] or 0.0 for k in told), 1.0)
        repeats = int(np.ceil(many - 1e-3))  # a sample less is as long
        pairs = {k: known.pair(k, best, repeats) for k in told}
        motion = _motion(doubt, here, best, repeats, [pairs[k] for k in sorted(told)], reach)
        if reach is not None and not reach.keeps(motion.q, criteria.handed_hz, criteria.checked_hz):
            tried = [each for each in tried if each is not best]
            continue
        apart |= pairs
        motions.append(motion)
    apart = closest | apart
    return Outcome(tuple(apart[k] for k in everyone), tuple(motions))


def can_be_planned(doubt: Undecided) -> bool:
    """Not where an effect is in one log alone, or the feet's sensors are in question."""
    effects = [each.candidate for each in doubt.contenders if isinstance(each, Contender)]
    if any(_in_one_log(each.effect.shapes, each.shape) for each in effects):
        return False
    sites = [each.site for each in effects]
    return not any(isinstance(site, SensorSite) and site.contact for site in sites)


@final
@dataclass(frozen=True)
class Weighing:
    """What motions would do. model: for which the planned log comes next. priced: whether what is awkward of a motion
    counts, as not all of its bounds are known."""

    known: Known
    model: RobotModel
    here: Room
    reach: Reach | None

    @staticmethod
    def of(known: Known, here: Room, reach: Reach | None) -> Weighing:
        return Weighing(known, with_next_log(known.doubt.model), here, reach)

    @property
    def priced(self) -> bool:
        return self.reach is None or bool(self.reach.unknown)

    def tries(self) -> list[Tried]:
        """Every motion that is considered, with what it would do."""
        contenders = self.known.doubt.contenders
        effects = [each.candidate for each in contenders if isinstance(each, Contender)]
        slow_change = any(each.effect.coordinate in OVER_TIME for each in effects)
        kinds = {kind for each in contenders for kind in each.kinds(self.model.equations)}
        axes = [each.site.axis for each in effects if isinstance(each.site, AxisSite)]
        possible = _possible(self.model, self.here, sorted(kinds), axes, slow_change, self.reach)
        return [tried for choice in possible if (tried := self._tried(choice)) is not None]

    def better(self, tried: Sequence[Tried], rivals: set[int]) -> list[Tried]:
        """The best sweep, the best motion of the whole robot and the best of both at once, each changed until it tells
        more of `rivals` a second."""

        def changed(each: Tried, rng: np.random.Generator, size: float) -> Tried | None:
            choice = nearby(each.choice, rng, size, self.model, self.here)
            return None if choice is None or not self._keeps(choice) else self._tried(choice)

        def worth(each: Tried) -> tuple[int, float]:
            untold, cost = each.cost(rivals, self.priced)
            return -untold, -cost

        sorts = dict[str, list[Tried]]()
        for each in tried:
            if any(each.repeats[k] is not None for k in rivals):
                sorts.setdefault(each.sort, []).append(each)
        criteria = self.model.criteria.planning
        times = criteria.varied_standing if self.model.robot.floating else criteria.varied
        return [climbed(max(some, key=worth), changed, worth, criteria, times) for some in sorts.values()]

    def _tried(self, choice: Choice | Moving) -> Tried | None:
        rows = new_rows(self.known.doubt, self.model, self.here, choice, self.known.kept)
        return None if rows is None else Tried.of(self.known, choice, rows)

    def _keeps(self, choice: Choice | Moving) -> bool:
        hz = self.model.criteria.planning.looked_hz
        if isinstance(choice, Moving):
            return choice.keeps(hz)
        return self.reach is None or self.reach.keeps(choice.positions(self.here.posture, hz), hz, hz)


@final
@dataclass(frozen=True)
class Known:
    """What the logs say, over the R parameters that the rows in question hold; kept: (R,) which.

    root: (R, R) of their covariance from data and prior, all other parameters fitted. taken: (R, C) by how much
    the baseline moves for each column. now: (C, C) products of what it leaves of them.
    """

    doubt: Undecided
    kept: IntArray
    root: Array
    taken: Array
    now: Array

    @staticmethod
    def of(doubt: Undecided) -> Known:
        model = doubt.model
        own, free = model.equations.columns(), model.solution.prior.free
        kinds = {kind for each in doubt.contenders for kind in each.kinds(model.equations)}
        kept = np.intersect1d(np.concatenate([own[kind] for kind in sorted(kinds)]), free)
        unit = np.zeros((model.equations.size, len(kept)))
        unit[kept, np.arange(len(kept))] = 1.0
        covariance = model.solution.unbounded.divided(unit)[kept]
        size, B = np.sqrt(np.diag(covariance)), doubt.B[kept]
        scaled, V = np.linalg.eigh(covariance / np.outer(size, size))
        root = size[:, None] * V * np.sqrt(np.maximum(scaled, 0.0))
        taken = root @ (root.T @ B)
        return Known(doubt, kept, root, taken, doubt.S - B.T @ taken)

    def after(self, rows: NewRows) -> _After:
        """What repeats of a motion would leave. What its rows say is what the logs did not foretell."""
        nothing = 1e-12  # of the largest information
        G, fresh = rows.A @ self.root, rows.c - rows.A @ self.taken
        if len(G) <= G.shape[1]:
            D, U = np.linalg.eigh(G @ G.T)
            along = U.T @ fresh
        else:
            D, V = np.linalg.eigh(G.T @ G)
            least = max(nothing * float(D.max()), 1e-300)  # where the rows hold none of the parameters nothing is along
            along = (V.T @ (G.T @ fresh)) / np.sqrt(np.maximum(D, least))[:, None]
        return _After(self.now, fresh.T @ fresh - along.T @ along, np.maximum(D, 0.0), along)

    def evidence(self, k: int, L: Array) -> float:
        """That sets rival k apart from the finding [twice the log likelihood], whichever of the two is true."""
        left = min(self._apart(true, instead, L)[0] for true, instead in self._truths(k))
        return left / (self.doubt.noise * self.doubt.memory)

    def _truths(self, k: int) -> list[tuple[int, int]]:
        """(true, instead); a rival that is fitted much smaller than the finding is not what there is."""
        least = self.doubt.model.criteria.planning.much_smaller
        as_large = self._apart(k, 0, self.now)[1] > least * self._apart(0, k, self.now)[1]
        return [(0, k), (k, 0)] if as_large else [(0, k)]

    def _apart(self, true: int, instead: int, L: Array) -> tuple[float, float]:
        """Square sum that is left of the true one beside the other one's best shape, and without the other one."""
        swallowed = 1e-9  # share of a column that counts as none
        contender, rival, parts = self.doubt.contenders[true], self.doubt.contenders[instead], self.doubt.parts
        own = slice(parts[true].start, parts[true].start + contender.own_width)
        theta, wide = contender.coefficients, rival.own_width
        whole, lost = float(theta @ L[own, own] @ theta), 0.0
        for start in range(parts[instead].start, parts[instead].stop, wide):
            other = slice(start, start + wide)
            size = np.sqrt(np.maximum(np.diag(self.doubt.S)[other], 1e-300))
            U, g = L[other, other] / np.outer(size, size), (L[other, own] @ theta) / size
            instead_of = np.linalg.pinv(U, rcond=swallowed, hermitian=True) @ g
            if rival.limits is not None and U[0, 0] > swallowed:  # a friction that would have to push is no rival
                low, high = rival.limits
                instead_of = np.clip(g / U[0], low * size, high * size)
            lost = max(lost, float(2.0 * g @ instead_of - instead_of @ U @ instead_of))
        return max(whole - lost, 0.0), whole

    def pair(self, k: int, tried: Tried, repeats: int) -> Apart:
        rival, then = self.doubt.contenders[k], tried.after.left(repeats)
        true, instead = min(self._truths(k), key=lambda both: self._apart(both[0], both[1], then)[0])
        (left_now, whole_now), (left_then, whole_then) = (self._apart(true, instead, L) for L in (self.now, then))
        now, needed = self.evidence(k, self.now), tried.repeats[k]
        criteria = self.doubt.model.criteria.planning
        return Apart(
            rival=rival.name,
            place=".".join(each for each in rival.place(self.doubt.model.equations)[1:] if each),
            left_now=left_now / whole_now if whole_now > 0.0 else 0.0,
            left_then=left_then / whole_then if whole_then > 0.0 else 0.0,
            evidence_now=now,
            evidence=self.evidence(k, then) - now,
            rate=10.0 * tried.gain[k] / tried.seconds,
            seconds=None if needed is None else needed * tried.seconds,
            enough=criteria.enough,
            longest=criteria.longest_s,
        )


@final
@dataclass(frozen=True)
class _After:
    """What any number of repeats of one motion would leave.

    now: (C, C) products of columns that the logs leave. gain: (D,) information of one repeat over that of the logs, by
    direction. along: (D, C) what the logs did not foretell of the columns there; beyond: (C, C) products of the rest.
    """

    now: Array
    beyond: Array
    gain: Array
    along: Array

    def left(self, repeats: float) -> Array:
        """(C, C) products of what the baseline leaves of all columns."""
        kept = repeats / (1.0 + repeats * self.gain)
        return np.asarray(self.now + repeats * self.beyond + (self.along.T * kept) @ self.along)


@final
@dataclass(frozen=True)
class Tried:
    """A motion and what it would do. seconds: of one repeat. gain: rival -> evidence of one repeat. repeats: rival ->
    how many until it is sure, or None."""

    choice: Choice | Moving
    seconds: float
    after: _After
    gain: dict[int, float]
    repeats: dict[int, float | None]

    @staticmethod
    def of(known: Known, choice: Choice | Moving, rows: NewRows) -> Tried:
        after, everyone = known.after(rows), range(1, len(known.doubt.contenders))
        gain = {k: known.evidence(k, after.left(1.0)) - known.evidence(k, known.now) for k in everyone}
        repeats = {k: _needed(known, after, rows.seconds, k, gain[k]) for k in everyone}
        return Tried(choice, rows.seconds, after, gain, repeats)

    @property
    def sort(self) -> str:
        if isinstance(self.choice, Moving):
            return "moving" if self.choice.swept is None else "both"
        return "sweep"

    def cost(self, rivals: set[int], priced: bool) -> tuple[int, float]:
        """How many it does not tell apart; and of the one that it tells worst the negative evidence a second, over the
        price where that counts."""
        told = [k for k in rivals if self.repeats[k] is not None]
        worth = min((self.gain[k] for k in told), default=0.0) / self.seconds
        return len(rivals) - len(told), -worth / (self.choice.price if priced else 1.0)


def _needed(known: Known, after: _After, seconds: float, k: int, once: float) -> float | None:
    """Repeats until the evidence has grown by `enough`; None where that takes more than `longest_s`."""
    searched = 6  # halvings of that time
    criteria = known.doubt.model.criteria.planning
    if once >= criteria.enough:
        return criteria.enough / once
    now = known.evidence(k, known.now)

    def enough(n: float) -> bool:
        return known.evidence(k, after.left(n)) - now >= criteria.enough

    low, high = 1.0, max(criteria.longest_s / seconds, 1.0)
    if not enough(high):
        return None
    for _ in range(searched):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if enough(middle) else (middle, high)
    return high


def _closest(tried: Sequence[Tried], k: int) -> Tried:
    """The motion that leaves most between the finding and rival k, though not enough."""
    return max(tried, key=lambda each: each.gain[k] / each.seconds)


def _in_one_log(shapes: Sequence[object], values: Sequence[float]) -> bool:
    return any(getattr(shape, "name", "") == LOG and value >= 0.0 for shape, value in zip(shapes, values, strict=True))


def _motion(
    doubt: Undecided, here: Room, best: Tried, repeats: int, pairs: Sequence[Apart], reach: Reach | None
) -> PlannedMotion:
    robot, choice = doubt.model.robot, best.choice
    log = as_log(doubt.model, here, choice, doubt.model.criteria.planning.handed_hz)
    names = tuple(joint.name for joint in robot.joints)
    swept = choice.swept if isinstance(choice, Moving) else choice
    whole = isinstance(choice, Moving)
    q = log.stack([f"q.{name}" for name in names])
    slides = swept is not None and robot.tree.prismatic[int(np.flatnonzero(robot.tree.dof == swept.lead)[0])]
    return PlannedMotion(
        joint="" if swept is None else names[swept.lead],
        companion="" if swept is None or swept.companion is None else names[swept.companion],
        companion_range=(0.0, 0.0) if swept is None else swept.companion_range,
        sweep=None if swept is None else swept.sweep,
        unit="m" if slides else "rad",
        repeats=repeats,
        duration=repeats * best.seconds,
        pairs=tuple(pairs),
        legs_rest=robot.floating and not whole,
        time=log.time,
        joints=names,
        q=q,
        kept=("torque",) if reach is None else reach.kept,
        unknown=_untold(robot.floating) if reach is None else reach.unknown,
        others=()
        if isinstance(choice, Choice)
        else tuple(
            name for k, name in enumerate(names) if np.ptp(q[:, k]) > 0.0 and (swept is None or k != swept.lead)
        ),
    )


def reach_in(moving: MotionRobot, model: RobotModel, here: Room) -> Reach:
    return reach_of(moving, model.robot, here, asked_of(model), model.criteria.planning)


def _untold(floating: bool) -> tuple[Bound, ...]:
    return ("touch", "balance") if floating else ("touch",)


def _possible(
    model: RobotModel, here: Room, kinds: Sequence[int], axes: Sequence[int], slow_change: bool, reach: Reach | None
) -> Iterator[Choice | Moving]:
    """Sweeps of a joint; and, where the robot's file tells its bounds, those that keep them, and motions of the whole
    robot alone and beside one of them."""
    sweeps = choices(model, here, kinds, axes, slow_change)
    if reach is None:
        yield from sweeps
        return
    hz = model.criteria.planning.looked_hz
    kept = [each for each in sweeps if reach.keeps(each.positions(here.posture, hz), hz, hz)]
    yield from kept
    yield from moving_choices(reach, kept, hz)


def with_motions(
    findings: Iterable[Finding], undecided: Mapping[tuple[str, Place], Undecided], logs: Sequence[Log],
    moving: MotionRobot | None = None,
) -> tuple[Finding, ...]:  # fmt: skip
    """undecided: what tells the finding of an effect at a place from what it may be, too. logs: that were fitted. Some
    motions cannot be planned; what the effect needs is known in words. moving: as of `tell_apart`."""
    return tuple(_with_motions(each, undecided.get((each.effect, each.named_at)), logs, moving) for each in findings)


def _with_motions(
    finding: Finding, doubt: Undecided | None, logs: Sequence[Log], moving: MotionRobot | None
) -> Finding:
    found = tell_apart(doubt, logs, moving) if doubt is not None and finding.also_possible else None
    return finding if found is None else replace(finding, apart=found.pairs, plans=found.motions)
