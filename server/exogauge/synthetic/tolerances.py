"""What a laboratory declares of a sample's disturbances: standard uncertainties, in robot.yaml and in the device files.

One table. What has no key there yet stands in truth.json alone, so that a score knows what could have been declared.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, final

from exogauge.synthetic.disturbances import Disturbances
from exogauge.synthetic.lab import COMMON, COULOMB_WARMS, MOMENT_ARM, OWN, PRELOAD

File = Literal["robot", "device"]


@final
@dataclass(frozen=True)
class Tolerance:
    """std: of `what`, per size of the disturbance. key: below `uncertainty` of robot.yaml or device.yaml, or ""."""

    disturbance: str
    file: File
    key: str
    what: str
    std: float


_HALF_TO_WHOLE = math.sqrt(7 / 12)  # rms of an even spread over 0.5 to 1
_HALF_MORE = math.sqrt(13 / 12)  # rms of an even spread over 0.5 to 1.5
TOLERANCES = (
    Tolerance("foot_gains", "robot", "ft_gain_common", "gain that the feet have in common", COMMON),
    Tolerance("feet_gain", "robot", "ft_gain_common", "gain that the feet have in common", 1.0),
    Tolerance("foot_gains", "robot", "ft_gain", "gain of each foot alone", OWN),
    Tolerance("feet_drift", "robot", "ft_zero_force", "zero of a force, by the session's end [N]", _HALF_TO_WHOLE),
    Tolerance(
        "feet_drift", "robot", "ft_zero_moment", "zero of a moment, the same [N·m]", MOMENT_ARM * _HALF_TO_WHOLE
    ),
    Tolerance("feet_tilt", "robot", "ft_tilt", "tilt of a foot sensor about each axis [rad]", 1.0),
    Tolerance("feet_place", "robot", "ft_place", "place of a foot sensor along each axis [m]", 1.0),
    Tolerance("encoder_zeros", "robot", "encoder_zero", "zero of each encoder [rad]", 1.0),
    Tolerance("streams_late", "robot", "clock", "delay of each foot sensor and of the IMU [s]", 1.0),
    Tolerance("imu_mounting", "robot", "imu_tilt", "tilt about each horizontal axis [rad]", math.sqrt(0.5)),
    Tolerance("kt_warming", "robot", "kt_drift", "change of k_T over the session", _HALF_MORE),
    Tolerance("friction_warming", "robot", "viscous_drift", "change of k_d over the session", _HALF_MORE),
    Tolerance(
        "friction_warming", "robot", "coulomb_drift", "change of tau_c over the session", COULOMB_WARMS * _HALF_MORE
    ),
    Tolerance("clock_jitter", "robot", "", "of a time stamp [s]", 1.0),
    Tolerance("via_points", "device", "via_points", "each coordinate of a via point [m]", 1.0),
    Tolerance("donning", "device", "donning", "a band's length from one log to the next, its ends' with it [m]",
              math.sqrt(PRELOAD**2 + 2.0)),
)  # fmt: skip


def uncertainty(file: File, sizes: Disturbances) -> Mapping[str, float | str] | Literal["none"]:
    """What that file says under `uncertainty`: every key it knows, 0 where nothing of the kind happens; when zeros were
    taken."""
    if not sizes:
        return "none"
    squares: dict[str, float] = {}
    for each in TOLERANCES:
        if each.file == file and each.key:
            squares[each.key] = squares.get(each.key, 0.0) + (each.std * sizes.get(each.disturbance, 0.0)) ** 2
    stated: dict[str, float | str] = {key: float(f"{math.sqrt(square):.2g}") for key, square in squares.items()}
    return stated | ({"zeros_taken": "session"} if file == "robot" and "feet_drift" in sizes else {})


def declared(sizes: Disturbances) -> list[dict[str, Any]]:
    """file, key, what, std (SI) of every tolerance that belongs to what happens in a sample."""
    return [
        {"file": each.file, "key": each.key, "what": each.what, "std": abs(each.std * sizes[each.disturbance])}
        for each in TOLERANCES
        if each.disturbance in sizes
    ]
