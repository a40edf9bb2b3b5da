"""What moments about the base leave of themselves, were every body off by as much as is stated, and no more."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.identification.contacts import ContactPaths
from exogauge.identification.prior import inertial_std
from exogauge.plausibility.described import asked_of
from exogauge.plausibility.snapshot import Snapshot
from exogauge.robots.description import Robot
from exogauge.robots.regressor import regressor

Array = NDArray[np.float64]

BASE, FORCES, MOMENTS = slice(6), slice(3), slice(3, 6)  # the base's rows


@final
class BaseFit:
    """Of some logs of the same bodies: M = (A + S δ) + K ζ + noise, M the moments that the contacts give, A those that
    bodies as described ask for; δ as far as inertial parameters may be off, ζ zeros of the sensors, others in each log.

    Rows are moments of all logs, x, y and z one after the other: R of them. about_contacts: not about the base's
    origin, but the middle of the contacts. A moment about the base holds the noise of forces times how far off they
    act, and so does one about another point of a foot: what is noise would say where a foot measures. Forces are rows
    beside them then, as about the contacts a body's weight is a moment too; [N] times the length by which they change
    as much as the moments.
    """

    def __init__(self, robot: Robot, seen: Sequence[Snapshot], about_contacts: bool = False) -> None:
        self._robot, self._seen, self._paths = robot, seen, ContactPaths(robot)
        self._criteria = seen[0].criteria
        given = [self._paths.effect(each.q, each.wrenches) for each in seen]
        self.swings, forces = (spread_of([each[:, some] for each in given]) for some in (MOMENTS, FORCES))
        self._middle = [self._middle_of_contacts(each.q) for each in seen] if about_contacts else None
        self._length = self.swings / max(forces, 1e-300)
        rough, declared = self._criteria.rough * inertial_std(robot).ravel(), robot.declared
        zeros = np.repeat([declared.ft_zero_force, declared.ft_zero_moment], 3)
        blocks = []
        for place, one in enumerate(seen):
            bodies = self._told(regressor(robot.tree, one.motion)[:, BASE], place) * rough
            of_zeros = [self._paths.of_components(one.q, k)[..., BASE] for k in range(len(robot.contacts))]
            of_zero = np.moveaxis(np.concatenate(of_zeros, axis=1), 1, 2)
            own = self._told(of_zero, place) * np.tile(zeros, len(of_zeros))
            none = np.zeros_like(own)
            beside = [own if k == place else none for k in range(len(seen))]
            blocks.append(_rows(np.concatenate([bodies, *beside], axis=2)))
        S = np.concatenate(blocks)
        size, V = np.linalg.eigh(S.T @ S)
        self._size, self._S = np.maximum(size, 0.0), S @ V

    def given(self, seen: Sequence[Snapshot]) -> list[Array]:
        """(N, 3 or 6) of each log, by its contact sensors."""
        effects = (self._paths.effect(each.q, each.wrenches)[:, BASE] for each in seen)
        return [self._told(each, place) for place, each in enumerate(effects)]

    def asked(self, seen: Sequence[Snapshot]) -> list[Array]:
        """(N, 3 or 6) of each log, by the bodies as described."""
        asked = (asked_of(self._robot, each.motion, each.recording)[:, BASE] for each in seen)
        return [self._told(each, place) for place, each in enumerate(asked)]

    def left(self, seen: Sequence[Snapshot]) -> float:
        """Of how much the moments change that are given, the share that no body asks for; `seen`: as these logs, read
        otherwise."""
        r = self._missing(seen)
        least = (self._criteria.unmodelled[0] * self.swings) ** 2
        r = r - self._S @ ((self._S.T @ r) / (self._size + least))
        rows = 3 if self._middle is None else 6
        logs = np.split(r, np.cumsum([rows * len(each.q) for each in seen])[:-1])
        return spread_of([each.reshape(rows, -1).T for each in logs]) / self.swings

    def likelihood(self, columns: Array, tried: Array) -> tuple[Array, float]:
        """(K,) log likelihoods, were `columns` @ tried[k] added to what the contacts give; and the highest of any.

        columns: (R, X). tried: (K, X). Neighbouring moments say the same: of each a share counts.
        """
        r, D = self._missing(self._seen), columns
        u, E = self._S.T @ r, self._S.T @ D
        found, most = np.full(len(tried), -np.inf), -np.inf
        for share in self._criteria.unmodelled:
            noise = (share * self.swings) ** 2 / self._criteria.independent
            w = 1.0 / (self._size + noise)
            H, b = (D.T @ D - (E.T * w) @ E) / noise, -(D.T @ r - E.T @ (w * u)) / noise
            as_it_is = -0.5 * (
                (r @ r - u @ (w * u)) / noise
                + self._criteria.independent * len(r) * np.log(noise)
                + np.sum(np.log1p(self._size / noise))
            )
            found = np.maximum(found, as_it_is + tried @ b - 0.5 * np.einsum("ki,ij,kj->k", tried, H, tried))
            most = max(most, as_it_is + 0.5 * float(b @ np.linalg.lstsq(H, b)[0]))
        return found, most

    def of_wrenches(self, seen: Sequence[Array]) -> Array:
        """(R,) what (N, S, 6) wrenches of each log, in their sensors' frames, add to the moments."""
        added = (self._paths.effect(each.q, own)[:, BASE] for each, own in zip(self._seen, seen, strict=True))
        return np.concatenate([_rows(self._told(each, place)) for place, each in enumerate(added)])

    def _told(self, wrench: Array, log: int) -> Array:
        """(N, 3 or 6, ...) rows of (N, 6, ...) wrenches at the base's origin."""
        if self._middle is None:
            return np.asarray(wrench[:, MOMENTS])
        force, r = wrench[:, FORCES], self._middle[log].reshape(-1, 3, *[1] * (wrench.ndim - 2))
        return np.concatenate([wrench[:, MOMENTS] - np.cross(r, force, axis=1), self._length * force], axis=1)

    def _middle_of_contacts(self, q: Array) -> Array:
        """(N, 3) [m] in the base's frame: of unit forces e at p, Σ e × (p × e) = 2 p."""
        found = np.zeros((len(q), 3))
        for contact in range(len(self._robot.contacts)):
            unit = self._paths.of_components(q, contact)[:, :3, BASE]
            found += 0.5 * np.cross(unit[..., :3], unit[..., 3:]).sum(axis=1) / len(self._robot.contacts)
        return found

    def _missing(self, seen: Sequence[Snapshot]) -> Array:
        pairs = zip(self.given(seen), self.asked(seen), strict=True)
        return np.concatenate([_rows(given - asked) for given, asked in pairs])


def spread_of(logs: Sequence[Array]) -> float:
    """Rms of (N, 3) about each log's mean: where a centre of mass is not as described, a constant is left."""
    return float(np.sqrt(np.mean(np.concatenate([each - each.mean(axis=0) for each in logs]) ** 2)))


def _rows(moments: Array) -> Array:
    """(N, 3 or 6, ...) -> (3 N or 6 N, ...)"""
    return np.moveaxis(moments, 0, 1).reshape(-1, *moments.shape[2:])
