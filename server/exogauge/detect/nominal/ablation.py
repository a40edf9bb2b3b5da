"""What one of the maker's numbers does to held-out errors: the identified model as it is, and with that number put back
to what is stated."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from exogauge.detect.nominal.contradicted import Change
from exogauge.detect.nominal.nominal_values import gain_columns
from exogauge.findings.result import HeldOut
from exogauge.identification.identify import identify
from exogauge.identification.model import RobotModel
from exogauge.identification.predict import Parameters, measured_channels, motor_gain, predictions
from exogauge.identification.result import Identification
from exogauge.identification.settings import Recording, Settings
from exogauge.identification.validate import floors_of, rmse_in_steady_motion, unit_of
from exogauge.logs.model import Log
from exogauge.search.locate import pooled

Array = NDArray[np.float64]
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
