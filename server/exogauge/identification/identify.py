"""Section 3 of [Evaluator], in order: equations, weights, prior, static friction's sign, solution, uncertainty."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.effects.catalogue import choose
from exogauge.errors import BadLog, BadStudy, Fault
from exogauge.estimation.prior import Prior
from exogauge.identification.added_columns import PREFIX, load_columns, parts_of_links, zero_columns
from exogauge.identification.axis_signals import inertia_and_slope
from exogauge.identification.bandwidth import choose_cutoff, quick_fit
from exogauge.identification.common_factor import (
    CommonFactor,
    common_factor,
    remarks_on_the_factor,
    scale_is_measured,
)
from exogauge.identification.disturbances import type_b
from exogauge.identification.equations import Equations
from exogauge.identification.model import AxisSizes, Extension, RobotModel
from exogauge.identification.noise_bias import NoiseFloor, known_noise, noise_bias
from exogauge.identification.parameters import describe, given_the_scale, with_parts
from exogauge.identification.per_log import PerLog
from exogauge.identification.predict import Parameters, motor_gain, split
from exogauge.identification.preparation import Prepared, prepare
from exogauge.identification.prior import Scales, added_std, joint_prior, per_parameter, relative_std, scales
from exogauge.identification.ranges import asked_for_negative_mass, clip_to_ranges, possible_parameters
from exogauge.identification.result import ChannelFit, Channels, Identification, Prediction, SteadyShare
from exogauge.identification.settings import Recording, Settings
from exogauge.identification.solution import Solution, solve
from exogauge.identification.static_friction import fill_static_friction
from exogauge.identification.steady import (
    hardly_sliding,
    remarks_on_creeping,
    remarks_on_sliding,
    remarks_on_steady,
    seconds,
    steady_shares,
)
from exogauge.identification.total_mass import remarks_on_total_mass, total_mass
from exogauge.identification.turns import RestDetection, rest_detection
from exogauge.identification.type_b import TypeB, lifted_by_source
from exogauge.identification.uncertainty import score_covariance
from exogauge.identification.validate import fits, noise_floors, predict_log, prediction_of
from exogauge.logs.model import Log
from exogauge.progress import Doing, Progress, unwatched
from exogauge.remarks import About, Remark
from exogauge.robots.consistency import is_physical
from exogauge.robots.cuts import CutRows
from exogauge.robots.description import Robot
from exogauge.robots.parameters import find_base_parameters
from exogauge.robots.row_blocks import RowBlocks
from exogauge.side_by_side import each as side_by_side

Array = NDArray[np.float64]

NO_GAINS = np.zeros(0, dtype=np.intp)


def identify(
    robot: Robot,
    recordings: Sequence[Recording],
    settings: Settings,
    progress: Progress = unwatched,
    extension: Extension | None = None,
) -> Identification:
    """Identify `robot` from the recordings that are not held out; predict all of them.

    extension: effects to add to the model of an earlier identification, whose bandwidth is kept.
    Raises BadStudy without a log to fit, BadLog for a log that lacks a channel or has gaps in time; `progress` may
    raise to stop.
    """
    made = _made(robot, recordings, settings, progress, extension)
    equations, solution, prior, fitted = made.equations, made.solution, made.prior, made.fitted
    doubted = _doubted(made)
    factor, covariance = doubted.factor, doubted.covariance
    solution.solved.shift(-made.bias)
    standard, notes = _standard_parameters(made, settings, progress, covariance)
    identified, before = split(equations, standard), split(equations, prior.mean)
    known_floors = extension.noise_floors if extension else {}
    predictions, validation, steady = _validate(made, recordings, (identified, before), known_floors, progress)
    condition, rank = solution.solved.condition_and_rank()
    hardly = hardly_sliding(equations.robot, fitted, settings.criteria)
    gains = solution.gains.columns + (len(standard) - equations.size)
    but_for_scale = covariance if factor.known else given_the_scale(covariance, gains, standard)
    parameters = describe(equations, solution, standard, covariance, but_for_scale, hardly)
    unidentifiable = tuple(
        each.name for each in parameters if not each.identifiable and not each.name.startswith(PREFIX)
    )
    if not factor.known:
        parameters = tuple(replace(each, identifiable=False) for each in parameters)
    feet = settings.criteria.identifying.feet_against_mass
    weighed = total_mass(equations.robot, solution.prior, standard, covariance, feet)
    parameters = with_parts(parameters, lifted_by_source(doubted.inputs, solution.prior.lifted))
    model = _model(made, (identified, before), doubted.doubt, recordings, settings, extension)
    model = replace(model, known_scale=factor.known, inputs=doubted.inputs)
    names = [each.log.recording for each in fitted]
    progress(1.0, Doing.IDENTIFIED)
    return Identification(
        phi=identified.phi,
        joint_values={effect.coefficient.name: identified.xi[:, k] for k, effect in enumerate(equations.effects)},
        parameters=parameters,
        unidentifiable=unidentifiable,
        validation=validation,
        predictions=predictions,
        consistent_links=tuple(bool(is_physical(one)) for one in identified.phi),
        prior_strength=solution.strength,
        prior_curve=solution.curve,
        condition=condition,
        rank=rank,
        samples=sum(len(one.kept) for one in fitted),
        cutoff_hz=made.cutoff_hz,
        velocity_threshold=made.at_rest.threshold,
        remarks=(
            *_remarks(equations.robot, names, settings, solution, factor, notes, steady),
            *remarks_on_sliding(hardly, settings.criteria, equations.robot.tree.sliding),
            *remarks_on_total_mass(weighed),
        ),
        model=model,
        steady=steady,
        per_stated={} if factor.known else _per_stated(equations, identified, before),
        factor=factor,
        total_mass=weighed,
    )


def seen_by_effects(
    robot: Robot, recordings: Sequence[Recording], settings: Settings, extension: Extension
) -> RobotModel:
    """The model of `identify` for the effects of another one to see: what it predicts is not computed, and of its doubt
    no more than that of white residuals."""
    made = _made(robot, recordings, settings, unwatched, extension)
    made.solution.solved.shift(-made.bias)
    standard, _ = _standard_parameters(made, settings, unwatched)
    parameters = split(made.equations, standard), split(made.equations, made.prior.mean)
    return _model(made, parameters, made.solution.unbounded.covariance(), recordings, settings, extension)


@final
@dataclass(frozen=True)
class _Made:
    """The solution and what it was made of. ready: prepares a log as the fitted ones. seen: what axes do in these.
    bias: (P,) what noise in the regressor pulls the solution by, which it still holds. started: of the settings."""

    equations: Equations
    fitted: Sequence[Prepared]
    ready: Callable[[Log], Prepared]
    at_rest: RestDetection
    cutoff_hz: float
    kept: PerLog
    attached: PerLog
    seen: Scales
    prior: Prior
    solution: Solution
    bias: Array
    started: Mapping[str, float]


def _made(
    robot: Robot,
    recordings: Sequence[Recording],
    settings: Settings,
    progress: Progress,
    extension: Extension | None,
) -> _Made:
    fitted_logs = _fitted_logs(recordings)
    names = [log.recording for log in fitted_logs]
    progress(0.0, Doing.CHOOSING_BANDWIDTH)
    equations = _equations(parts_of_links(robot, names, relative_std(robot)), settings, extension)
    robot, cutoff_hz = equations.robot, _cutoff(equations, recordings, fitted_logs, settings, extension)
    progress(0.05, Doing.FILTERING)
    at_rest = rest_detection(robot, fitted_logs, cutoff_hz, settings.creeping, settings.criteria.resting)

    kept, attached = _prepared_alike(extension, robot, cutoff_hz, at_rest), PerLog()

    def ready(log: Log) -> Prepared:
        bare = kept.of(log, "prepared", lambda: prepare(robot, log, cutoff_hz, at_rest))
        if extension is None:
            return bare
        return bare.with_added(*attached.of(log, "attached", lambda: extension.added_to(bare)))

    fitted = list(side_by_side(ready, fitted_logs))
    seen = scales(robot, fitted)
    added = added_std(equations, fitted, seen)
    prior = per_parameter(robot, equations.base, equations.effects, seen, added, equations.added)
    solution = solve(equations, fitted, prior, settings, progress)
    _refuse_impossible_gains(equations, solution)
    progress(0.75, Doing.ESTIMATING_UNCERTAINTY)
    bias = noise_bias(equations, fitted, at_rest, solution, kept)
    return _Made(
        equations, fitted, ready, at_rest, cutoff_hz, kept, attached, seen, prior, solution, bias, settings.started
    )


def _model(
    made: _Made,
    parameters: tuple[Parameters, Parameters],
    covariance: Array,
    recordings: Sequence[Recording],
    settings: Settings,
    extension: Extension | None,
) -> RobotModel:
    """parameters: identified, and as they were believed to be."""
    equations, fitted, seen = made.equations, made.fitted, made.seen
    inertias = _inertias(equations, parameters[0], fitted)
    return RobotModel(
        equations=equations,
        identified=parameters[0],
        a_priori=parameters[1],
        covariance=covariance,
        a_priori_covariance=made.prior.seen_covariance,
        at_rest=made.at_rest,
        cutoff_hz=made.cutoff_hz,
        solution=made.solution,
        sizes=AxisSizes(seen.velocity, seen.torque, _ranges(equations.robot, fitted), inertias),
        extension=extension,
        order={recording.log.name: number for number, recording in enumerate(recordings)},
        criteria=settings.criteria,
        prepared=made.kept,
        computed=PerLog(),
        attached=made.attached,
    )


@final
@dataclass(frozen=True)
class _Doubted:
    """What is known of the solution's errors.

    doubt: (X, X) covariance of the solution, with gains, noise, and what no log shows (inputs). covariance: (S, S) the
    same of the standard parameters.
    """

    factor: CommonFactor
    inputs: TypeB
    doubt: Array
    covariance: Array


def _doubted(made: _Made) -> _Doubted:
    """Of the solution before its bias is taken off."""
    equations, fitted, solution = made.equations, made.fitted, made.solution
    meat = score_covariance(equations, fitted, solution)
    factor = common_factor(equations, solution, meat)
    inputs = type_b(equations, fitted, solution, split(equations, _lifted(solution)).xi, made.cutoff_hz, made.started)
    doubt = solution.unbounded.covariance(meat) + solution.gains.doubt + np.outer(made.bias, made.bias)
    doubt += sum(inputs.by_log.values(), inputs.alike)
    return _Doubted(factor, inputs, doubt, solution.prior.lift_covariance(doubt))


def _lifted(solution: Solution) -> Array:
    return solution.solved.prior.lift(solution.solved.x)


def _fitted_logs(recordings: Sequence[Recording]) -> list[Log]:
    logs = [recording.log for recording in recordings if not recording.held_out]
    if not logs:
        advice = "Give at least one log the role `identification`."
        raise BadStudy(Fault("there is no log to identify from", "no_identification_log", advice))
    return logs


def _equations(robot: Robot, settings: Settings, extension: Extension | None) -> Equations:
    """With the zeros of sensors, the loads that some logs carry, and the effects that were added."""
    added = (*zero_columns(robot), *load_columns(robot), *(extension.columns if extension else ()))
    effects, criteria = choose(settings.effects), settings.criteria
    parent = extension.parent.equations if extension else None
    if parent is not None and parent.robot.tree is robot.tree:  # what bodies do to the rows is the same
        return replace(parent, robot=robot, effects=effects, added=added, criteria=criteria)
    base = find_base_parameters(robot.tree)
    blocks = RowBlocks(robot.tree, base, robot.axes_from_joints)
    cuts = [CutRows(robot.tree, base, sensor.frame) for sensor in robot.cuts]
    return Equations(robot, blocks, base, effects, added, cuts, criteria)


def _cutoff(
    equations: Equations,
    recordings: Sequence[Recording],
    fitted_logs: Sequence[Log],
    settings: Settings,
    extension: Extension | None,
) -> float:
    """[Hz] of the model that effects are added to; as asked for; or as the logs call for it."""
    stated = extension.parent.cutoff_hz if extension else settings.cutoff_hz
    slowest_hz = min(recording.log.rate_hz for recording in recordings)
    held_out = [recording.log for recording in recordings if recording.held_out]
    judged = max(held_out, key=lambda log: log.samples, default=None)
    return stated or choose_cutoff(equations.robot, fitted_logs, slowest_hz, partial(quick_fit, equations, judged))


def _prepared_alike(extension: Extension | None, robot: Robot, cutoff_hz: float, at_rest: RestDetection) -> PerLog:
    """The parent's prepared logs where it prepares them alike."""
    if extension is None:
        return PerLog()
    model = extension.parent
    alike = model.robot is robot and model.cutoff_hz == cutoff_hz and model.at_rest.cutoff_hz == at_rest.cutoff_hz
    same = alike and np.array_equal(model.at_rest.threshold, at_rest.threshold)
    return model.prepared if same else PerLog()


def _standard_parameters(
    made: _Made, settings: Settings, progress: Progress, covariance: Array | None = None
) -> tuple[Array, tuple[Remark, ...]]:
    """(S,) [φ; ξ], with static friction filled in and every link possible where that is asked for; and notes.

    covariance: (S, S) of them; without it nothing is noted of what data alone would have asked for.
    """
    equations, solution, prior = made.equations, made.solution, made.prior
    standard, notes = _lifted(solution), tuple[Remark, ...]()
    if settings.consistency == "physical":
        progress(0.8, Doing.MAKING_LINKS_POSSIBLE)
        free, robot = standard, equations.robot
        decided = NO_GAINS if scale_is_measured(robot) else solution.gains.columns
        standard, notes = possible_parameters(robot, solution.solved, decided)
        if covariance is not None:
            std = np.sqrt(np.maximum(np.diag(covariance), 0.0))
            notes = (*notes, *asked_for_negative_mass(robot, free, std, settings.criteria.identifying.negative_mass))
    x = fill_static_friction(equations, solution.statistics, prior, prior.seen @ standard).x
    phi = standard[: equations.robot.tree.phi.size]
    return np.concatenate([phi, clip_to_ranges(equations, x[equations.base_size :])]), notes


def _remarks(
    robot: Robot,
    names: Sequence[str],
    settings: Settings,
    solution: Solution,
    factor: CommonFactor,
    notes: Sequence[Remark],
    steady: Sequence[SteadyShare],
) -> tuple[Remark, ...]:
    """notes: what making links possible had to say."""
    told = ((About.HELD_AT_EDGE, solution.held), (About.STICKS_UNEQUALLY, solution.sticking.lower_bounds))
    return (
        *remarks_on_the_factor(robot, factor, names),
        *notes,
        *(Remark(about, tuple(each)) for about, each in told if each),
        *remarks_on_creeping(settings.creeping, robot.tree.sliding),
        *remarks_on_steady(steady, settings.criteria.identifying),
    )


def _ranges(robot: Robot, logs: Sequence[Prepared]) -> Array:
    """(A,) of each axis' position over all logs."""
    positions = [robot.on_axes(log.motion.q) for log in logs]
    return np.asarray(
        np.max([q.max(axis=0) for q in positions], axis=0) - np.min([q.min(axis=0) for q in positions], axis=0)
    )


def _inertias(equations: Equations, identified: Parameters, logs: Sequence[Prepared]) -> Array:
    """(A,) mean of what each axis turns."""
    postures = 50  # of a log, for the mean inertia about each axis
    phi = equations.base.regroup @ identified.phi.ravel()
    some = [log.motion.rows(log.kept[:: max(1, len(log.kept) // postures)]) for log in logs]
    return np.asarray(np.mean([inertia_and_slope(equations, phi, each)[0].mean(axis=0) for each in some], axis=0))


def _validate(
    made: _Made,
    recordings: Sequence[Recording],
    parameters: tuple[Parameters, Parameters],
    known_floors: Mapping[tuple[str, str], NoiseFloor],
    progress: Progress,
) -> tuple[tuple[Prediction, ...], tuple[ChannelFit, ...], tuple[SteadyShare, ...]]:
    """Predictions and fits of every recording, those that were fitted included and marked; and their steady motion."""
    equations, fitted, made_ready = made.equations, made.fitted, made.ready
    ready = {id(prepared.log): prepared for prepared in fitted}
    k_T = motor_gain(equations, parameters[0])
    known = known_noise(equations.robot, [each.log for each in recordings], fitted[0].low_pass.cutoff_hz)
    predictions: list[Prediction] = []
    validation: list[ChannelFit] = []
    held_out: list[Array] = []

    def told(prepared: Prepared) -> Channels:
        return predict_log(equations, prepared, *parameters, k_T)

    def predicted(recording: Recording) -> tuple[Array, Prediction, tuple[ChannelFit, ...]]:
        log, held_out = recording.log, recording.held_out
        prepared = ready.get(id(log)) or made.ready(log)
        now = told(prepared)
        floors = {channel: floor for (name, channel), floor in known_floors.items() if name == log.name}
        floors = floors or dict(noise_floors(equations, prepared, parameters[0], k_T, made.at_rest, now, known))
        prediction = prediction_of(log, held_out, equations, lambda: told(made_ready(log)))
        return seconds(prepared), prediction, fits(now, held_out, prepared, equations, parameters[0], floors)

    progress(0.85, Doing.PREDICTING, recordings[0].log.name)
    for recording, found in zip(recordings, side_by_side(predicted, recordings), strict=True):
        progress(0.85 + 0.15 * len(predictions) / len(recordings), Doing.PREDICTING, recording.log.name)
        held_out += [found[0]] if recording.held_out else []
        predictions.append(found[1])
        validation += found[2]
    joints = [joint.name for joint in equations.robot.joints]
    steady = steady_shares(joints, [seconds(each) for each in fitted], held_out)
    return tuple(predictions), tuple(validation), steady


def _per_stated(equations: Equations, identified: Parameters, stated: Parameters) -> dict[str, float]:
    """Channel -> stated over identified k_T."""
    pairs = zip(equations.robot.joints, motor_gain(equations, identified), motor_gain(equations, stated), strict=True)
    return {f"tau.{joint.name}": float(then / now) for joint, now, then in pairs if joint.actuation == "current"}


def _refuse_impossible_gains(equations: Equations, solution: Solution) -> None:
    """A k_T that vanishes or has no end explains nothing: the current does not belong to the motion."""
    faults, possible = [], equations.criteria.identifying.possible
    for axis, joint in enumerate(equations.robot.joints):
        column = solution.gains.column_of(axis)
        if column is None:
            continue
        stated, found = joint_prior(joint, "k_T"), float(solution.solved.x[column])
        if not possible[0] * stated <= found <= possible[1] * stated:
            faults.append(
                Fault(
                    f"the torque constant of {joint.name} comes out as {found:.3g} N·m/A where {stated:.3g} is stated: "
                    "its current does not go with its motion",
                    "torque_constant_impossible",
                    "Look at the sign, the unit and the order of the currents and positions, and at gear_ratio; "
                    "`exogauge doctor` compares them with the robot joint by joint.",
                    column=f"i.{joint.name}",
                    value=f"{found:.3g}",
                )
            )
    if faults:
        raise BadLog(faults)
