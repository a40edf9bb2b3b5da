"""Whether the IMU sits as robot.yaml has it: contacts bear the robot along what the accelerometer sees."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import permutations, product
from typing import final

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from exogauge.criteria.examining import Comparing
from exogauge.identification.contacts import ContactPaths
from exogauge.logs.findings import Finding
from exogauge.plausibility.snapshot import Snapshot
from exogauge.robots.description import Robot

Array = NDArray[np.float64]

LEAST = np.radians(10.0)  # a mounting is not stated better than that by everybody, nor does a walking body obey it
CERTAIN = np.radians(1.0)  # std that no direction falls below: what bodies do relative to the base is left out


@final
@dataclass(frozen=True)
class Directions:
    """up, seen: (N, 3) unit vectors in the base frame: of the contacts' total force, of the proper acceleration.

    stood: (N, 3) up, in the axes of the foot that bears most.
    """

    up: Array
    seen: Array
    stood: Array
    criteria: Comparing

    @property
    def left_on_floor(self) -> float:
        """[rad] the same angle, were the acceleration told in axes that go with the feet and not with the base."""
        Q = _tilt(self.seen, self.stood)
        return float(np.sqrt(np.mean(np.sum((self.stood - self.seen @ Q.T) ** 2, axis=1)) + CERTAIN**2))

    def left(self, Q: Array) -> float:
        """[rad] rms angle between up and Q seen."""
        return float(np.sqrt(np.mean(np.sum((self.up - self.seen @ Q.T) ** 2, axis=1)) + CERTAIN**2))

    def gain(self, before: Array, after: Array) -> float:
        """In log likelihood, moments counted as in `AxisFit`; two components of a direction each."""
        return float(2.0 * self.criteria.independent * len(self.up) * np.log(self.left(before) / self.left(after)))


def directions(robot: Robot, seen: Snapshot) -> Directions | None:
    """None where the contacts do not bear the robot, alone and throughout most of the log.

    total contact force = sum of m_i (a_i - g), nearly m times the proper acceleration of the base.
    """
    if not robot.floating or not robot.contacts:
        return None
    paths = ContactPaths(robot)
    force = paths.effect(seen.q, seen.wrenches)[:, :3]
    bears, needs = np.linalg.norm(force, axis=1), robot.tree.mass * np.linalg.norm(seen.acc, axis=1)
    alone = np.abs(bears - needs) < seen.criteria.weighs * needs
    if np.mean(alone) < seen.criteria.most_moments:
        return None
    up, acc = force[alone] / bears[alone, None], seen.acc[alone]
    feet = np.stack([paths.of_components(seen.q, k)[alone, :3, :3] for k in range(len(robot.contacts))], axis=1)
    most = np.argmax(np.linalg.norm(seen.wrenches[alone, :, :3], axis=2), axis=1)
    stood = np.einsum("nia,na->ni", feet[np.arange(len(up)), most], up)
    return Directions(up, acc / np.linalg.norm(acc, axis=1)[:, None], stood, seen.criteria)


def told_on_floor(logs: Sequence[Directions]) -> Finding | None:
    """Of some logs together: an acceleration that is told in the world's axes does not turn where the base tilts."""
    if not logs:
        return None
    up, seen, stood = (np.concatenate([getattr(each, name) for each in logs]) for name in ("up", "seen", "stood"))
    found = Directions(up, seen, stood, logs[0].criteria)
    before, after = found.left(np.eye(3)), found.left_on_floor
    mounted = min(found.left(_tilt(found.seen, found.up)), found.left(_procrustes(found)))
    times = 2.0 * found.criteria.independent * len(found.up)
    if after > found.criteria.halved * before or times * np.log(mounted / after) < found.criteria.decisive:
        return None
    detail = (
        f"lies {np.degrees(before):.0f}° (rms) from the direction in which the contacts bear the robot, and "
        f"{np.degrees(after):.0f}° were it told in axes that stay with the floor while the base tilts"
    )
    advice = "is it told in the world's axes? Log what the accelerometer measures in its own, gravity included"
    return Finding("error", "acc", "acceleration_in_world", detail, advice, value=float(np.degrees(before)))


def imu_rules(robot: Robot, found: Directions) -> Iterator[Finding]:
    """Q turns what was measured to what the contacts say, by Procrustes; where gravity stays along one axis only the
    tilt, for the turn about it cannot be told.
    """
    assert robot.T_base_imu is not None
    as_stated, R = np.eye(3), robot.T_base_imu.rotation
    tilt, full = _tilt(found.seen, found.up), _procrustes(found)
    turn_told = found.gain(tilt, full) > found.criteria.decisive
    Q = full if turn_told else tilt
    angle, before, after = _angle(Q), found.left(as_stated), min(found.left(Q), found.left(-as_stated))
    if (
        angle < LEAST
        or after > found.criteria.halved * before
        or 2.0 * found.criteria.independent * len(found.up) * np.log(before / after) < found.criteria.decisive
    ):
        return
    lies = f"lies {np.degrees(before):.0f}° from the direction in which the contacts bear the robot"
    if found.left(-as_stated) < found.criteria.halved * before and (
        not turn_told or found.left(-as_stated) < 1.2 * found.left(Q)
    ):
        detail = f"{lies}: an accelerometer at rest measures +9.81 upwards"
        yield Finding("error", "acc", "acceleration_sign", detail, "reverse its sign in a mapping", value=-1.0)
        return
    axes = _signed_axes(found, R, Q, turn_told)
    detail = (
        f"{lies}, {np.degrees(after):.0f}° were the IMU mounted {np.degrees(angle):.0f}° from what robot.yaml states"
    )
    if not turn_told:
        detail += "; the turn about gravity these logs cannot tell"
    rpy = ", ".join(f"{each:.2f}" for each in pin.rpy.matrixToRpy(Q @ R))
    advice = f"state `imu: rpy: [{rpy}]` in robot.yaml"
    if axes is not None:
        advice = f"in a mapping, take for acc and gyro {axes}; or {advice}"
    advice += ", unless the contacts' frames are what is wrong"
    yield Finding("error", "acc", "imu_frame", detail, advice, value=float(np.degrees(angle)))


def _procrustes(found: Directions) -> Array:
    U, _, Vt = np.linalg.svd(found.up.T @ found.seen)
    proper: Array = U @ np.diag([1.0, 1.0, np.linalg.det(U @ Vt)]) @ Vt
    return proper


def _tilt(seen: Array, up: Array) -> Array:
    """The smallest rotation that takes the mean of seen to that of up."""
    a, b = (each.mean(axis=0) for each in (seen, up))
    turn: Array = pin.Quaternion.FromTwoVectors(a, b).toRotationMatrix()
    return turn


def _signed_axes(found: Directions, R: Array, Q: Array, turn_told: bool) -> str | None:
    """The exchange of axes, with signs, that mends it as well; of several the one with the smallest turn."""
    fitting = list[tuple[float, Array]]()
    for order in permutations(range(3)):
        for signs in product((1.0, -1.0), repeat=3):
            P = np.diag(signs) @ np.eye(3)[list(order)]
            if np.linalg.det(P) < 0.0:
                continue
            turned = R @ P @ R.T
            near = _angle(turned @ Q.T) if turn_told else found.left(turned) - found.left(Q)
            if near < LEAST:
                fitting.append((_angle(turned), P))
    if not fitting:
        return None
    P = min(fitting, key=lambda each: each[0])[1]
    source = [f"{'-' if row.min() < -0.5 else ''}{'xyz'[int(np.argmax(np.abs(row)))]}" for row in P]
    return ", ".join(f"{axis} := {each}" for axis, each in zip("xyz", source, strict=True))


def _angle(Q: Array) -> float:
    return float(np.arccos(np.clip(0.5 * (np.trace(Q) - 1.0), -1.0, 1.0)))
