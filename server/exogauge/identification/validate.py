"""How well the identified robot predicts each channel, before and after, against the noise of the sensors."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from exogauge.identification.equations import Equations
from exogauge.identification.noise_bias import NoiseFloor, draw_noise, with_noise
from exogauge.identification.predict import (
    Parameters,
    added_beyond_band,
    measured_channels,
    predictions,
    told_channels,
)
from exogauge.identification.preparation import BASE_CHANNELS, Prepared, wrench_channels
from exogauge.identification.result import ChannelFit, Channels, Prediction
from exogauge.identification.turns import RestDetection
from exogauge.logs.model import Log
from exogauge.robots.description import Robot

Array = NDArray[np.float64]


def predict_log(
    equations: Equations, prepared: Prepared, identified: Parameters, prior: Parameters, k_T: Array
) -> Channels:
    """One log explained by the identified and by the a-priori parameters. k_T: (A,) identified."""
    measured = measured_channels(equations, prepared, k_T)
    predicted, known = predictions(equations, prepared, [identified, prior])
    return Channels(measured, predicted, known, steady_samples(equations, prepared))


def prediction_of(log: Log, held_out: bool, equations: Equations, channels: Callable[[], Channels]) -> Prediction:
    """channels: of this log, by `predict_log`."""
    names = told_channels(equations.robot)
    return Prediction(log.name, held_out, log.time, {name: unit_of(name, equations.robot) for name in names}, channels)


def fits(
    told: Channels,
    held_out: bool,
    prepared: Prepared,
    equations: Equations,
    identified: Parameters,
    floors: Mapping[str, NoiseFloor],
) -> tuple[ChannelFit, ...]:
    """RMSE of every channel over all samples of one log. floors: from `noise_floors`."""
    log = prepared.log
    joints = enumerate(equations.robot.joints)
    resting = {f"tau.{joint.name}": prepared.raw_direction[:, axis] == 0.0 for axis, joint in joints}
    moving = rmse_in_steady_motion(equations, prepared, told.measured, told.predicted, identified, floors)
    steady = steady_samples(equations, prepared)
    step_s = float(np.median(np.diff(log.time)))
    result = []
    for channel, measured in told.measured.items():
        error = measured - told.predicted[channel]
        rest = resting.get(channel, np.zeros(len(error), dtype=bool))
        result.append(
            ChannelFit(
                channel=channel,
                unit=unit_of(channel, equations.robot),
                log=log.name,
                held_out=held_out,
                rmse_prior=rms(measured - told.predicted_prior[channel]),
                rmse_identified=rms(error),
                noise_floor=floors[channel].whole,
                noise_beyond_band=floors[channel].beyond_band,
                rest_share=float(rest.mean()),
                rmse_moving=moving[channel],
                rmse_at_rest=rms(error[rest]) if rest.any() else None,
                steady_s=step_s * int(np.count_nonzero(steady[channel])),
                moved_s=step_s * int(np.count_nonzero(~rest)),
            )
        )
    return tuple(result)


def rmse_in_steady_motion(
    equations: Equations,
    prepared: Prepared,
    measured: Mapping[str, Array],
    predicted: Mapping[str, Array],
    parameters: Parameters,
    floors: Mapping[str, NoiseFloor],
) -> Mapping[str, float | None]:
    """Channel -> RMSE below the cut-off, and above it that of the sensors' noise; None where no motion is steady.

    Above the cut-off the equations say nothing: what a robot shakes there faster than it was asked to move is no fault
    of the model. predicted: by the parameters.
    """
    names, steady = list(predicted), steady_samples(equations, prepared)
    low_passed = _within_band(prepared, [measured[name] for name in names])
    beyond = added_beyond_band(equations, prepared, parameters)

    def rmse(name: str, values: Array) -> float | None:
        error = (values - (predicted[name] - beyond[name]))[steady[name]]
        return float(np.hypot(rms(error), floors[name].beyond_band)) if error.size else None

    return {name: rmse(name, values) for name, values in zip(names, low_passed, strict=True)}


def noise_floors(
    equations: Equations,
    prepared: Prepared,
    identified: Parameters,
    k_T: Array,
    at_rest: RestDetection,
    told: Channels,
    known: Mapping[str, float],
) -> Mapping[str, NoiseFloor]:
    """Channel -> what the sensors' noise alone would leave in steady motion under a perfect model.

    The noise of every logged channel is drawn once more, added, and the log predicted again: what that changes in
    the residual is as large as what the noise already in it did. Signs of velocities are left as they were. At rest the
    noise also decides which way friction holds, by twice its size: that says nothing of the sensors and is not counted
    where there is steady motion. known: of channels that were low-passed before they were stored, from logs that were
    not (`known_noise`).
    """
    noise = draw_noise(equations.robot, prepared, np.random.default_rng(0), known)
    again = with_noise(equations.robot, prepared, noise, 1.0, at_rest)
    measured = measured_channels(equations, again, k_T)
    (predicted,) = predictions(equations, again, [identified])
    moving = steady_samples(equations, prepared)
    noises = [values - told.measured[channel] for channel, values in measured.items()]

    def floor(channel: str, noise: Array, within_band: Array) -> NoiseFloor:
        change = noise - (predicted[channel] - told.predicted[channel])
        inside = moving[channel] if moving[channel].any() else np.ones(len(noise), dtype=bool)
        return NoiseFloor(rms(change[inside]), rms((noise - within_band)[inside]))

    low_passed = _within_band(prepared, noises)
    return {name: floor(name, *both) for name, both in zip(measured, zip(noises, low_passed, strict=True), strict=True)}


def floors_of(validation: Sequence[ChannelFit]) -> Mapping[tuple[str, str], NoiseFloor]:
    """(log, channel) -> what was found for these fits."""
    return {(fit.log, fit.channel): NoiseFloor(fit.noise_floor, fit.noise_beyond_band) for fit in validation}


def _within_band(prepared: Prepared, channels: Sequence[Array]) -> Array:
    """(C, T) through the equations' low-pass; a log that was low-passed before it was stored passes that no second
    time."""
    return replace(prepared.low_pass, stored=None).apply(np.column_stack(channels)).T


def steady_samples(equations: Equations, prepared: Prepared) -> Mapping[str, NDArray[np.bool_]]:
    """Channel -> (T,) samples in steady motion; where there is no friction (base wrench, sensors), all that are not
    left out. Not the ends of the log, where the low-pass has not settled."""
    settled, axes = prepared.settled, enumerate(equations.robot.joints)
    steady = dict.fromkeys(BASE_CHANNELS, settled & ~prepared.left_out)
    steady |= {f"tau.{joint.name}": settled & prepared.steady[:, axis] for axis, joint in axes}
    steady |= {name: steady[BASE_CHANNELS[0]] for cut in equations.robot.cuts for name in wrench_channels(cut.name)}
    return steady


def unit_of(channel: str, robot: Robot) -> str:
    """Of a base wrench, a sensor's reading or a joint's torque, which of one that slides is a force."""
    if channel.startswith("tau.") and channel.removeprefix("tau.") in robot.tree.sliding:
        return "N"
    return "N" if not channel.startswith("tau.") and channel.rsplit(".", 1)[1].startswith("f") else "N·m"


def rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))
