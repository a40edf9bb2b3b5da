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

MOMENTS = slice(3, 6)  # of the base's rows


@final
class BaseFit:
    """Of some logs of the same bodies: M = (A + S δ) + K ζ + noise, M the moments that the contacts give, A those that
    bodies as described ask for; δ as far as inertial parameters may be off, ζ zeros of the sensors, others in each log.

    Rows are moments of all logs, x, y and z one after the other: R of them.
    """

    def __init__(self, robot: Robot, seen: Sequence[Snapshot]) -> None:
        self._robot, self._seen, self._paths = robot, seen, ContactPaths(robot)
        self._criteria = seen[0].criteria
        self.swings = spread_of(self.given(seen))
        rough, declared = self._criteria.rough * inertial_std(robot).ravel(), robot.declared
        zeros = np.repeat([declared.ft_zero_force, declared.ft_zero_moment], 3)
        blocks = []
        for place, one in enumerate(seen):
            bodies = regressor(robot.tree, one.motion)[:, MOMENTS] * rough
            of_zeros = [self._paths.of_components(one.q, k)[..., MOMENTS] for k in range(len(robot.contacts))]
            own = np.moveaxis(np.concatenate(of_zeros, axis=1), 1, 2) * np.tile(zeros, len(of_zeros))
            none = np.zeros_like(own)
            beside = [own if k == place else none for k in range(len(seen))]
            blocks.append(_rows(np.concatenate([bodies, *beside], axis=2)))
        S = np.concatenate(blocks)
        size, V = np.linalg.eigh(S.T @ S)
        self._size, self._S = np.maximum(size, 0.0), S @ V

    def given(self, seen: Sequence[Snapshot]) -> list[Array]:
        """(N, 3) of each log, by its contact sensors."""
        return [self._paths.effect(each.q, each.wrenches)[:, MOMENTS] for each in seen]

    def asked(self, seen: Sequence[Snapshot]) -> list[Array]:
        """(N, 3) of each log, by the bodies as described."""
        return [asked_of(self._robot, each.motion, each.recording)[:, MOMENTS] for each in seen]

    def left(self, seen: Sequence[Snapshot]) -> float:
        """Of how much the moments change that are given, the share that no body asks for; `seen`: as these logs, read
        otherwise."""
        r = self._missing(seen)
        least = (self._criteria.unmodelled[0] * self.swings) ** 2
        r = r - self._S @ ((self._S.T @ r) / (self._size + least))
        lengths = [3 * len(each.q) for each in seen]
        logs = np.split(r, np.cumsum(lengths)[:-1])
        return spread_of([each.reshape(3, -1).T for each in logs]) / self.swings

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
        added = zip(self._seen, seen, strict=True)
        return np.concatenate([_rows(self._paths.effect(each.q, own)[:, MOMENTS]) for each, own in added])

    def _missing(self, seen: Sequence[Snapshot]) -> Array:
        pairs = zip(self.given(seen), self.asked(seen), strict=True)
        return np.concatenate([_rows(given - asked) for given, asked in pairs])


def spread_of(logs: Sequence[Array]) -> float:
    """Rms of (N, 3) about each log's mean: where a centre of mass is not as described, a constant is left."""
    return float(np.sqrt(np.mean(np.concatenate([each - each.mean(axis=0) for each in logs]) ** 2)))


def _rows(moments: Array) -> Array:
    """(N, 3, ...) -> (3 N, ...)"""
    return np.moveaxis(moments, 0, 1).reshape(-1, *moments.shape[2:])
