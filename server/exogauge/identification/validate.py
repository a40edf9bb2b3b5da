"""How well the identified robot predicts each channel, before and after, against the noise of the sensors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from exogauge.identification.equations import Equations
from exogauge.identification.predict import (
    BASE_CHANNELS,
    Parameters,
    measured_channels,
    predicted_channels,
    predictions,
)
from exogauge.identification.preparation import Prepared, RestDetection, needed_channels, prepare
from exogauge.identification.result import ChannelFit, Prediction
from exogauge.logs.model import Log
from exogauge.logs.noise import white_noise_std

Array = NDArray[np.float64]

NOISE_ABOVE = 2.0  # times the cut-off: what a channel holds beyond is taken for noise


def predict_log(
    equations: Equations, prepared: Prepared, identified: Parameters, prior: Parameters, k_T: Array, held_out: bool
) -> Prediction:
    """One log explained by the identified and by the a-priori parameters. k_T: (A,) identified."""
    measured = measured_channels(equations, prepared, k_T)
    predicted, predicted_prior = predictions(equations, prepared, [identified, prior])
    return Prediction(
        log=prepared.log.name,
        held_out=held_out,
        time=prepared.log.time,
        measured=measured,
        predicted=predicted,
        predicted_prior=predicted_prior,
        units={name: "N" if name.startswith("base.f") else "N·m" for name in measured},
    )


def fits(
    prediction: Prediction, prepared: Prepared, equations: Equations, floors: Mapping[str, float]
) -> tuple[ChannelFit, ...]:
    """RMSE of every channel over all samples of one log. floors: from `noise_floors`."""
    joints = enumerate(equations.robot.joints)
    resting = {f"tau.{joint.name}": prepared.raw_direction[:, axis] == 0.0 for axis, joint in joints}
    moving = steady_samples(equations, prepared)
    result = []
    for channel, measured in prediction.measured.items():
        error = measured - prediction.predicted[channel]
        rest = resting.get(channel, np.zeros(len(error), dtype=bool))
        result.append(
            ChannelFit(
                channel=channel,
                unit=prediction.units[channel],
                log=prediction.log,
                held_out=prediction.held_out,
                rmse_prior=rms(measured - prediction.predicted_prior[channel]),
                rmse_identified=rms(error),
                noise_floor=floors[channel],
                rest_share=float(rest.mean()),
                rmse_moving=rms(error[moving[channel]]) if moving[channel].any() else None,
                rmse_at_rest=rms(error[rest]) if rest.any() else None,
            )
        )
    return tuple(result)


def noise_floors(
    equations: Equations,
    prepared: Prepared,
    identified: Parameters,
    k_T: Array,
    at_rest: RestDetection,
    prediction: Prediction,
) -> Mapping[str, float]:
    """Channel -> the RMSE that the sensors' noise alone would leave under a perfect model.

    The noise of every logged channel (white, its size from the channel's own part above twice the cut-off, or what
    the maker states if that is more) is drawn once more, added, and the log predicted again: what that changes in
    the residual is as large as what the noise already in it did. Signs of velocities are left as they were.
    """
    log, robot = prepared.log, equations.robot
    rate = log.rate_hz
    above = min(NOISE_ABOVE * prepared.low_pass.cutoff_hz, 0.4 * rate)
    rng = np.random.default_rng(0)
    noisy = {}
    for name in needed_channels(robot):
        std = max(white_noise_std(log.channels[name], rate, above), robot.noise.get(noise_kind(name), 0.0))
        noisy[name] = log.channels[name] + std * rng.normal(size=log.samples)
    again = prepare(robot, Log(log.name, log.time, noisy), prepared.low_pass.cutoff_hz, at_rest)
    again = replace(again, raw_direction=prepared.raw_direction)
    measured = measured_channels(equations, again, k_T)
    predicted = predicted_channels(equations, again, identified)
    return {
        channel: rms(
            (measured[channel] - predicted[channel]) - (prediction.measured[channel] - prediction.predicted[channel])
        )
        for channel in measured
    }


def steady_samples(equations: Equations, prepared: Prepared) -> Mapping[str, NDArray[np.bool_]]:
    """Channel -> (T,) samples in steady motion; all of them for the base wrench, which knows no friction."""
    steady = {channel: np.ones(prepared.log.samples, dtype=bool) for channel in BASE_CHANNELS}
    steady |= {f"tau.{joint.name}": prepared.steady[:, axis] for axis, joint in enumerate(equations.robot.joints)}
    return steady


def noise_kind(channel: str) -> str:
    """Key in `Robot.noise` of a channel."""
    if channel.startswith("ft."):
        return "force" if channel.rsplit(".", 1)[1].startswith("f") else "moment"
    return channel.split(".", 1)[0]


def rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))
