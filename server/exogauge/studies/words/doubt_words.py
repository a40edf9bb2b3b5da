"""What a doubt is made of, and what would make that part smaller."""

from __future__ import annotations

SOURCES: dict[str, tuple[str, str]] = {
    "scatter": ("scatter of the logs", "Repeat the motion, or stretch the bands further in it."),
    "robot": (
        "the robot's parameters, as far as the logs leave them open",
        "Record excitation motions of these joints.",
    ),
    "at_rest": (
        "friction that may hold the joint at rest",
        "Move slowly through the posture, once in each direction, instead of holding it.",
    ),
    "null_test": ("what the model finds without the device", "See which effect the robot's model lacks."),
    "unexplained": ("what is left there without a name", "See which effect the robot's model lacks."),
    "ft_gain": ("gain of each force/torque sensor", "Load each sensor with a known weight, and state it as ft_gain."),
    "ft_gain_common": ("gain that all force/torque sensors share", "Weigh the robot, and state it as ft_gain_common."),
    "ft_tilt": (
        "how each force/torque sensor stands on its link",
        "Load each sensor along one axis, see what the others read, turn its frame, and state the rest as ft_tilt.",
    ),
    "ft_place": (
        "where each force/torque sensor is",
        "Measure each sensor's frame on the robot, put it into the URDF, and state the rest as ft_place.",
    ),
    "ft_zero": ("zeros of the force/torque sensors", "Take zeros with the robot hanging, before each log."),
    "kt_drift": (
        "torque per ampere, drifting from log to log",
        "Record without, with and again without the device, and say when each log began (started).",
    ),
    "viscous_drift": (
        "viscous friction, changing as drives warm",
        "Warm up before the first log, and record without, with and again without the device (started).",
    ),
    "coulomb_drift": (
        "Coulomb friction, changing as drives warm",
        "Warm up before the first log, and record without, with and again without the device (started).",
    ),
    "torque_zero": (
        "constant torques that differ from log to log",
        "Read currents with the drives off before each log, and state what is left as torque_zero.",
    ),
    "noise_colour": (
        "noise that grows towards low frequencies, where only motion is seen",
        "Log what drives and sensors read without filters of their own, and at a higher rate.",
    ),
    "imu_tilt": ("mounting of the IMU", "Level the base against a spirit level, and state it as imu_tilt."),
    "encoder_zero": (
        "zeros of the encoders",
        "Set each joint against a gauge or a level, and state what is left as encoder_zero.",
    ),
    "clock": (
        "clocks of sensors and drives",
        "Record all by one clock, or tap the robot and see how far the streams are apart, and state it as clock.",
    ),
    "via_points": ("places of the via points", "Measure via points to 2 mm, and state it as via_points."),
    "donning": ("how the device was put on", "Mark where straps end, and state what is left as donning."),
}


def doubt_sources() -> dict[str, dict[str, str]]:
    """Source -> its words and advice."""
    return {source: {"words": words, "advice": advice} for source, (words, advice) in SOURCES.items()}


def source_words(source: str) -> str:
    return SOURCES[source][0]


def source_advice(source: str) -> str:
    return SOURCES[source][1]
