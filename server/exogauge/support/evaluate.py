"""From logs with and without the device to supporting torque and bands, motion by motion."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeVar, final

import numpy as np
from numpy.typing import NDArray

from exogauge.devices.device import Device
from exogauge.devices.result import Approach, Estimate, StiffnessResult
from exogauge.devices.routing import Routing
from exogauge.devices.torque import band_torque
from exogauge.identification.model import RobotModel
from exogauge.progress import Doing, Progress, unwatched
from exogauge.remarks import About, Remark
from exogauge.resident import give_back
from exogauge.side_by_side import each as side_by_side
from exogauge.support.balance import Balance, balance
from exogauge.support.band_fit import NamedBands
from exogauge.support.band_weights import LEAST_SIGMA
from exogauge.support.cross_checks import judged
from exogauge.support.drift import find_drift
from exogauge.support.evidence import Background, Evidence, Nothing, gather, on_joints
from exogauge.support.inputs import Doubts, sloped_samples
from exogauge.support.labels import notes_on_labels
from exogauge.support.motions import Pair, acted_joints, doubts, pairs
from exogauge.support.notes import notes_on_drift, notes_on_logs, notes_on_zeros
from exogauge.support.of_bands import notes_on_rest
from exogauge.support.phases import phase_names
from exogauge.support.repeatability import Plain, held_friction, repeatability
from exogauge.support.result import JointSupport, SupportResult, Trial
from exogauge.support.same_motion import Posture, match
from exogauge.support.settings import PlainLog, SupportSettings, WornLog
from exogauge.support.stiffness import Springs, fit_springs, identify_bands, with_spring
from exogauge.support.summary import summarise_joint
from exogauge.support.worn_weight import notes_on_weight
from exogauge.support.zeros import find_zeros

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.intp]

Fit = TypeVar("Fit")

DEFAULTS = SupportSettings()
APPROACHES: tuple[Approach, ...] = ("A", "B", "paired", "prior")


@final
@dataclass(frozen=True)
class Gathered:
    """What all logs say before any band is known. backgrounds: by motion. joints: (D,) columns of q, names: theirs.
    notes: what was done with the logs."""

    evidences: Sequence[Evidence]
    backgrounds: Mapping[str, Background]
    nothings: Sequence[Nothing]
    joints: IntArray
    names: Sequence[str]
    notes: Sequence[Remark] = ()


def estimate_support(
    model: RobotModel,
    plain: Sequence[PlainLog],
    worn: Sequence[WornLog],
    settings: SupportSettings = DEFAULTS,
    progress: Progress = unwatched,
) -> tuple[SupportResult, tuple[StiffnessResult, ...]]:
    """[Evaluator] sections 5.3 and 5.4: supporting torque by A, B and the maker's values, then the bands from each."""
    return conclude_support(model, gather_support(model, plain, worn, settings, progress), worn, settings, progress)


def gather_support(
    model: RobotModel,
    plain: Sequence[PlainLog],
    worn: Sequence[WornLog],
    settings: SupportSettings = DEFAULTS,
    progress: Progress = unwatched,
) -> Gathered:
    """The supporting torque of every log with a device, and what is found without one."""
    joints = acted_joints(model.robot, worn)
    evidences: list[Evidence] = []
    backgrounds: dict[str, Background] = {}
    nothings: list[Nothing] = []
    labels: list[Remark] = []
    names = [model.robot.joints[j].name for j in joints]
    balances = _balances(model, _used(plain, worn), joints, progress)
    zeros = find_zeros(model, plain, worn, settings.started)
    if zeros is not None:
        balances = {name: zeros.without(model, each) for name, each in balances.items()}
    drift = find_drift(model, plain, [each.log for each in worn], balances, settings.started)
    if drift is not None:
        balances = {name: drift.without(model, each) for name, each in balances.items()}
    known = Doubts(model, joints, [each for each in (drift, zeros) if each is not None])
    told = [held_friction(model, balances[each.log.name]) for each in _telling_of_rest(plain)]
    held = np.max([np.zeros(len(joints)), *told], axis=0)
    for motion in dict.fromkeys(each.motion for each in worn):
        give_back()  # what the balances took
        plains = _plains(model, _of_motion(plain, motion), balances)
        repeats = repeatability(plains, held, settings, known)
        background = Background(joints, plains, repeats, held, None, drift, zeros)
        of_motion = [pair for pair in pairs(worn, plain) if pair.worn.motion == motion]
        compare = partial(_evidence, model, plain=plain, background=background, settings=settings)
        for pair, evidence in zip(of_motion, side_by_side(compare, of_motion), strict=True):
            progress(0.2 + 0.6 * len(evidences) / len(worn), Doing.COMPARING_WORN, pair.worn.log.name)
            evidences.append(evidence)
        nothings += [_nothing(each, motion, known) for each in plains]
        own = [each for each in evidences if each.worn.motion == motion]
        labels += notes_on_labels(model, names, own, plains, motion)
        backgrounds[motion] = replace(background, plains=())  # the memory they hold goes
    del balances
    give_back()
    notes = (
        *labels,
        *notes_on_logs(_used(plain, worn), worn),
        *notes_on_drift(model, drift, joints),
        *notes_on_zeros(model, zeros),
        *notes_on_weight(model, _used(plain, worn), worn),
    )
    return Gathered(evidences, backgrounds, nothings, joints, names, notes)


def conclude_support(
    model: RobotModel,
    gathered: Gathered,
    worn: Sequence[WornLog],
    settings: SupportSettings = DEFAULTS,
    progress: Progress = unwatched,
) -> tuple[SupportResult, tuple[StiffnessResult, ...]]:
    """Bands from what was gathered, and supporting torques joint by joint."""
    progress(0.8, Doing.IDENTIFYING_BANDS)
    devices = {each.device.name: each.device for each in worn}
    fits = [fit for device in devices.values() for _, fit in _bands(identify_bands, model, device, gathered)]
    stiffness = judged(list(side_by_side(lambda fit: fit(), fits)), model.criteria.support)
    progress(0.95, Doing.COMPARING_BAND_MODEL)
    support = _result(model, gathered.evidences, gathered.backgrounds, stiffness, gathered.names, settings)
    rest = notes_on_rest(model, gathered.names, gathered.evidences, gathered.backgrounds, stiffness)
    return replace(support, remarks=(*gathered.notes, *rest, *support.remarks)), stiffness


@final
@dataclass(frozen=True)
class Consequences:
    """What hangs on the model of the robot. rmse: (device, motion, joint) -> [N·m] of B against the band model.
    stiffness: (device, approach) -> that of each group."""

    rmse: Mapping[tuple[str, str, str], float]
    stiffness: Mapping[tuple[str, Approach], Mapping[str, Estimate]]


def consequences(
    model: RobotModel,
    plain: Sequence[PlainLog],
    worn: Sequence[WornLog],
    settings: SupportSettings = DEFAULTS,
    progress: Progress = unwatched,
) -> Consequences:
    """Of another model, on the same logs: no more than is compared."""
    gathered = gather_support(model, plain, worn, settings, progress)
    devices, springs = {each.device.name: each.device for each in worn}, dict[tuple[str, Approach], Springs]()
    fits = [
        (device, approach, fit)
        for device in devices.values()
        for approach, fit in _bands(fit_springs, model, device, gathered)
        if approach != "prior"
    ]
    for (device, approach, _), found in zip(fits, side_by_side(lambda each: each[2](), fits), strict=True):
        springs[device.name, approach] = found
    errors: dict[tuple[str, str, str], list[Array]] = {}
    for each in gathered.evidences:
        device = each.worn.device
        first = next((found for (name, _), found in springs.items() if name == device.name), None)
        filled = device if _all_stated(device) else first and first.filled(device)
        if filled is not None:
            pulled, _ = _pulled(model, each, filled, gathered.names)
            for joint, error in zip(gathered.names, (each.b - pulled).T, strict=True):
                errors.setdefault((device.name, each.worn.motion, joint), []).append(error[np.isfinite(error)])
    return Consequences(
        {key: float(np.sqrt(np.mean(np.concatenate(each) ** 2))) for key, each in errors.items()},
        {key: {band.group: found.of(k)[0] for k, band in enumerate(found.bands)} for key, found in springs.items()},
    )


def beside_named(
    model: RobotModel, gathered: Gathered, stiffness: Sequence[StiffnessResult], named: Sequence[NamedBands]
) -> tuple[StiffnessResult, ...]:
    """Bands of which something was named, fitted again with it by every approach; the others as they were."""
    fits = [fit for one in named for _, fit in _bands(identify_bands, model, one.device, gathered, one)]
    found = judged(list(side_by_side(lambda fit: fit(), fits)), model.criteria.support)
    again = {(each.device, each.approach): each for each in found}
    return tuple(again.get((each.device, each.approach), each) for each in stiffness)


def _used(plain: Sequence[PlainLog], worn: Sequence[WornLog]) -> list[PlainLog]:
    """Logs without the device that the comparison looks at: of its motions, and those that tell of friction at rest."""
    compared = [each for motion in dict.fromkeys(each.motion for each in worn) for each in _of_motion(plain, motion)]
    held = _telling_of_rest(plain)
    return [each for each in plain if any(each is one for one in (*compared, *held))]


def _telling_of_rest(plain: Sequence[PlainLog]) -> Sequence[PlainLog]:
    return [each for each in plain if each.held_out] or plain


def _of_motion(plain: Sequence[PlainLog], motion: str) -> Sequence[PlainLog]:
    """Logs of this motion; for want of those, all that were not fitted; for want of those, all."""
    same = [each for each in plain if each.motion == motion]
    return same or [each for each in plain if each.held_out] or plain


def _plains(model: RobotModel, plain: Sequence[PlainLog], balances: Mapping[str, Balance]) -> list[Plain]:
    found = [(each, balances[each.log.name]) for each in plain]
    return [
        Plain(own, Posture(each.log, [model.robot.joints[j].name for j in own.joints]), each.motion, each.held_out)
        for each, own in found
    ]


def _balances(
    model: RobotModel, plain: Sequence[PlainLog], joints: IntArray, progress: Progress
) -> Mapping[str, Balance]:
    """By the log's name."""
    found = {}
    balances = side_by_side(lambda each: balance(model, model.prepare(each.log), joints), plain)
    for done, (each, own) in enumerate(zip(plain, balances, strict=True)):
        progress(0.2 * done / len(plain), Doing.GATHERING_RESIDUALS, each.log.name)
        found[each.log.name] = own
    return found


def _evidence(
    model: RobotModel, pair: Pair, plain: Sequence[PlainLog], background: Background, settings: SupportSettings
) -> Evidence:
    reference = None
    if pair.reference is not None:
        name = plain[pair.reference].log.name
        reference = next(k for k, each in enumerate(background.plains) if each.name == name)
    routing = Routing(model.robot.tree, pair.worn.device.bands)
    return gather(model, pair.worn, routing, replace(background, reference=reference), settings)


def _nothing(plain: Plain, motion: str, doubts: Doubts) -> Nothing:
    own, kept = plain.balance, plain.balance.prepared.kept
    sloped = sloped_samples(own.prepared)
    return Nothing(
        motion,
        own.time[kept],
        own.prepared.motion.q[kept],
        own.torque[kept],
        own.torque_a_priori[kept],
        own.steady[kept],
        np.searchsorted(kept, sloped),
        *doubts.declared(own.prepared, sloped),
        doubts.anew,
    )


def _bands(
    fit: Callable[..., Fit], model: RobotModel, device: Device, gathered: Gathered, named: NamedBands | None = None
) -> Iterator[tuple[Approach, Callable[[], Fit]]]:
    """What fits them (`fit_springs` or `identify_bands`): by A and the paired estimate where there is a log to compare
    with, by B, and by B with the maker's values."""
    own = [each for each in gathered.evidences if each.worn.device.name == device.name]
    repeats = [gathered.backgrounds[motion].repeats for motion in dict.fromkeys(each.worn.motion for each in own)]
    for approach in APPROACHES:
        used = [each for each in own if approach in ("B", "prior") or each.a is not None]
        if not used:
            continue
        runs = [each.a if approach == "A" else each.paired for each in repeats]
        known = [each.steady for each in runs if each is not None] if approach in ("A", "paired") else []
        found = known or [each.b.steady for each in repeats]
        sigma = np.maximum(np.sqrt(np.mean(np.square(found), axis=0)), LEAST_SIGMA)
        yield approach, partial(fit, model, device, approach, used, sigma, gathered.nothings, gathered.names, named)


def _result(
    model: RobotModel,
    evidences: Sequence[Evidence],
    backgrounds: Mapping[str, Background],
    stiffness: Sequence[StiffnessResult],
    names: Sequence[str],
    settings: SupportSettings,
) -> SupportResult:
    """Trials with their band model, and the summary of each joint."""
    trials: list[Trial] = []
    origin: dict[str, Remark] = {}
    filled: dict[str, Device | None] = {}
    for each in evidences:
        device = each.worn.device
        if device.name not in filled:
            filled[device.name], origin[device.name] = with_values(device, stiffness)
        trials.append(_trial(model, each, filled[device.name], names))
    joints: list[JointSupport] = []
    for device_name, motion in dict.fromkeys((each.device, each.motion) for each in trials):
        chosen = [k for k, one in enumerate(trials) if (one.device, one.motion) == (device_name, motion)]
        own, runs = [evidences[k] for k in chosen], [trials[k] for k in chosen]
        apart = _shifts(own, names, settings)
        joints += [summarise_joint(model, runs, own, backgrounds[motion], joint, apart) for joint in range(len(names))]
    equality = {each.log: (each.reference, each.equality) for each in trials if each.reference is not None}
    return SupportResult(tuple(trials), tuple(joints), origin, tuple(doubts(equality, settings)))


def _shifts(evidences: Sequence[Evidence], names: Sequence[str], settings: SupportSettings) -> list[float]:
    """[s] time in each log minus time in the first, from their starts, at the same posture."""
    if len(evidences) == 1:
        return [0.0]
    first, *others = (Posture(each.worn.log, names) for each in evidences)
    return [0.0, *(match(first, other, settings).lag_s for other in others)]


def _trial(model: RobotModel, evidence: Evidence, device: Device | None, names: Sequence[str]) -> Trial:
    worn, bands = evidence.worn, [band.name for band in evidence.worn.device.bands]
    band_model, tension = None, np.full(evidence.length.shape, np.nan)
    if device is not None:
        band_model, tension = _pulled(model, evidence, device, names)
    return Trial(
        log=worn.log.name,
        device=worn.device.name,
        motion=worn.motion,
        reference=evidence.reference,
        lag_s=evidence.found.lag_s if evidence.found else 0.0,
        time=evidence.time,
        joints=tuple(names),
        q=evidence.q,
        support_a=evidence.a,
        support_a_std=evidence.std_a,
        support_b=evidence.b,
        support_b_std=evidence.std_b,
        support_paired=evidence.paired,
        support_paired_std=evidence.std_paired,
        support_prior=evidence.a_priori,
        band_model=band_model,
        low_a=None if evidence.a is None else evidence.a - evidence.half_a,
        high_a=None if evidence.a is None else evidence.a + evidence.half_a,
        low_b=evidence.low_b,
        high_b=evidence.low_b + 2.0 * evidence.half_b,
        low_paired=evidence.low_paired,
        high_paired=None
        if evidence.low_paired is None or evidence.half_paired is None
        else evidence.low_paired + 2.0 * evidence.half_paired,
        compared=evidence.compared,
        steady=evidence.steady,
        rest=evidence.rest,
        equality=evidence.found.equality if evidence.found else (),
        phase=evidence.phase,
        phase_names=phase_names(model.robot.tree, names[evidence.main]),
        length=dict(zip(bands, evidence.length.T, strict=True)),
        tension=dict(zip(bands, tension.T, strict=True)),
        prediction=evidence.prediction,
    )


def _pulled(model: RobotModel, evidence: Evidence, device: Device, names: Sequence[str]) -> tuple[Array, Array]:
    """(T, D) torque and (T, W) tension of the device's bands with their values."""
    routing = Routing(model.robot.tree, device.bands)
    pulled = band_torque(routing, device.bands, evidence.posture, evidence.time)
    columns = [model.robot.tree.joints.index(name) for name in names]
    return on_joints(pulled.torque, routing, np.array(columns)), pulled.tension


def _all_stated(device: Device) -> bool:
    return all(band.stiffness is not None and band.natural_length is not None for band in device.bands)


def with_values(device: Device, stiffness: Sequence[StiffnessResult]) -> tuple[Device | None, Remark]:
    """The device with a stiffness and natural length for every band, and where they come from."""
    if _all_stated(device):
        return device, Remark(About.BANDS_OF_FILE)
    results = [each for each in stiffness if each.device == device.name and each.approach != "prior"]
    if not results:
        return None, Remark(About.BANDS_UNKNOWN)
    found = {each.band: each for each in results[0].bands}
    values = [found[band.name] for band in device.bands]
    bands = [with_spring(band, (own.stiffness, own.natural_length), own.longest)
             for band, own in zip(device.bands, values, strict=True)]  # fmt: skip
    return replace(device, bands=tuple(bands)), Remark(About.BANDS_IDENTIFIED, beside=(results[0].approach,))
