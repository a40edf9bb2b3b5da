"""Both stages with what the sensor's calibration leaves in doubt, and with what data show of it taken out."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from exogauge.payload.both_stages import Logs, Stages
from exogauge.payload.calibration import Declared, calibrate, uncalibrated
from exogauge.payload.missing.effect import Frame
from exogauge.payload.missing.search import Missing
from exogauge.payload.missing.sensor_effects import such_as_a_sensor_has
from exogauge.payload.missing.stretch import Stretch

Array = NDArray[np.float64]


def calibrated(
    logs: Logs, stages: Stages, sensor: Declared, doubt: Array, *, take: bool,
    scale: tuple[float, float] | None = None,
) -> tuple[Stages, Logs]:  # fmt: skip
    """With the doubt that the sensor's calibration adds; what is likeliest of it taken out of all logs where `take`.
    doubt: beside that. scale: by which the sensor is worse than declared, where that is known by now."""
    if sensor.exact:
        return replace(stages, calibration=uncalibrated(sensor), exact=stages), logs
    still, moving = logs.still_stretches(stages), list[Stretch]()
    if stages.excitation is not None:
        moving = [each.without(stages.excitation.left_out) for each in logs.stretches("excitation", stages)]
    inclined = stages.postures is None or stages.postures.chosen.inclined  # without postures nobody knows
    frame = Frame(stages.gravity, logs.sign, stages.body)
    found = calibrate(sensor, [*still, *moving], frame, inclined, take=take, scale=scale)
    if found.taken.any():
        logs = logs.each(found.corrected)
        stages = logs.stages(*logs.still(), doubt)
    postures, excitation, body = stages.postures, stages.excitation, stages.body
    if postures is not None:
        postures = replace(postures, chosen=postures.chosen.doubted(found.doubt(body, found.still)))
    if excitation is not None:
        more = found.doubt(body, (*found.still, *found.moving))[:16, :16]
        chosen = excitation.chosen.doubted(more, logs.criteria.payload_dynamic)
        mass, std = excitation.mass_alone
        alone = (mass, float(np.hypot(std, np.sqrt(more[0, 0]))))
        excitation = replace(excitation, chosen=chosen, mass_alone=alone)
    return replace(stages, postures=postures, excitation=excitation, calibration=found, exact=stages), logs


def in_place_of_named(
    logs: Logs, stages: Stages, sensor: Declared, missing: Missing
) -> tuple[Stages, Logs, Missing] | None:
    """With gains and crosstalk of all axes at once in place of what was named, where these are such as a sensor has and
    leave nothing above the noise; None where they do not."""
    criteria = logs.criteria
    found, clean = calibrated(logs, stages, sensor, missing.slight_doubt, take=True)
    assert found.calibration is not None
    assert found.exact is not None
    left = dict[str, Array]()
    for each in (*clean.stretches("excitation", found.exact), *clean.stretches("test", found.exact)):
        external = found.compensation.external(each.motion, each.wrench)
        left[each.name] = np.sqrt(np.mean((external / each.floor)[each.use] ** 2, axis=0))
    above = any(bool(np.any(ratios > criteria.judging.above)) for ratios in left.values())
    E = found.calibration.taken
    absurd = any(not such_as_a_sensor_has(float(E[i, k]), criteria.payload) for i, k in product(range(6), repeat=2)
                 if (i < 3) == (k < 3))  # fmt: skip
    if above or absurd or found.calibration.evidence < criteria.payload.worth:
        return None
    return found, clean, missing.with_sensor(found.calibration, left, criteria)
