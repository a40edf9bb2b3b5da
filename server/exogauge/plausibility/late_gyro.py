"""Whether the gyro is late, or early, against the legs: of a foot that stands the leg tells how the base turns."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.identification.contacts import ContactPaths
from exogauge.plausibility.base_moments import Late
from exogauge.plausibility.snapshot import Snapshot
from exogauge.plausibility.summit import summit
from exogauge.robots.description import Robot

Array = NDArray[np.float64]


def late_gyro(robot: Robot, seen: Snapshot) -> Late | None:
    """None where no shift leaves half of what differs, or feet that bear the robot turn as much as its base does."""
    if not robot.tree.floating or not robot.contacts:
        return None
    criteria, legs = seen.criteria, _Legs(robot, seen)
    if legs.swings <= 0.0:
        return None
    left = np.array([legs.left(gyro) for gyro in seen.late_imu[:, 1]])
    best, at_once = int(np.argmin(left)), int(np.argmin(np.abs(seen.lags)))
    if best in (0, len(left) - 1) or left[best] > min(criteria.delay_far_falls * left[at_once], criteria.halved):
        return None
    seconds = summit(seen.lags[best - 1 : best + 2], -(left[best - 1 : best + 2] ** 2))
    if abs(seconds) < max(criteria.delay_least_s, criteria.delay_samples / seen.rate_hz):
        return None
    return Late(seconds, float(left[at_once]), float(left[best]), best, of_imu=True, by_legs=True)


def alike(found: Sequence[Late | None], seen: Sequence[Snapshot]) -> bool:
    """Whether all logs have one delay, which the effect `imu_delay` can name, first order in it as it is."""
    if not seen or any(each is None for each in found):
        return False
    criteria, seconds = seen[0].criteria, [each.seconds for each in found if each is not None]
    return float(np.ptp(seconds)) < criteria.delay_least_s and float(np.abs(seconds).max()) < criteria.imu_delay_least_s


@final
class _Legs:
    """turns: (N, 3) of each contact sensor, the base's angular velocity in its own frame, were the sensor at rest.
    bears: (N,) of each, that it bears the robot. swings: rms of `turns` about each one's mean."""

    def __init__(self, robot: Robot, seen: Snapshot) -> None:
        paths = ContactPaths(robot)
        force = np.linalg.norm(seen.wrenches[..., :3], axis=2)
        self.bears = (force > seen.criteria.bears * force.sum(axis=1)[:, None]).T
        self.turns = [_turning(paths, seen, sensor) for sensor in range(len(robot.contacts))]
        self.swings = self.left(np.zeros_like(seen.gyro), share=False)

    def left(self, gyro: Array, share: bool = True) -> float:
        """Rms about each sensor's mean of what differs, of (N, 3) [rad/s], as a share of the swings."""
        pairs = zip(self.turns, self.bears, strict=True)
        apart = [gyro[standing] - turns[standing] for turns, standing in pairs if standing.any()]
        if not apart:
            return 0.0
        square = np.mean(np.concatenate([each - each.mean(axis=0) for each in apart]) ** 2)
        return float(np.sqrt(square)) / (self.swings if share else 1.0)


def _turning(paths: ContactPaths, seen: Snapshot, sensor: int) -> Array:
    """(N, 3) [rad/s]: with R from the sensor's axes to the base's, dR/dt Rᵀ is how it turns beside the base."""
    step = 1e-4  # [s]: joints turn by less than a milliradian, and rounding is 1e-12 of it
    before, after = (paths.of_components(seen.q + sign * step * seen.dq, sensor)[:, :3, :3] for sign in (-1.0, 1.0))
    rate = np.swapaxes(after - before, 1, 2) / (2.0 * step)
    S = rate @ paths.of_components(seen.q, sensor)[:, :3, :3]
    return -0.5 * np.stack([S[:, 2, 1] - S[:, 1, 2], S[:, 0, 2] - S[:, 2, 0], S[:, 1, 0] - S[:, 0, 1]], axis=1)
