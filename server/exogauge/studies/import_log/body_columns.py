"""Columns of the IMU and of force/torque sensors: a component, told by the axis in its name, and its unit."""

from __future__ import annotations

from collections.abc import Mapping

from exogauge.logs.channels import parse_channel
from exogauge.logs.units import STANDARD_GRAVITY, dimensions_of, find_unit
from exogauge.studies.import_log.column_facts import OTHER, SI, UNKNOWN, Advice, Seen, Suggestion, Wearer, too_large
from exogauge.studies.import_log.column_words import FILLERS, KIND_OF, Words, axis_in, tokens_of, within

GRAVITY = {"m/s^2": STANDARD_GRAVITY, "g": 1.0, "mg": 1000.0, "mm/s^2": 1000.0 * STANDARD_GRAVITY}  # in each unit
NEAR = 0.1  # relative
FORCES = {"force": "f", "forces": "f", "torque": "m", "torques": "m", "moment": "m"}


def body_column(
    column: Seen, words: Words, kinds: tuple[str, ...], wearer: Wearer, norms: Mapping[str, float]
) -> Suggestion | Advice | None:
    """IMU and force/torque sensors: a component told by its axis. None where the name has no axis."""
    axis = axis_in(words.tokens)
    if axis is None:
        return None
    kind = axis[0]
    if not kind:
        forces = {"force": "f", "forces": "f", "torque": "m", "torques": "m", "moment": "m"}
        kind = next((forces[token] for token in words.tokens if token in forces), "")
        kind = kind or next((each for each in kinds if each in ("acc", "gyro")), "")
    if kind in ("acc", "gyro"):
        return _imu(column, kind, axis[1], words, norms)
    if kind not in ("f", "m"):
        return None
    sensor = _sensor_in(words, wearer)
    if sensor is None:
        known = ", ".join(wearer.sensors) or "the robot has none, or no robot is given"
        return Advice(f"A component of a wrench, but of which sensor? ({known}) {UNKNOWN}")
    unit = words.unit or (OTHER[kind] if kind in OTHER and too_large(column, kind) else SI[kind])
    channel = parse_channel(f"ft.{sensor}.{kind}{axis[1]}")
    found = find_unit(unit)
    if found is None or found.dimension not in dimensions_of(channel):
        return Advice(f"Its name says {unit}, which is no unit of a {'force' if kind == 'f' else 'moment'}. {UNKNOWN}")
    rests = "" if words.unit else f"; the unit is not named: {unit} is usual"
    return Suggestion(channel.name, unit, sure=words.unit is not None, why=f"the {channel.axis} of {sensor}{rests}")


def _imu(column: Seen, kind: str, axis: str, words: Words, norms: Mapping[str, float]) -> Suggestion | Advice:
    channel = parse_channel(f"{kind}.{axis}")
    if words.unit is not None:
        unit = find_unit(words.unit)
        if unit is None or unit.dimension not in dimensions_of(channel):
            return Advice(f"Its name says {words.unit}, which is no unit of {channel.kind}. {UNKNOWN}")
        return Suggestion(channel.name, words.unit, sure=True, why=f"the name says {kind} along {axis}")
    size = norms.get(column.name)
    if kind == "acc" and size is not None:
        for unit_name, gravity in GRAVITY.items():
            if abs(size / gravity - 1.0) < NEAR:
                return Suggestion(
                    channel.name, unit_name, sure=True, why=f"its usual size is {size:.4g}: gravity in {unit_name}"
                )
        return Advice(
            f"Its usual size, {size:.4g}, is gravity in no unit. Give its unit, and check that gravity is in it."
        )
    unit_name = OTHER[kind] if kind in OTHER and too_large(column, kind) else SI[kind]
    return Suggestion(channel.name, unit_name, why=f"the unit is not named: {unit_name} is usual")


def _sensor_in(words: Words, wearer: Wearer) -> str | None:
    for sensor in sorted(wearer.sensors, key=len, reverse=True):
        if within(tokens_of(sensor), words.tokens) is not None:
            return sensor
    if wearer.joints is not None:
        return None
    rest = [token for token in words.tokens if token not in FILLERS | set(KIND_OF) and axis_in((token,)) is None]
    return "_".join(rest) or None
