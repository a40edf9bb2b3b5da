"""Section 3 of [Evaluator], in order: equations, weights, prior, static friction's sign, solution, uncertainty."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.effects.catalogue import choose
from exogauge.errors import BadStudy, Fault
from exogauge.estimation.least_squares import PriorLeastSquares
from exogauge.estimation.prior import Prior
from exogauge.estimation.statistics import Form, Statistics
from exogauge.identification.equations import Equations
from exogauge.identification.parameters import describe, scale_is_known
from exogauge.identification.physical import possible_parameters
from exogauge.identification.predict import Parameters
from exogauge.identification.preparation import Prepared, choose_cutoff, prepare, velocity_threshold
from exogauge.identification.prior import as_printed, hold_scale, per_parameter, scales
from exogauge.identification.result import ChannelFit, Identification, Prediction
from exogauge.identification.settings import Progress, Recording, Settings
from exogauge.identification.strength import choose_strength
from exogauge.identification.uncertainty import score_covariance
from exogauge.identification.validate import fits, noise_floors, predict_log
from exogauge.identification.weights import first_weights, solve_and_weigh
from exogauge.robots.base_parameters import find_base_parameters
from exogauge.robots.consistency import is_physical
from exogauge.robots.description import Robot
from exogauge.robots.row_blocks import row_blocks

Array = NDArray[np.float64]

SIGN_PASSES = 3  # passes over the data; each takes the static friction's sign from the solution before
FOLDS = 4  # consecutive parts of a fitted log, left out in turn to choose the prior's strength


def identify(
    robot: Robot,
    recordings: Sequence[Recording],
    settings: Settings,
    progress: Progress = lambda _fraction, _phrase: None,
) -> Identification:
    """Identify `robot` from the recordings that are not held out; predict all of them.

    Raises BadStudy without a log to fit, BadLog for a log that lacks a channel or has gaps in time; `progress` may
    raise to stop.
    """
    fitted_logs = [recording.log for recording in recordings if not recording.held_out]
    if not fitted_logs:
        advice = "Give at least one log the role `identification`."
        raise BadStudy(Fault("there is no log to identify from", "no_identification_log", advice))
    progress(0.0, "filtering and differentiating")
    cutoff_hz = settings.cutoff_hz or choose_cutoff(robot, fitted_logs)
    threshold = velocity_threshold(robot, fitted_logs, cutoff_hz)
    fitted = [prepare(robot, log, cutoff_hz, threshold) for log in fitted_logs]
    base = find_base_parameters(robot.tree)
    equations = Equations(robot, row_blocks(robot.tree, base, robot.axes_from_joints), base, choose(settings.effects))
    seen = scales(robot, fitted)
    prior = per_parameter(robot, base, equations.effects, seen)
    warnings = []
    if not scale_is_known(robot):
        prior, warning = hold_scale(robot, equations.effects, prior, seen)
        warnings.append(warning)

    solution = _solve(equations, fitted, prior, settings, progress)
    progress(0.75, "estimating the uncertainty")
    meat = score_covariance(equations, fitted, solution.solved.x, solution.weights)
    covariance = solution.prior.lift_covariance(solution.solved.covariance(meat))
    standard = solution.prior.lift(solution.solved.x)
    if settings.consistency == "physical":
        progress(0.8, "making every link physically possible")
        standard, notes = possible_parameters(robot, solution.solved)
        warnings += notes
    N, A, K = len(robot.tree.bodies), len(robot.joints), len(equations.effects)
    phi, xi = standard[: 10 * N].reshape(N, 10), standard[10 * N :].reshape(A, K)
    identified = Parameters(phi, xi)
    before = Parameters(robot.tree.phi, solution.prior.mean[10 * N :].reshape(A, K))
    predictions, validation = _validate(
        equations, recordings, fitted, cutoff_hz, threshold, (identified, before), progress
    )
    condition, rank = solution.solved.condition_and_rank()
    parameters = describe(equations, solution.prior, standard, covariance)
    progress(1.0, "identified")
    return Identification(
        phi=phi,
        joint_values={effect.coefficient.name: xi[:, k] for k, effect in enumerate(equations.effects)},
        parameters=parameters,
        unidentifiable=tuple(p.name for p in parameters if not p.identifiable),
        validation=validation,
        predictions=predictions,
        consistent_links=tuple(bool(is_physical(one)) for one in phi),
        prior_strength=solution.strength,
        prior_curve=solution.curve,
        condition=condition,
        rank=rank,
        samples=sum(len(one.kept) for one in fitted),
        cutoff_hz=cutoff_hz,
        velocity_threshold=threshold,
        warnings=tuple(warnings),
    )


@final
@dataclass(frozen=True)
class Solution:
    """What the sign passes end with. weights: (rows,) 1/variance. curve: (strength, held-out score)."""

    solved: PriorLeastSquares
    statistics: Statistics
    weights: Array
    prior: Prior
    strength: float
    curve: tuple[tuple[float, float], ...]


def _solve(
    equations: Equations, fitted: Sequence[Prepared], prior: Prior, settings: Settings, progress: Progress
) -> Solution:
    x, strength = prior.seen_mean, settings.prior_strength or 1.0
    curve: tuple[tuple[float, float], ...] = ()
    weights = first_weights(equations, fitted)
    form: Form = "gram" if settings.solver == "statistics" else "factor"
    belief = prior
    for number in range(SIGN_PASSES):
        folds: list[Statistics] = []
        for index, prepared in enumerate(fitted):

            def tick(fraction: float, done: int = number * len(fitted) + index) -> None:
                progress(0.05 + 0.7 * (done + fraction) / (SIGN_PASSES * len(fitted)), "collecting the equations")

            folds += equations.collect(prepared, x, FOLDS, form, tick)
        total = sum(folds[1:], folds[0])
        if settings.prior == "as_printed":
            belief = as_printed(equations.robot, prior, total, weights, equations.base_size, len(equations.effects))
        solved, weights = solve_and_weigh(total, weights, belief, strength, equations)
        if settings.prior_strength is None:
            strength, curve = choose_strength(folds, total, weights, belief, settings.prior)
            solved, weights = solve_and_weigh(total, weights, belief, strength, equations)
        x = solved.x
    return Solution(solved, total, weights, belief, strength, curve)


def _validate(
    equations: Equations,
    recordings: Sequence[Recording],
    fitted: Sequence[Prepared],
    cutoff_hz: float,
    threshold: Array,
    parameters: tuple[Parameters, Parameters],
    progress: Progress,
) -> tuple[tuple[Prediction, ...], tuple[ChannelFit, ...]]:
    """Predictions and fits of every recording, those that were fitted included and marked."""
    ready = {id(prepared.log): prepared for prepared in fitted}
    gain = [k for k, effect in enumerate(equations.effects) if effect.name == "motor_gain"]
    k_T = parameters[0].xi[:, gain].sum(axis=1) if gain else np.ones(len(equations.robot.joints))
    predictions: list[Prediction] = []
    validation: list[ChannelFit] = []
    for index, recording in enumerate(recordings):
        progress(0.85 + 0.15 * index / len(recordings), f"predicting {recording.log.name}")
        prepared = ready.get(id(recording.log)) or prepare(equations.robot, recording.log, cutoff_hz, threshold)
        prediction = predict_log(equations, prepared, *parameters, k_T, recording.held_out)
        predictions.append(prediction)
        floors = noise_floors(equations, prepared, parameters[0], k_T, threshold, prediction)
        validation += fits(prediction, prepared, equations, floors)
    return tuple(predictions), tuple(validation)
