"""Numbers of the maker that the data contradict by more than he doubts them: a payload, a part that was changed, a
motor that gives other than its data sheet says.

What one of the maker's numbers does to held-out errors: the identified model as it is, and with that number put back
to what is stated.

How many samples of each kind of row count as one: residuals are coloured, and more so where more is missing.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from exogauge.detect.nominal.nominal_values import Array, Stated, gain_columns, stated_numbers
from exogauge.findings.result import HeldOut
from exogauge.identification.identify import identify
from exogauge.identification.model import RobotModel
from exogauge.identification.predict import Parameters, measured_channels, motor_gain, predictions
from exogauge.identification.result import Identification
from exogauge.identification.settings import Recording, Settings
from exogauge.identification.validate import floors_of, rmse_in_steady_motion, unit_of
from exogauge.logs.model import Log
from exogauge.robots.kinematics import forward
from exogauge.search.locate import pooled
from exogauge.search.score import residual_memory

ALIKE = ("gains", "feet")  # what many numbers share


@final
@dataclass(frozen=True)
class Change:
    """A number that is let go. evidence: twice the log likelihood ratio for that. value, std: (k,) of the change, of a
    link its ten parameters [kg, kg·m, kg·m²], of a gain its share. sure: enough of it for a name."""

    stated: Stated
    evidence: float
    value: Array
    std: Array
    sure: bool

    @property
    def of_link(self) -> bool:
        return self.stated.sort in ("load", "scaled")


@final
@dataclass(frozen=True)
class Contradiction:
    """The number whose change explains best why the data lie far from the prior, and those that would do as well.

    or_all_gains: one factor on all gains would, too.
    """

    best: Change
    alike: tuple[Change, ...]
    others: tuple[Change, ...]
    or_all_gains: bool


@final
@dataclass(frozen=True)
class Contradictions:
    """one_by_one: numbers to blame. feet: a gain that all contact sensors share would explain as much as the best of
    them, and nothing in these data tells it from masses and motor gains; then none is to blame."""

    one_by_one: list[Contradiction]
    feet: Change | None = None


def contradicted(model: RobotModel, logs: Sequence[Log]) -> Contradictions:
    """One after the other: what the first explains is taken out before the next is sought. logs: the fitted ones.

    A link that hardly tilts in them, such as a foot on the ground, is never claimed: its columns hold the noise of the
    measured acceleration, which the residual holds too. A centre of mass that is elsewhere, of another link than the
    best, and explains clearly more has no name (`let_go`), and takes its part out. Where one factor on all gains
    explains more than any of them, none is to blame.
    """
    criteria = model.criteria
    asked, data = stated_numbers(model, tilting(model, logs), row_memory(model, logs))
    centres = [each for each in asked if each.sort == "centre"]
    numbers = [each for each in asked if each.sort != "centre"]
    found, single = list[Contradiction](), {_key(each) for each in numbers if each.sort not in ALIKE}
    while len(found) < min(criteria.nominal.most, len(single)):
        changes = []
        for stated in numbers:
            let = data.let(stated.columns)
            changes.append(_change(model, stated, let.evidence, let.change * stated.broad, let.std * stated.broad))
        ordered, common = _best_of_each(changes)
        best = ordered[0]
        elsewhere = max(centres, key=lambda each: data.let(each.columns).evidence, default=None)
        needed = max(best.evidence + criteria.judging.open, criteria.nominal.sure)
        another = elsewhere is not None and not (best.of_link and best.stated.index == elsewhere.index)
        if elsewhere is not None and another and data.let(elsewhere.columns).evidence >= needed:
            data = data.without(elsewhere.columns)
            centres = [each for each in centres if each is not elsewhere]
            continue
        feet = next((each for each in changes if each.stated.sort == "feet"), None)
        if feet is not None and feet.sure and feet.evidence > best.evidence - criteria.judging.open:
            return Contradictions(found, feet)
        if not best.sure or (not best.of_link and common > best.evidence):
            break
        alike = tuple(each for each in ordered[1:] if best.evidence - each.evidence < criteria.judging.open)
        others = tuple(each for each in ordered[1:3] if each not in alike)
        found.append(Contradiction(best, alike, others, best.evidence - common < criteria.judging.open))
        data = data.without(best.stated.columns)
        numbers = [each for each in numbers if _key(each) != _key(best.stated)]
    return Contradictions(found)


def _change(model: RobotModel, stated: Stated, evidence: float, value: Array, std: Array) -> Change:
    if stated.sort == "scaled":
        own = model.robot.tree.phi[stated.index]
        value, std = value * own, std * np.abs(own)
    criteria = model.criteria
    significant = bool(abs(value[0]) >= criteria.judging.significant * std[0])
    return Change(stated, evidence, value, std, evidence >= criteria.nominal.sure and significant)


def _best_of_each(changes: Sequence[Change]) -> tuple[list[Change], float]:
    """Of every link the change that explains more, of those that say whether it is heavier where there are such, most
    evidence first; and the evidence for all gains alike."""
    first: dict[tuple[bool, int], Change] = {}
    common = -np.inf
    for each in sorted(changes, key=lambda each: (not each.sure, -each.evidence)):
        if each.stated.sort == "gains":
            common = each.evidence
        elif each.stated.sort not in ALIKE:
            first.setdefault(_key(each.stated), each)
    return sorted(first.values(), key=lambda each: -each.evidence), common


def _key(stated: Stated) -> tuple[bool, int]:
    return stated.sort in ("load", "scaled"), stated.index


def tilting(model: RobotModel, logs: Sequence[Log]) -> list[int]:
    """Indices of bodies across which gravity turns enough to show what they weigh."""
    thinned = 500  # samples of a log looked at
    criteria = model.criteria.nominal
    up, turning = [], []
    for log in logs:
        prepared = model.prepare(log)
        turning.append(prepared.motion.gyro[prepared.kept])
        kept = prepared.kept[:: max(1, len(prepared.kept) // thinned)]
        pulled = forward(model.robot.tree, prepared.motion.rows(kept)).proper_acceleration
        up.append(pulled / np.maximum(np.linalg.norm(pulled, axis=2, keepdims=True), 1e-12))
    if model.robot.floating and np.sqrt(np.mean(np.concatenate(turning) ** 2)) < criteria.base_turns:
        return []  # all that its accelerometer says beside gravity is noise
    spread = np.sqrt(np.sum(np.var(np.concatenate(up), axis=0), axis=1))
    return [body for body, each in enumerate(spread) if each > criteria.tilts]


Squares = dict[str, tuple[list[float], list[float]]]  # channel -> mean squares by log, put back and not


def put_back(found: Identification, recordings: Sequence[Recording], change: Change, settings: Settings) -> HeldOut:
    """On the channel that shows it most, against its noise. Before: with the maker's number; after: with the data's."""
    if _logged_torque(found.model, change):
        return _rescaled(found, recordings, change, settings)
    model, squares, known = found.model, Squares(), floors_of(found.validation)
    for recording in [each for each in recordings if each.held_out] or recordings:
        prepared = model.prepare(recording.log)
        alternatives = [_as_stated(model, change), model.identified]
        predicted = predictions(model.equations, prepared, alternatives)
        gains = [motor_gain(model.equations, each) for each in alternatives]
        measured = [measured_channels(model.equations, prepared, k_T) for k_T in gains]
        own = {channel: floor for (log, channel), floor in known.items() if log == recording.log.name}
        for which, (m, p, parameters) in enumerate(zip(measured, predicted, alternatives, strict=True)):
            for channel, rmse in rmse_in_steady_motion(model.equations, prepared, m, p, parameters, own).items():
                if rmse is not None:
                    squares.setdefault(channel, ([], []))[which].append(rmse**2)
    floors = _floors(found, squares)
    errors = {name: [float(np.sqrt(np.mean(each))) for each in pair] for name, pair in squares.items()}
    shown = max(floors, key=lambda name: (errors[name][0] ** 2 - errors[name][1] ** 2) / max(floors[name], 1e-12) ** 2)
    before, after = errors[shown]
    return HeldOut(shown, unit_of(shown, found.model.robot), before, after, floors[shown])


def _as_stated(model: RobotModel, change: Change) -> Parameters:
    """The identified ones, this number apart."""
    own, stated = model.identified, change.stated
    if not change.of_link:
        (gain,) = [k for k, effect in enumerate(model.equations.effects) if effect.name == "motor_gain"]
        xi = own.xi.copy()
        xi[stated.index, gain] = model.solution.prior.seen_mean[gain_columns(model.equations)[stated.index]]
        return replace(own, xi=xi)
    phi = own.phi.copy()
    phi[stated.index] -= change.value
    return replace(own, phi=phi)


def _logged_torque(model: RobotModel, change: Change) -> bool:
    """A torque that is logged has no gain in the model, which so does not hold the change."""
    return not change.of_link and model.robot.joints[change.stated.index].actuation == "torque"


def _rescaled(found: Identification, recordings: Sequence[Recording], change: Change, settings: Settings) -> HeldOut:
    """With the logged torque as it is, and identified again with it rescaled: masses had taken part of the error."""
    channel = f"tau.{found.model.robot.joints[change.stated.index].name}"
    scaled = [replace(each, log=_scaled(each.log, channel, 1.0 + change.value[0])) for each in recordings]
    again = identify(found.model.robot, scaled, settings, extension=found.model.extension)
    held = [each.log.name for each in recordings if each.held_out] or [each.log.name for each in recordings]
    fits = [[fit for fit in each.validation if fit.log in held and fit.channel == channel] for each in (found, again)]
    (before, _), (after, floor) = (pooled(each) for each in fits)
    return HeldOut(channel, unit_of(channel, found.model.robot), before, after, floor)


def _scaled(log: Log, channel: str, factor: float) -> Log:
    return replace(log, channels={**log.channels, channel: factor * log.channels[channel]}, beside=None)


def _floors(found: Identification, channels: Mapping[str, object]) -> dict[str, float]:
    fits = [fit for fit in found.validation if fit.held_out] or found.validation
    own = {name: [fit.noise_floor for fit in fits if fit.channel == name] for name in channels}
    return {name: float(np.sqrt(np.mean(np.square(floors)))) for name, floors in own.items() if floors}


def row_memory(model: RobotModel, logs: Sequence[Log]) -> Array:
    """(rows,) as many as its residual remembers, in the median log; at rest as in steady motion."""
    equations, x = model.equations, model.solution.unbounded.x
    of_logs = []
    for log in logs:
        prepared = model.prepare(log)
        residual = equations.residuals(prepared, x)
        steady = equations.layout.axes
        residual[:, steady][~prepared.steady[prepared.kept]] = np.nan
        of_logs.append([residual_memory(each) for each in residual.T])
    return np.maximum(np.median(of_logs, axis=0), model.criteria.search.least_memory)
