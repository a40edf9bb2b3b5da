"""From what is to what is logged: quantisation, white noise, and what a laboratory's sensors have wrong beside it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

Array = NDArray[np.float64]

ENCODER_STEP = 2 * math.pi / (2**17 * 100)  # a 17-bit motor encoder behind a gear of 100 [rad]
COMMAND_STEP = 0.002  # of the current that the controller asks for [A]
# q: the encoder's error (1.4e-7), and how steps of the commanded current and of friction shake the joints faster than
# any plan moves them; root mean square over the joints, the light fingers shake most. The rest is noise of sensors.
NOISE = {"q": 2.6e-7, "i": 0.02, "acc": 0.03, "gyro": 0.003, "force": 0.5, "moment": 0.04}
_STEP = {"i": 0.005, "acc": 0.002, "gyro": 0.0002, "force": 0.05, "moment": 0.002}  # of the converters
_MOST_JITTER = 4.0  # standard deviations


@final
@dataclass(frozen=True)
class Sensing:
    """One log's sensors. encoder_step [rad]; gain: (2,) of the feet; zero: (2, 6) [N, N·m] when the log begins,
    drift: (2, 6) of it per second; tilt: (2, 3), imu: (3,) [rad] rotation vectors, read = R true; place: (2, 3) [m] of
    the feet's sensors, beside their frames; late: (3,) [s] by which they, and the IMU, are told later; encoder_zero:
    (J,) [rad]; jitter [s] of a stamp, drawn by rng.
    """

    encoder_step: float
    encoder_zero: Array
    gain: Array
    zero: Array
    drift: Array
    tilt: Array
    imu: Array
    place: Array
    late: Array
    jitter: float
    rng: np.random.Generator

    def wrench(self, true: Array, time: Array) -> Array:
        """(T, 2, 6) read by the feet, from the true one; time: (T,) [s] from the log's beginning."""
        read = list[Array]()
        for foot, (R, place, late) in enumerate(zip(self._tilts(), self.place, self.late[:-1], strict=True)):
            told = _later(true[:, foot], time, late)
            force, moment = told[:, :3], told[:, 3:] - np.cross(place, told[:, :3])
            read.append(np.concatenate([force @ R.T, moment @ R.T], axis=1))
        return np.asarray(self.gain[:, None] * np.stack(read, axis=1) + self.zero + time[:, None, None] * self.drift)

    def inertial(self, true: Array, time: Array) -> Array:
        """(T, 3) read by the IMU; time as above."""
        return np.asarray(_later(true, time, self.late[-1]) @ rotation(self.imu).T)

    def angles(self, true: Array) -> Array:
        """(T, J) counted by the encoders."""
        return encoder(true + self.encoder_zero, self.encoder_step)

    def stamps(self, time: Array) -> Array:
        """(T,) [s] what the log says of when its samples were taken."""
        error = np.clip(self.rng.standard_normal(len(time)), -_MOST_JITTER, _MOST_JITTER)
        return np.asarray(time + self.jitter * error)

    def _tilts(self) -> list[Array]:
        return [rotation(vector) for vector in self.tilt]


def _later(values: Array, time: Array, late: float) -> Array:
    """(T, K) what was so much earlier; before the log's beginning as at it."""
    if late == 0.0:
        return values
    return np.asarray(CubicSpline(time, values)(np.clip(time - late, time[0], time[-1])))


def encoder(angle: Array, step: float = ENCODER_STEP) -> Array:
    """Joint angle as counted [rad]; its error is even over one step: std step / sqrt 12, 1.4e-7 for the default."""
    return np.asarray(np.round(angle / step) * step)


def position_noise(step: float) -> float:
    """What robot.yaml says of q [rad]: the encoder's error, and `NOISE` where that is more."""
    return max(NOISE["q"], float(f"{step / math.sqrt(12.0):.2g}"))


def noisy(values: Array, kind: str, rng: np.random.Generator) -> Array:
    """White noise of the kind's std, then the converter's steps."""
    return np.asarray(np.round((values + NOISE[kind] * rng.standard_normal(values.shape)) / _STEP[kind]) * _STEP[kind])


def rotation(vector: Array) -> Array:
    """(3, 3) by the angle |vector| about it [Rodrigues]."""
    angle = float(np.linalg.norm(vector))
    if angle == 0.0:
        return np.eye(3)
    x, y, z = vector / angle
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + math.sin(angle) * K + (1.0 - math.cos(angle)) * K @ K)
