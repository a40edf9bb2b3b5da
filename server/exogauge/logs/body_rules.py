"""Doctor's rules on the whole body: the IMU against gravity, the feet against the weight."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from exogauge.logs.findings import ACC, GYRO, Expectation, Finding, vector
from exogauge.logs.model import Log
from exogauge.logs.units import STANDARD_GRAVITY, UNITS

Array = NDArray[np.float64]

WRENCH = ("fx", "fy", "fz", "mx", "my", "mz")
ACC_UNITS = {"g": 1.0, "cm/s²": 100.0 * STANDARD_GRAVITY, "mm/s²": 1000.0 * STANDARD_GRAVITY, "milli-g": 1000.0}


def gravity_at_rest(log: Log, expected: Expectation) -> Iterator[Finding]:
    """|acc| while the body turns least must be 9.81 m/s²."""
    acc = vector(log, ACC)
    if acc is None:
        return
    size = float(np.median(np.linalg.norm(acc[_at_rest(log, acc, expected.criteria.resting)], axis=1)))
    if abs(size / STANDARD_GRAVITY - 1.0) <= expected.criteria.gravity:
        return
    units = [unit for unit, at_rest in ACC_UNITS.items() if abs(size / at_rest - 1.0) <= expected.criteria.gravity]
    detail = f"|acc| at rest is {size:.4g}, not {STANDARD_GRAVITY:.2f} m/s²"
    if units:
        advice = f"declare the unit as {units[0]} in the mapping"
        yield Finding("error", "acc", "acceleration_unit", detail, advice, value=size)
    elif size < 0.1 * STANDARD_GRAVITY:
        advice = "gravity was taken out of it; the proper acceleration (+9.81 up at rest) is needed"
        yield Finding("error", "acc", "gravity_missing", detail, advice, value=size)
    else:
        advice = "check its unit and calibration, and that the body really rests at times"
        yield Finding("warning", "acc", "acceleration_scale", detail, advice, value=size)


def feet_carry_the_weight(log: Log, expected: Expectation) -> Iterator[Finding]:
    """Over a log that starts and ends standing, the mean of the total Fz is m g."""
    sensors = tuple(expected.contacts)
    names = [f"ft.{name}.fz" for name in sensors]
    if expected.weight_n is None or not sensors or not log.has(*names):
        return
    upward = log.stack(names)
    upward = upward[np.isfinite(upward).all(axis=1)]
    if not upward.size:
        return
    signs = np.array([expected.contacts[name] for name in sensors])
    lifts = signs * upward.mean(axis=0) / expected.weight_n
    ratio = float(lifts.sum())
    if abs(ratio - 1.0) <= expected.criteria.weight:
        return
    detail = f"the feet carry {ratio:.3g} of the weight of {expected.weight_n:.4g} N"
    units = {name: unit.factor for name, unit in UNITS.items() if unit.dimension == "force" and unit.factor != 1.0}
    unit = next((name for name, size in units.items() if abs(ratio * size - 1.0) <= expected.criteria.weight), None)
    if abs(ratio + 1.0) <= expected.criteria.weight_sign:
        advice = "the wrenches are those of the robot on the world: change `sees` in robot.yaml, or the sign"
        yield Finding("error", "ft.*", "wrench_sign", detail, advice, value=ratio)
    elif abs(float(np.abs(lifts).sum()) - 1.0) <= expected.criteria.weight:
        turned = ", ".join(name for name, lift in zip(sensors, lifts, strict=True) if lift < 0.0)
        yield Finding("error", "ft.*", "wrench_sign", detail, f"only {turned} has its sign reversed", value=ratio)
    elif unit:
        yield Finding("error", "ft.*", "force_unit", detail, f"declare the unit as {unit} in the mapping", value=ratio)
    else:
        yield from _weight_elsewhere(log, expected, sensors, signs, detail, ratio)


def _weight_elsewhere(
    log: Log, expected: Expectation, sensors: Sequence[str], signs: Array, detail: str, ratio: float
) -> Iterator[Finding]:
    """The weight found in another column: couple before force, or another axis up."""
    assert expected.weight_n is not None
    for axis in WRENCH:
        names = [f"ft.{name}.{axis}" for name in sensors]
        if axis == "fz" or not log.has(*names) or not np.isfinite(log.stack(names)).all():
            continue
        share = float(signs @ log.stack(names).mean(axis=0)) / expected.weight_n
        if abs(abs(share) - 1.0) > expected.criteria.weight_sign:
            continue
        if axis.startswith("m"):
            advice = f"the weight is in {axis}: the columns hold the couple first, declare that order in the mapping"
            yield Finding("error", "ft.*", "couple_first", detail, advice, value=ratio)
        else:
            advice = f"the weight is in {axis}: right if that axis of the sensors is upright"
            yield Finding("warning", "ft.*", "weight_on_another_axis", detail, advice, value=ratio)
        return
    if abs(ratio) <= expected.criteria.weight_sign:
        advice = (
            "were zeros taken while the robot stood on its feet? Take them with the feet in the air, and add here what "
            "was taken off (`offset`). What hangs from a crane is borne by what no sensor tells of"
        )
        yield Finding("error", "ft.*", "weight_missing", detail, advice, value=ratio)
        return
    advice = "does the robot lean on something else, or is the force scale, the zero or the mass of the URDF wrong?"
    yield Finding("warning", "ft.*", "weight_differs", detail, advice, value=ratio)


def _at_rest(log: Log, acc: Array, resting: float) -> NDArray[np.bool_]:
    """(T,) the samples with the least rotation; without a gyro, those with the least change of acceleration."""
    gyro = vector(log, GYRO)
    activity = np.linalg.norm(np.gradient(acc, axis=0) if gyro is None else gyro - np.median(gyro, axis=0), axis=1)
    return np.asarray(activity <= np.quantile(activity, resting))
