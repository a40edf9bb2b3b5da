"""Which effects are missing: sought where the body is fitted, judged where it is not, added one by one.

Evidence is that of the Bayesian information criterion: of every log and channel half the samples that count times the
logarithm by which their mean square falls, not below the floor; less half that of the samples for every number, less
that of all that was tried. How many samples count as one is read from what the candidate leaves: what is missing makes
residuals remember, and nobody knows for how long before it is found.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.criteria import Criteria
from exogauge.criteria.judging import Carrying
from exogauge.findings.verdict import Caveat, Decision, Facts, Seen, decide
from exogauge.payload.calibration import Calibration
from exogauge.payload.dynamics import correlation_time
from exogauge.payload.missing.doubt import (
    CLOSELY,
    below_floor,
    by_slow_means,
    covariance,
    is_foretold,
    numbers,
    numbers_with_std,
    of_filter,
    of_unexplained,
    slightly_inclined,
    slightly_late,
)
from exogauge.payload.missing.effect import CHANNELS, Effect, Frame
from exogauge.payload.missing.fit import (
    SIZE,
    Fitted,
    Named,
    Problem,
    design,
    fit,
    in_floors,
    left_with,
    residuals,
    with_best_shape,
)
from exogauge.payload.missing.hanging import second_body, spring
from exogauge.payload.missing.sensor_effects import (
    TURNED,
    crosstalk,
    delay,
    inclination,
    low_pass,
    of_all_channels,
    turned_axes,
    zero_between,
    zero_drift,
    zero_of_log,
    zero_step,
)
from exogauge.payload.missing.stretch import Stretch

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Parameter:
    name: str
    unit: str
    value: float
    std: float


@final
@dataclass(frozen=True)
class Finding:
    """evidence: see above. before, after: rms of what was not fitted, in floors. rivals: (effect, place) that explain
    these data as well. parameters: none where errors of the kinematics look like it, so that its size is not told."""

    effect: str
    place: str
    parameters: tuple[Parameter, ...]
    evidence: float
    before: float
    after: float
    rivals: tuple[tuple[str, str], ...]


@final
@dataclass(frozen=True)
class Missing:
    """found: what was named. suspected: what takes something off, while more is left that nothing explains. decision:
    what may be said. before, after: (6,) rms over floor by log. tried: candidates. of_body: whether any of what was
    found changes what is fitted. courses: (T, 6) what of the wrench is that of what was found, of every stretch in the
    order given. doubt: (18, 18) what it adds to the covariance of [body, zero, turn of gravity]. late: [s] by which
    the wrench is late, and std, where that is beyond chance and too little to be named; leans: [rad] by which the base
    leans, where it was taken to be level, and so too; slight_doubt: what that adds.
    calibrated: whether gains and crosstalk of all axes at once stand in place of `courses`."""

    found: tuple[Finding, ...]
    suspected: tuple[Finding, ...]
    decision: Decision
    before: Mapping[str, Array]
    after: Mapping[str, Array]
    tried: int
    of_body: bool = False
    courses: tuple[Array, ...] = ()
    doubt: Array = field(default_factory=lambda: np.zeros((SIZE, SIZE)))
    late: tuple[float, float] | None = None
    leans: tuple[float, float] | None = None
    slight_doubt: Array = field(default_factory=lambda: np.zeros((SIZE, SIZE)))
    calibrated: bool = False

    @property
    def in_the_model(self) -> bool:
        """Whether all else may be told with it: named, of a known size, and nothing else explains as much."""
        sure = self.calibrated or all(each.parameters and not each.rivals for each in self.found)
        return bool(self.found) and sure

    @property
    def of_sensor(self) -> bool:
        """Whether all that was named, and what explains as much, is a gain or a crosstalk of the sensor; or a turn of
        its axes beside these."""
        shares = ("gain", "crosstalk")
        return any(name in shares for name in self._names) and all(name in (*shares, TURNED) for name in self._names)

    @property
    def turned(self) -> bool:
        """Whether axes that stand off were named, or explain as much as what was."""
        return TURNED in self._names

    @property
    def _names(self) -> list[str]:
        return [name for each in self.found for name in (each.effect, *(effect for effect, _ in each.rivals))]

    def with_sensor(self, found: Calibration, left: Mapping[str, Array], criteria: Criteria) -> Missing:
        """With gains and crosstalk of all axes at once. left: (6,) rms over floor by log, with them. What was named
        alone, and nothing else, stays so."""
        if not self.found or len(self.found) > 1 or self.found[0].rivals:
            logs = [name for name in left if name in self.before]
            before, after = (
                float(np.sqrt(np.mean([ratios[name] ** 2 for name in logs]))) for ratios in (self.before, left)
            )
            shares = tuple(_shares(found, criteria))
            rivals = ((TURNED, "sensor"),) if self.turned else ()
            finding = Finding("calibration", "sensor", shares, found.evidence, before, after, rivals)
            here = replace(self, found=(finding,), suspected=())
        else:
            here = self
        whole = "nothing" if self.decision.left == "above" else self.decision.left
        decision = replace(self.decision, verdict="effects", left=whole)
        return replace(here, after=left, decision=decision, of_body=True, courses=(), calibrated=True)


@final
@dataclass(frozen=True)
class _Candidate:
    named: Named
    evidence: float
    before: float
    after: float


def _shares(found: Calibration, criteria: Criteria) -> Iterator[Parameter]:
    """What is sure: gains against their mean, as what all share is a mass to the data, and crosstalk."""
    J = np.eye(36)
    J[np.ix_(range(0, 36, 7), range(0, 36, 7))] -= 1.0 / 6.0
    _, C = found.known(found.body)
    value, std = J @ found.taken.ravel(), np.sqrt(np.diag(J @ C @ J.T))
    for k in np.argsort(-np.abs(value) / std):
        if abs(value[k]) > criteria.judging.sure * std[k]:
            effect = crosstalk(*divmod(int(k), 6))
            yield Parameter(effect.place, effect.parameters[0][1], float(value[k]), float(std[k]))


def unjudged(reason: Caveat) -> Missing:
    """Where nothing could be looked for."""
    return Missing((), (), Decision("undecided", "open", reason), {}, {}, 0)


def find_missing(
    fitted: Sequence[Stretch], held_out: Sequence[Stretch], others: Sequence[Stretch], frame: Frame, inclined: bool,
    criteria: Criteria,
) -> Missing:  # fmt: skip
    """fitted: postures, and motion. held_out: motion that decides nothing but what may be claimed. others: in which
    something may touch, so that they decide nothing at all."""
    latest = criteria.payload.latest_s
    fitted, held_out = (
        [each if each.still else each.using(each.inside(latest) & each.inside(-latest)) for each in some]
        for some in (fitted, held_out)
    )
    problem = Problem(fitted, frame, inclined, criteria)
    effects = catalogue(fitted, inclined, criteria.payload)
    named: list[Named] = []
    claims: list[tuple[_Candidate, tuple[tuple[str, str], ...]]] = []
    problem, base = _settled(problem, named)
    first_problem, first = problem, base
    while len(named) < criteria.payload.most and _stands_out(problem, named, base):
        best = _best(problem, named, base, effects, held_out)
        if not best:
            break
        winner = best[0]
        rivals = tuple((each.named.effect.name, each.named.effect.place) for each in best[1:]
                       if winner.evidence - each.evidence < criteria.payload.rival)  # fmt: skip
        named.append(by_slow_means(problem, named, winner.named) if winner.named.effect.swings else winner.named)
        claims.append((winner, rivals))
        _again(problem, named)
        problem, base = _settled(problem, named)
    filtered = _filtered(problem, base, named)
    if filtered is not None:
        named.append(Named(low_pass(filtered[0]), ()))
        problem, base = _settled(problem, named)
    found = [_told(problem, base, named, k, *claim, filtered) for k, claim in enumerate(claims)]
    own = [each for stretch in held_out for each in _of_its_own(problem, base, named, stretch)]
    logs = [*(each for each in fitted if not each.still), *held_out]
    before = {each.name: _ratios(first_problem, first, [], each) for each in logs}
    after = {each.name: _ratios(problem, base, named, each, own) for each in logs}
    found += [finding for finding, _, _ in own]
    foretold = {each.name: is_foretold(problem, base, named, each) for each in logs}
    seen = tuple(
        Seen(f"{log.name}: {channel}", float(ratio), _seconds(log), _seconds(log))
        for log in logs for channel, ratio, sure in zip(CHANNELS, after[log.name], foretold[log.name], strict=True)
        if sure
    )  # fmt: skip
    above = tuple(each.channel for each in seen if each.ratio > criteria.judging.above)
    # What leaves something may stand for what stands in no list: another zero takes a part off whatever is wrong.
    claimed, suspected = (tuple(found), ()) if not above else ((), tuple(found))
    cannot = tuple(Caveat("not_foretold", name) for name, sure in foretold.items() if not sure.all())
    cannot = cannot if held_out else (Caveat("not_held_out"), *cannot)
    facts = Facts(len(claimed), above, seen, cannot=cannot, judging=criteria.judging)
    courses = tuple(_course(problem, base, named, each, own) for each in (*fitted, *held_out, *others))
    C = covariance(problem, base, named)
    across = C[:SIZE, SIZE:]
    doubt = across @ np.linalg.pinv(C[SIZE:, SIZE:]) @ across.T
    late = None
    if all(each.effect.name != "delay" for each in named):
        late = slightly_late(problem, base, named, delay(criteria.payload))
    slight = np.zeros((SIZE, SIZE)) if late is None else late[2]
    doubt = doubt if filtered is None else doubt + filtered[2]
    leans = None
    if not inclined and all(each.effect.name != "inclination" for each in named):
        leans, turned = slightly_inclined(problem, base, named)
        slight = slight + turned
    told = Missing(
        claimed, suspected, decide(facts), before, after, len(effects), bool(named), courses, doubt + slight,
        late and late[:2], leans, slight,
    )  # fmt: skip
    if told.decision.verdict == "unexplained" or (told.found and not told.in_the_model):
        more = of_unexplained(first_problem)
        told = replace(told, doubt=told.doubt + more, slight_doubt=told.slight_doubt + more)
    return told


def _filtered(problem: Problem, base: Fitted, named: Sequence[Named]) -> tuple[float, float, Array] | None:
    """Of the filter that delays the wrench, where that was named."""
    of = [k for k, each in enumerate(named) if each.effect.retimed]
    return of_filter(problem, named, float(numbers(problem, base, named, of[0])[0])) if of else None


def _course(
    problem: Problem, found: Fitted, named: Sequence[Named], stretch: Stretch,
    own: Sequence[tuple[Finding, str, Array]],
) -> Array:  # fmt: skip
    """(T, 6) what of a wrench is not that of the body, the zero and noise; NaN where it is of a time before the log or
    after it."""
    rigid = design(problem.frame, stretch, []) @ found.x[:SIZE]
    course = stretch.wrench - residuals(problem.frame, stretch, named, found.x) - rigid
    course = course + sum(wrench for _, log, wrench in own if log == stretch.name)
    inside = stretch.still | stretch.inside(sum(each.shape[0] for each in named if each.effect.retimed))
    return np.asarray(np.where(inside[:, None], course, np.nan))


def catalogue(fitted: Sequence[Stretch], inclined: bool, criteria: Carrying) -> list[Effect]:
    moved = [each for each in fitted if not each.still]
    hanging = [second_body(criteria), *(spring(axes, criteria) for axes in ("xy", "xz", "yz", "xyz"))]
    out = [delay(criteria), zero_drift(), *hanging]
    out += [] if inclined else [inclination()]
    out += [*of_all_channels(criteria), turned_axes(criteria)]
    out += [zero_of_log(each.name) for each in moved if len(fitted) > 1]
    out += [zero_step(each.name, each.time) for each in moved]
    out += [zero_between(each) for each in fitted if each.still and len(each.wrench) > 3]
    return out


def _settled(problem: Problem, named: Sequence[Named]) -> tuple[Problem, Fitted]:
    """The fit with columns made of its own body, and with as many samples as one as their residuals remember."""
    for _ in range(2):
        found = fit(problem, named)
        stretches = [
            each if each.still else replace(each, memory=correlation_time(left))
            for each, left in zip(problem.stretches, in_floors(problem, found.residual), strict=True)
        ]
        problem = problem.of(stretches).at(found.x[:10])
    return problem, fit(problem, named)


def _again(problem: Problem, named: list[Named]) -> None:
    """Single shapes of those that were named before the last, beside all: they stood for a part of it."""
    for k, each in enumerate(named[:-1]):
        if len(each.effect.bounds) == 1:
            others = [*named[:k], *named[k + 1 :]]
            starts = [each.shape, *each.effect.starts]
            named[k] = with_best_shape(problem, others, fit(problem, others), each.effect, starts)


def _stands_out(problem: Problem, named: Sequence[Named], base: Fitted) -> bool:
    """Whether any log's channel is above its floor by more than its samples' chance: there a name is looked for."""
    for values in in_floors(problem, base.residual):
        chance = np.sqrt(2.0 * correlation_time(values) / len(values))
        if np.any(np.mean(values**2, axis=0) > 1.0 + problem.criteria.judging.sure_above * chance):
            return True
    return False


def _best(
    problem: Problem, named: Sequence[Named], base: Fitted, effects: Sequence[Effect], held_out: Sequence[Stretch]
) -> list[_Candidate]:
    """What may be claimed, most evidence first."""
    taken = {(each.effect.name, each.effect.place) for each in named}
    coarse = problem.coarse()
    on_coarse = fit(coarse, named)
    scored = []
    for effect in effects:
        if (effect.name, effect.place) in taken:
            continue
        candidate = with_best_shape(coarse, named, on_coarse, effect, effect.starts)
        evidence = _evidence(problem, named, base, candidate, len(effects))
        if evidence > problem.criteria.payload.worth:
            scored.append((evidence, candidate))
    scored.sort(key=lambda each: -each[0])
    judged = []
    for _, candidate in scored[: problem.criteria.payload.judged]:
        closer = with_best_shape(problem, named, base, candidate.effect, [candidate.shape], CLOSELY)
        evidence = _evidence(problem, named, base, closer, len(effects))
        judged.append(_judged(problem, named, closer, evidence, held_out))
    return sorted((each for each in judged if each is not None), key=lambda each: -each.evidence)


def _evidence(problem: Problem, named: Sequence[Named], base: Fitted, candidate: Named, tried: int) -> float:
    left = left_with(problem, named, base, candidate.effect, candidate.shape)
    gained, rows = 0.0, 0.0
    for before, after, stretch in zip(
        in_floors(problem, base.residual), in_floors(problem, left), problem.stretches, strict=True
    ):
        count = len(after) / (1.0 if stretch.still else correlation_time(after))
        then, now = (np.maximum(np.mean(each**2, axis=0), 1.0) for each in (before, after))
        gained += 0.5 * count * float(np.sum(np.log(then / now)))
        rows += 6 * count
    return gained - 0.5 * candidate.effect.fitted * float(np.log(rows)) - float(np.log(tried))


def _judged(
    problem: Problem, named: Sequence[Named], candidate: Named, evidence: float, held_out: Sequence[Stretch]
) -> _Candidate | None:
    """None where such a thing cannot be, or what was not fitted says no."""
    more = [*named, candidate]
    after = fit(problem, more)
    if not candidate.effect.possible(numbers(problem, after, more, len(named))):
        return None
    base, judges = problem, list(held_out)
    if candidate.effect.of_log is not None or not judges:
        block_s = problem.criteria.judging.block_s
        pairs = [
            each.halves(1.0 if each.still else block_s) if not each.still or candidate.effect.of_log == each.name
            else (each, None)
            for each in problem.stretches
        ]  # fmt: skip
        base = problem.of([even for even, _ in pairs])
        judges = [odd for _, odd in pairs if odd is not None and candidate.effect.of_log in (None, odd.name)]
        after = fit(base, more)
    before = _rms(base, fit(base, named), named, judges)
    then = _rms(base, after, more, judges)
    if candidate.effect.swings and not candidate.effect.unit:
        value, std = numbers_with_std(problem, fit(problem, more), more, len(named))
        if value[0] < problem.criteria.judging.significant * std[0]:
            return None
    worth = then**2 < (1.0 - problem.criteria.judging.least) * before**2
    return _Candidate(candidate, evidence, before, then) if worth else None


def _rms(problem: Problem, found: Fitted, named: Sequence[Named], judges: Sequence[Stretch]) -> float:
    squares = [((residuals(problem.frame, each, named, found.x) / each.floor)[each.use] ** 2) for each in judges]
    return float(np.sqrt(np.mean(np.concatenate(squares))))


def _ratios(
    problem: Problem, found: Fitted, named: Sequence[Named], stretch: Stretch,
    own: Sequence[tuple[Finding, str, Array]] = (),
) -> Array:  # fmt: skip
    """(6,) rms over floor; own: what was found in a held-out log alone, (T, 6)."""
    left = residuals(problem.frame, stretch, named, found.x)
    for _, log, wrench in own:
        if log == stretch.name:
            left = left - wrench
    return np.asarray(np.sqrt(np.mean((left[stretch.use] / stretch.floor) ** 2, axis=0)))


def _of_its_own(
    problem: Problem, found: Fitted, named: Sequence[Named], stretch: Stretch
) -> list[tuple[Finding, str, Array]]:
    """What is missing in one held-out log alone, its zero, and its course (T, 6); the body stays as it is."""
    left = replace(stretch, wrench=residuals(problem.frame, stretch, named, found.x))
    alone, base = _settled(replace(problem, stretches=[left], known=True), [])
    best = _best(alone, [], base, [zero_of_log(stretch.name), zero_step(stretch.name, stretch.time)], [])
    if not best:
        return []
    own = [best[0].named]
    alone, base = _settled(alone, own)
    course = left.wrench - residuals(alone.frame, left, own, base.x)
    return [(_told(alone, base, own, 0, best[0], ()), stretch.name, course)]


def _told(
    problem: Problem, found: Fitted, named: Sequence[Named], which: int, candidate: _Candidate,
    rivals: tuple[tuple[str, str], ...], filtered: tuple[float, float, Array] | None = None,
) -> Finding:  # fmt: skip
    """filtered: variance [ms²] of the filter that delays, and its std."""
    effect = named[which].effect
    if effect.swings and below_floor(problem, found):
        parameters: tuple[Parameter, ...] = ()
    else:
        value, std = numbers_with_std(problem, found, named, which)
        parameters = tuple(
            Parameter(name, unit, float(v), float(s))
            for (name, unit), v, s in zip(effect.parameters, value, std, strict=True)
        )
        if effect.retimed and filtered is not None:
            parameters = (*parameters, Parameter("variance", "ms²", *filtered[:2]))
    return Finding(
        effect.name, effect.place, parameters, candidate.evidence, candidate.before, candidate.after, rivals
    )  # fmt: skip


def _seconds(stretch: Stretch) -> float:
    return float(np.count_nonzero(stretch.use)) * float(np.median(np.diff(stretch.time)))
