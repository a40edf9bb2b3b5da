"""Stiffness against itself: parts of the same evidence that ought to agree, and by how much they do not.

The springs of the fit are let differ between two parts, everything else is kept, and one Gauss-Newton step from the
common fit says by how much they do: with the columns split in two, A = (A₁, A₂), δ = H₁⁻¹ A₁ᵀ w e - H₂⁻¹ A₂ᵀ w e. All
doubts of the fit go through the same split columns, so that what both parts share (a gain, a via point) is taken off.

Whether bands harden, soften or let go with time is asked by a column of that law beside the springs, in the same way: a
split into halves would have to find natural lengths anew in each, and sees far less.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations
from typing import final

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from exogauge.criteria.criterion import Z95
from exogauge.criteria.supporting import Supporting
from exogauge.devices.device import Band
from exogauge.devices.result import BandEstimate, CrossCheck, StiffnessResult
from exogauge.effects.band import BandEffect
from exogauge.effects.catalogue import band_effects
from exogauge.remarks import About, Remark
from exogauge.support.band_doubt import NULL_TEST, contributions, inverted, null_score
from exogauge.support.band_fit import BandFit
from exogauge.support.band_inputs import BandInputs, Moves
from exogauge.support.band_model import NULL, Belief, Fitted, Setting, columns, each_its_own
from exogauge.support.band_weights import rms

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
Said = tuple[str, str, tuple[str, str]]  # check, group, between

SAID = {
    "approaches": About.APPROACHES_DISAGREE,
    "repetitions": About.REPETITIONS_DISAGREE,
    "strokes": About.STROKES_DISAGREE,
    "pulls": About.PULLS_DISAGREE,
    "relaxation": About.RELAXATION,
    "sides": About.SIDES_DISAGREE,
    "misfit": About.SPRINGS_MISFIT,
    "halves": About.HALVES_DISAGREE,
}
OF_THE_BANDS = SAID.keys() - {"approaches", "repetitions"}  # what fails these by A and paired is the device's
LENGTHENING, SHORTENING = "lengthening", "shortening"
HARD, SOFT = "hard", "soft"
AT_ONCE = "at once"
WITHOUT = "without the device"


def within(
    seen: BandFit, bands: Sequence[Band], robot: Mapping[str, Array], criteria: Supporting, sigma: Array, std: Array
) -> tuple[CrossCheck, ...]:
    """Of one approach: each log against all others, natural lengths in its first half against those in its second,
    bands that lengthen against the same that shorten (both by their lengths too, each and all together, with one
    stiffness for both), their harder half of pulls against the softer, pulls at once against the same some time later,
    bands of a group against each other, what they leave against what there is without. robot: as in `contributions`.
    sigma: (D,) [N·m] there, of the first joints of the fit: of further ones it is not known, and what is left on them
    is not held against it. std: (W,) stated of each band. What the motions cannot tell apart is not compared."""
    wear, logs = seen.fitted.wear, seen.setting.logs
    layout = wear.layout.stiffness
    members = {int(place): np.flatnonzero(layout == place).tolist() for place in np.unique(layout)}
    found: dict[int, list[CrossCheck]] = {place: [] for place in members}
    null, moves = _null_of_fit(seen), BandInputs(seen.setting, seen.fitted).moves()
    apart = _Apart(seen, _believing_nothing(seen.setting), robot, moves)

    def lengths_of(own: Sequence[int]) -> list[int]:
        """Natural lengths of these bands, each once."""
        return list(dict.fromkeys(wear.layout.natural_length[own].tolist()))

    for number, log in enumerate(logs.logs):
        if len(logs.logs) > 1 and (number == 0 or len(logs.logs) > 2):
            between = (log.name, logs.logs[1].name if len(logs.logs) == 2 else "others")
            parts = apart.by_samples(logs.log == number)
            for place, own in members.items():
                said = ("repetitions", bands[own[0]].group, between)
                found[place] += (*parts.springs(place, said, null), *parts.lengths(place, lengths_of(own), said, null))
        its_own = logs.log == number
        early = logs.time < 0.5 * (logs.time[its_own].min() + logs.time[its_own].max())
        halves = apart.by_samples(its_own & early, its_own & ~early)
        for place, own in members.items():
            for length in lengths_of(own):
                band = wear.layout.names[length].partition("[")[2].rstrip("]")
                between = (f"{band}, first half of {log.name}", "second half")
                found[place] += halves.moved_alike([length], ("halves", bands[own[0]].group, between), null)
    for place, own in members.items():
        rate = _rate(seen.setting, own)
        said = ("strokes", bands[own[0]].group, (LENGTHENING, SHORTENING))
        parts = apart.by_samples(rate > 0.0, without=None if seen.null is None else _rate(seen.null, own) > 0.0)
        told = np.zeros_like(null)  # it was split
        found[place] += (*parts.springs(place, said, told), *parts.lengths(place, lengths_of(own), said, told))
        found[place] += apart.by_laws(own, bands[own[0]].group)
    known = slice(len(sigma))
    excess = np.sqrt(np.maximum(rms(logs, seen.fitted.e)[known] ** 2 - criteria.misfit * sigma**2, 0.0))
    slopes = seen.setting.nuisances.without(seen.fitted.A)
    for place, own in members.items():
        own_slopes = seen.fitted.A[:, known, place], slopes[:, known, place]
        joint, most = _misfit(seen.setting.weight[:, known], *own_slopes, excess)
        doubt = max(float(std[own[0]]), criteria.misfit_matters * float(wear.springs[place]))
        said = ("misfit", bands[own[0]].group, (logs.names[joint], WITHOUT))
        found[place].append(CrossCheck(*said, most, doubt, Z95))  # beyond: an error that its interval does not hold
    if not wear.added:
        alone, k_of = apart.by_bands(bands), each_its_own(bands).stiffness
        for place, own in members.items():
            for one, other in combinations(own, 2):
                said = ("sides", bands[one].group, (bands[one].name, bands[other].name))
                found[place] += alone.values(int(k_of[one]), int(k_of[other]), said)
    largest = {"N/m": wear.springs, "m": np.full(len(wear.springs), float(wear.l_0.min()))}
    return tuple(
        each
        for place, own in found.items()
        for each in own
        if 0.0 < each.std <= criteria.known * float(largest[each.unit][place])
    )


@final
@dataclass(frozen=True)
class _Apart:
    """A fit whose springs are let differ. open: its setting, in which nothing is believed. moves: as of
    `scores_of_inputs`, of the common fit: where its steps go they are the same."""

    seen: BandFit
    open: Setting
    robot: Mapping[str, Array]
    moves: Moves

    def by_samples(self, first: BoolArray, second: BoolArray | None = None, without: BoolArray | None = None) -> _Split:
        """first, second: (N,) samples of two parts; where there is no second, the others are. What is in neither has
        springs of its own.

        without: (N,) samples of the logs without the device that are of the first part: what is found there between
        both parts is no device's. Where they cannot be split, each part is taken to err by all of it, independently.
        """
        fitted, null = self.seen.fitted, self.seen.null
        S = len(fitted.wear.springs)
        springs, more = fitted.A[:, :, :S], fitted.A[:, :, S:]
        neither = ~first if second is None else ~(first | second)
        parts = [first, neither] if second is None else [first, second, *([neither] if neither.any() else [])]
        A = np.concatenate([*(springs * part[:, None, None] for part in parts), more], axis=2)
        found = self._split(self.open, fitted, A, None)
        if null is None or without is None:
            return found
        bare = columns(null.logs, null.wires, fitted.wear)
        both = [bare[:, :, :S] * part[:, None, None] for part in (without, ~without)]
        return replace(found, null_score=null_score(null, np.concatenate([*both, bare[:, :, S:]], axis=2)))

    def by_laws(self, own: Sequence[int], group: str) -> Iterator[CrossCheck]:
        """Bands `own` that harden or soften: slope of the pull [N/m] at their harder pulls less that at the softer. And
        that let go: by how much they are stiffer [N/m] at once than after each of some times. Nothing of a law that is
        fitted beside the springs."""
        wear, wires = self.seen.fitted.wear, self.seen.setting.wires
        named = {each.effect.name for each in wear.added if each.wire in own}
        stretch = np.mean([np.maximum(wires[k].length - wear.l_0[k], 0.0) for k in own], axis=0)
        taut = stretch[stretch > 0.0]
        hardening, relaxation = (band_effects()[name] for name in ("band_hardening", "band_relaxation"))
        if len(taut) and hardening.name not in named:
            hard = taut > np.median(taut)
            power, apart = 2.0, float(taut[hard].mean() - taut[~hard].mean()) if hard.any() else 0.0
            yield from self._by_law(own, hardening, (power,)).value(("pulls", group, (HARD, SOFT)), power * apart)
        if len(taut) and relaxation.name not in named:
            for time in relaxation.shapes[0].grid:
                said = ("relaxation", group, (AT_ONCE, f"after {time:g} s"))
                yield from self._by_law(own, relaxation, (time,)).value(said, 1.0)

    def _by_law(self, own: Sequence[int], effect: BandEffect, shape: tuple[float, ...]) -> _Split:
        """A law beside the springs, of these bands alike: its first coefficient, behind all other values."""

        def added(setting: Setting) -> Array:
            each = [setting.wires[k].columns(effect, shape, *self.seen.fitted.wear.spring(k)) for k in own]
            return np.asarray(np.sum(each, axis=0)[:, :, :1])

        fitted, null = self.seen.fitted, self.seen.null
        found = self._split(self.open, fitted, np.concatenate([fitted.A, added(self.seen.setting)], axis=2), None)
        if null is None:
            return found
        both = [columns(null.logs, null.wires, fitted.wear), added(null)]
        return replace(found, null_score=null_score(null, np.concatenate(both, axis=2)))

    def by_bands(self, bands: Sequence[Band]) -> _Split:
        """Every band its own stiffness."""
        wear, layout = self.seen.fitted.wear, each_its_own(bands)
        own = replace(wear, layout=layout, springs=np.concatenate([wear.k, wear.l_0]))
        belief = Belief(own.springs, np.zeros((len(own.springs), len(own.springs))))
        A = columns(self.open.logs, self.open.wires, own)
        return self._split(replace(self.open, belief=belief), replace(self.seen.fitted, wear=own), A, self.seen.null)

    def _split(self, setting: Setting, fitted: Fitted, A: Array, null: Setting | None) -> _Split:
        split = replace(fitted, A=A, hessian=setting.nuisances.information(A))
        return _Split(replace(self.seen, setting=setting, null=null), split, self.robot, self.moves)


@final
@dataclass(frozen=True)
class _Split:
    """The fit with more values than it had. split: its columns, at the errors of the common fit. null_score: (P,) of
    these columns, where the fit's own does not tell it."""

    seen: BandFit
    split: Fitted
    robot: Mapping[str, Array]
    moves: Moves
    null_score: Array | None = None

    def springs(self, place: int, said: Said, beside: Array) -> Iterator[CrossCheck]:
        """One spring, split in two. beside: (P, P) what each part errs by besides."""
        other = place + len(self.split.wear.springs)
        doubt = float(np.sqrt(2.0 * beside[place, place])) if self._in_both(place) else 0.0
        return self.values(place, other, said, doubt)

    def lengths(self, stiffness: int, places: Sequence[int], said: Said, beside: Array) -> Iterator[CrossCheck]:
        """Natural lengths, split in two, where the stiffness is one. A band that is taut all along may pull more in one
        part than in the other, and hardly tells whether it is stiffer or shorter there; and bands that pull at the same
        joints hardly tell which of them is longer, and well that they are together."""
        for chosen in (*([place] for place in places), *([places] if len(places) > 1 else [])):
            yield from self.moved_alike(chosen, said, beside, stiffness)

    def moved_alike(
        self, lengths: Sequence[int], said: Said, beside: Array, stiffness: int | None = None
    ) -> Iterator[CrossCheck]:
        """The likeliest m [m], if every length differs by m and the stiffness by nothing: 1ᵀ C⁻¹ δ / 1ᵀ C⁻¹ 1."""
        step, shares = self._step
        chosen = np.array([*lengths, *(() if stiffness is None else (stiffness,))])
        each, S = np.arange(len(chosen)), len(self.split.wear.springs)
        contrast = np.zeros((len(step), len(chosen)))
        contrast[chosen, each], contrast[chosen + S, each] = 1.0, -1.0
        if not all(self._told(contrast[:, k], [int(chosen[k]), int(chosen[k]) + S]) for k in each):
            return
        C = sum((contrast.T @ share @ contrast for share in shares.values()), np.zeros((len(chosen), len(chosen))))
        if all(self._in_both(int(place)) for place in chosen):
            C = C + 2.0 * beside[np.ix_(chosen, chosen)]
        if np.all(np.diag(C) > 0.0):
            weighed = inverted(C) @ (each < len(lengths))
            told = float(np.sum(weighed[: len(lengths)]))
            if told > 0.0:
                yield CrossCheck(*said, float(weighed @ contrast.T @ step) / told, told**-0.5, unit="m")

    def value(self, said: Said, factor: float) -> Iterator[CrossCheck]:
        """The last value, times a factor; nothing where the data hold nothing of it."""
        contrast = np.zeros(len(self.split.hessian))
        contrast[-1] = factor
        if factor > 0.0 and self._told(contrast, [len(contrast) - 1]):
            yield self._held(contrast, said)

    def _in_both(self, place: int) -> bool:
        """Both parts hold something of a spring."""
        A, other = self.split.A, place + len(self.split.wear.springs)
        shares = [float(np.sum(self.seen.setting.weight * A[:, :, each] ** 2)) for each in (place, other)]
        return min(shares) > NULL * max(sum(shares), 1e-300)

    def _told(self, contrast: Array, chosen: list[int]) -> bool:
        """The data hold this difference of two values."""
        H, size = self.split.hessian, self._size
        blind = np.abs(contrast @ self._blind) > 1e-6 * size[chosen].max()
        return not (np.any(np.diag(H)[chosen] <= 0.0) or np.any(blind))

    def values(self, one: int, other: int, said: Said, beside: float = 0.0) -> Iterator[CrossCheck]:
        """The difference of two values' steps; nothing where the data hold none. beside: further doubt of it."""
        contrast = np.zeros(len(self.split.hessian))
        contrast[one], contrast[other] = 1.0, -1.0
        if not self._told(contrast, [one, other]):
            return
        yield self._held(contrast, said, beside)

    def _held(self, contrast: Array, said: Said, beside: float = 0.0) -> CrossCheck:
        step, shares = self._step
        variance = sum(float(contrast @ each @ contrast) for each in shares.values()) + beside**2
        return CrossCheck(*said, float(contrast @ step), float(np.sqrt(max(variance, 0.0))))

    @cached_property
    def _size(self) -> Array:
        return np.asarray(1.0 / np.sqrt(np.maximum(np.diag(self.split.hessian), 1e-300)))

    @cached_property
    def _blind(self) -> Array:
        """(P, n) directions that the data hold nothing of."""
        curvature, vectors = np.linalg.eigh(self.split.hessian * np.outer(self._size, self._size))
        return np.asarray(vectors[:, curvature <= NULL * len(curvature)] * self._size[:, None])

    @cached_property
    def _step(self) -> tuple[Array, Mapping[str, Array]]:
        """From the common fit, and its doubt by source."""
        split, setting, size = self.split, self.seen.setting, self._size
        score = np.einsum("ndp,nd,nd->p", split.A, setting.weight, split.e)
        step = np.linalg.lstsq(split.hessian * np.outer(size, size), size * score, rcond=1e-12)[0] * size
        explained = setting.nuisances.without(split.A @ step)
        let_differ = replace(split, e=split.e - explained)  # or a disagreement would count as scatter
        shares = contributions(setting, let_differ, self.robot, self.seen.null, self.moves)
        if self.null_score is not None:
            moved = inverted(split.hessian) @ self.null_score
            shares[NULL_TEST] = np.outer(moved, moved)
        return step, shares


def _misfit(weight: Array, a: Array, beside: Array, excess: Array) -> tuple[int, float]:
    """The joint that has most part in it, and by how much a stiffness [N/m] may be off that errors of this size have
    been fitted with, whatever their course: by Cauchy and Schwarz |Σ w a⊥ m| <= √(Σ w a⊥²) √(Σ w m²) at every joint,
    over the information Σ w a a⊥. weight, a, beside: (N, D), a the slopes with the stiffness, beside a⊥ (`Nuisances`).
    excess: (D,) [N·m] RMS."""
    parts = np.sqrt(np.sum(weight * beside**2, axis=0) * np.sum(weight, axis=0)) * excess
    return int(np.argmax(parts)), float(np.sum(parts) / max(float(np.sum(weight * a * beside)), 1e-300))


def _rate(setting: Setting, own: Sequence[int]) -> Array:
    """(N,) [m/s] at which bands lengthen, together."""
    return np.asarray(np.sum([setting.wires[k].rate for k in own], axis=0))


def _null_of_fit(seen: BandFit) -> Array:
    """(P, P) what the null test is in the doubt of the values."""
    nothing = np.zeros_like(seen.fitted.hessian)
    if seen.null is None:
        return nothing
    return contributions(seen.setting, seen.fitted, {}, seen.null).get("null_test", nothing)


def _believing_nothing(setting: Setting) -> Setting:
    S = len(setting.belief.mean)
    return replace(setting, belief=Belief(setting.belief.mean, np.zeros((S, S))))


def judged(found: Sequence[StiffnessResult], criteria: Supporting) -> tuple[StiffnessResult, ...]:
    """With the approaches held against each other, all checks of a device at one level, and what fails no longer
    identifiable: by the approach that sees it, and by every other one that cannot say that it is not so. What is small
    beside the stated doubt fails nothing, however sure it is: no two runs are quite alike."""
    result = list(found)
    for device in dict.fromkeys(each.device for each in found):
        own = [k for k, each in enumerate(found) if each.device == device and each.approach != "prior"]
        between = {k: _against_others(found[k], [found[n] for n in own if n != k]) for k in own}
        by_chance = [each for k in own for each in found[k].cross_checks if each.check != "misfit"]
        count = len(by_chance) + sum(len(each) for each in between.values()) // 2
        limit = -float(ndtri(0.5 * criteria.false_alarms / max(count, 1)))
        for k in own:
            inside = [each for each in found[k].cross_checks if each.check != "approaches"]
            every = (*inside, *between[k])
            small = {group: criteria.small * doubt for group, doubt in _doubts(found[k]).items()}
            checks = (each if each.check == "misfit" else replace(each, limit=limit) for each in every)
            result[k] = replace(found[k], cross_checks=tuple(_allowed(each, small[each.group]) for each in checks))
        failing = {k: [each for each in result[k].cross_checks if not each.agrees] for k in own}
        of_bands = _seen_by_both([failing[k] for k in own if result[k].approach != "B"])
        for k in own:
            against = [(each, "") for each in failing[k]]
            for n in (n for n in own if n != k):
                seen = [each for each in failing[n] if result[k].approach == "B" and each.group in of_bands]
                seen += [each for each in failing[n] if not _excluded(each, result[k].cross_checks, criteria.equal)]
                against += [(each, result[n].approach) for each in dict.fromkeys(seen)]
            result[k] = replace(result[k], bands=tuple(_told(band, against) for band in result[k].bands))
    return tuple(result)


def _doubts(found: StiffnessResult) -> dict[str, Array]:
    """Group -> its doubt [N/m], and [m] what makes as much of the largest pull, or is the doubt of a length if that is
    less; 0 where it is not known."""
    doubts = dict[str, Array]()
    for band in found.bands:
        k, l_0 = band.stiffness, band.natural_length
        as_length = k.std / k.value * (band.longest - l_0.value) if k.value > 0.0 else np.nan
        own = np.nan_to_num([k.std, min(as_length, l_0.std)], nan=0.0, posinf=0.0, neginf=0.0)
        doubts[band.group] = np.minimum(doubts.get(band.group, own), np.maximum(own, 0.0))
    return doubts


def _allowed(check: CrossCheck, small: Array) -> CrossCheck:
    """small: [N/m], [m]. What springs leave has its own bound (`misfit_matters`)."""
    return check if check.check == "misfit" else replace(check, small=float(small[0 if check.unit == "N/m" else 1]))


def _seen_by_both(failing: Sequence[Sequence[CrossCheck]]) -> set[str]:
    """Groups of which A and the paired estimate both see something of the bands themselves: what B's own checks say,
    which what the model of the robot lacks bends too, excludes it no more."""
    groups = [{each.group for each in own if each.check in OF_THE_BANDS} for own in failing]
    return set.intersection(*groups) if len(groups) > 1 else set()


def _excluded(failed: CrossCheck, own: Sequence[CrossCheck], z: float) -> bool:
    """Whether another approach's check of the same parts agrees, and does not agree with what fails. One whose doubt is
    too large to see it, or to be made at all, excludes nothing; nor does any that two approaches contradict each other.
    """
    same = [
        each
        for each in own
        if (each.check, each.group, each.unit) == (failed.check, failed.group, failed.unit)
        and (failed.check == "misfit" or set(each.between) == set(failed.between))
    ]
    return failed.check != "approaches" and any(
        each.agrees and abs(each.difference - failed.difference) > z * np.hypot(each.std, failed.std) for each in same
    )


def _against_others(one: StiffnessResult, others: Sequence[StiffnessResult]) -> list[CrossCheck]:
    """Their errors count as independent: they share logs, which makes errors alike, so the doubt is overstated."""
    checks = list[CrossCheck]()
    for other in others:
        theirs = {band.group: band for band in other.bands}
        for group, band in {band.group: band for band in one.bands}.items():
            if band.identifiable and theirs[group].identifiable:
                difference = band.stiffness.value - theirs[group].stiffness.value
                std = float(np.hypot(band.stiffness.std, theirs[group].stiffness.std))
                if std > 0.0:
                    checks.append(CrossCheck("approaches", group, (one.approach, other.approach), difference, std))
    return checks


def _told(band: BandEstimate, checks: Sequence[tuple[CrossCheck, str]]) -> BandEstimate:
    """Not identifiable where a check fails, with the worst in the note. checks: that fail, and by which other approach
    they do, if not by its own."""
    failed = [each for each in checks if each[0].group == band.group]
    stays = all(each.check not in OF_THE_BANDS and each.unit != "m" for each, _ in failed)  # else no line ends there
    length = band.length_identifiable and stays
    if not failed or (band.identifiable, band.length_identifiable) == (False, length):
        return band
    worst, by = max(failed, key=lambda each: (not each[1], abs(each[0].z) / each[0].limit))  # its own before others'
    said = About.LENGTHS_DISAGREE if worst.unit == "m" and worst.check != "halves" else SAID[worst.check]
    names = list(worst.between)
    if by and worst.check != "approaches":
        names[0 if worst.check == "misfit" else -1] += f" by {by}"
    note = Remark(said, tuple(names), numbers=(worst.difference, worst.std))
    return replace(band, identifiable=False, length_identifiable=length, note=note)
