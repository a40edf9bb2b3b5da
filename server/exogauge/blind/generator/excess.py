"""How much of an effect no baseline can absorb, in units of the noise that the channel has anyway."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import svd
from scipy.ndimage import uniform_filter1d
from scipy.signal import butter, sosfiltfilt

from exogauge.blind.generator.axis_run import AxisRun
from exogauge.blind.generator.cut import Cut, cut_columns
from exogauge.blind.generator.dynamics import Kinematics, Tree, kinematics, regressor_row
from exogauge.blind.generator.motion import RATE_HZ, Motion
from exogauge.blind.generator.wear import Wear

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

BAND_HZ = 10.0  # what encoders can bear to be differentiated twice, about
_EVERY = 10  # samples: above twice the band nothing is left
STEADY_S = 0.12  # before and after it, a joint neither rests nor turns: then it is in steady motion
_RANK = 1e-9


@final
@dataclass(frozen=True)
class Baseline:
    """What a joint's own rows can absorb: its bodies' parameters all free, rotor, viscous and Coulomb friction, offset,
    stiffness and natural length of bands that pull on it.

    kept: (L, n) bool, the samples that count: steady motion. Q: (N, R) orthonormal, of those samples. Q_drive: of
    rotor, friction, offset only.
    """

    kept: Mask
    Q: Array
    Q_drive: Array

    def excess(self, torque: Array, on: Mask | None = None) -> float:
        """[N·m] rms, in steady motion, of what is left of `torque` (L, T). A real baseline leaves more: it
        knows something of its parameters beforehand, and shares bodies among joints.

        on: (L, T) where to look, for what acts now and then.
        """
        return self._left(torque, self.Q, on)

    def held(self, torque: Array, on: Mask | None = None) -> float:
        """As `excess`, if bodies and bands were known to be what their makers state."""
        return self._left(torque, self.Q_drive, on)

    def _left(self, torque: Array, Q: Array, on: Mask | None) -> float:
        e = thinned(torque)[self.kept]
        left = e - Q @ (Q.T @ e)
        if on is not None:
            left = left[on[:, ::_EVERY][self.kept]]
        return float(np.sqrt(np.mean(left**2))) if left.size else 0.0


@final
@dataclass(frozen=True)
class CutBaseline:
    """What the six rows of a force/torque sensor can absorb: all parameters of what it carries, and a zero offset.

    std: (6,) noise of one sample. Q: (6 N, R) orthonormal, rows in units of it.
    """

    std: Array
    Q: Array

    def excess(self, wrench: Array, on: Mask | None = None) -> Array:
        """(6,) rms over `std` of what is left of `wrench` (L, T, 6)."""
        return self._rms((e := self._thinned(wrench)) - self.Q @ (self.Q.T @ e), on)

    def held(self, wrench: Array, on: Mask | None = None) -> Array:
        """As `excess`, if what is carried were known; the offset is not."""
        e = self._thinned(wrench).reshape(-1, 6)
        return self._rms(e - e.mean(axis=0), on)

    def _thinned(self, wrench: Array) -> Array:
        return (thinned(wrench) / self.std).ravel()

    def _rms(self, left: Array, on: Mask | None) -> Array:
        rows = left.reshape(-1, 6)
        if on is not None:
            rows = rows[on[:, ::_EVERY].ravel()]
        return np.asarray(np.sqrt(np.mean(rows**2, axis=0))) if rows.size else np.zeros(6)


def steady(direction: Array) -> Mask:
    """(L, T) where a joint keeps moving the same way for `STEADY_S` before and after; direction: (L, T) -1, 0, 1."""
    width = 2 * round(STEADY_S * RATE_HZ) + 1
    mean = uniform_filter1d(direction, width, axis=1, mode="nearest")
    return np.asarray(np.abs(mean) > 1.0 - 0.5 / width)


def moving(direction: Array) -> Mask:
    """(L, T) where a joint does not rest."""
    return np.asarray(direction != 0.0)


def baselines(
    tree: Tree,
    motion: Motion,
    runs: list[AxisRun],
    wear: Wear | None = None,
    look: Callable[[Array], Mask] = steady,
) -> list[Baseline]:
    """One for every joint; look: which samples count, by the direction of motion."""
    bodies = thinned_kinematics(tree, motion)
    bands = _band_columns(wear) if wear is not None else np.zeros((*motion.q.shape, 0))
    return [
        _baseline(regressor_row(tree, bodies, joint), run, bands[:, :, joint], look(run.direction))
        for joint, run in enumerate(runs)
    ]


def cut_baseline(tree: Tree, cut: Cut, motion: Motion, std: Array) -> CutBaseline:
    columns = cut_columns(tree, cut, thinned_kinematics(tree, motion))
    offset = np.broadcast_to(np.eye(6), (len(columns), 6, 6))
    A = (np.concatenate([columns, offset], axis=2) / std[:, None]).reshape(-1, columns.shape[2] + 6)
    return CutBaseline(std, _range_of(A))


def thinned_kinematics(tree: Tree, motion: Motion) -> Kinematics:
    q, dq, ddq = (thinned(x).reshape(-1, motion.q.shape[2]) for x in (motion.q, motion.dq, motion.ddq))
    return kinematics(tree, q, dq, ddq)


def _baseline(bodies: Array, run: AxisRun, bands: Array, look: Mask) -> Baseline:
    """bodies: (L·n, 10·B); bands: (L, T, P); look: (L, T)."""
    direction, kept = run.direction[:, ::_EVERY], look[:, ::_EVERY]
    own = [thinned(x).ravel() for x in (run.dq, run.ddq)]
    drive = np.column_stack([*own, direction.ravel(), np.ones(direction.size)])
    pulls = thinned(bands).reshape(direction.size, bands.shape[2])
    A = np.hstack([bodies, drive, pulls])
    return Baseline(kept, _range_of(A[kept.ravel()]), _range_of(drive[kept.ravel()]))


def _band_columns(wear: Wear) -> Array:
    """(L, T, J, P) of the joints' torque by each group's stiffness and each band's natural length."""
    groups = list(dict.fromkeys(band.wire.group for band in wear.bands))
    by_stiffness = [sum(b.pull(b.stretch) for b in wear.bands if b.wire.group == group) for group in groups]
    by_length = [band.pull((band.stretch > 0.0).astype(np.float64)) for band in wear.bands]
    return np.stack([wear.in_all_logs(np.asarray(column)) for column in (*by_stiffness, *by_length)], axis=3)


def _range_of(A: Array) -> Array:
    """(N, R) orthonormal. LAPACK's faster gesdd does not converge for every matrix of lower rank."""
    sizes = np.linalg.norm(A, axis=0)
    U, s, _ = svd(A[:, sizes > 0.0] / sizes[sizes > 0.0], full_matrices=False, lapack_driver="gesvd")
    return np.asarray(U[:, s > _RANK * s[0]])


def thinned(values: Array) -> Array:
    """(L, n, ...) every tenth sample of what is left below 10 Hz."""
    return low_passed(values)[:, ::_EVERY]


def low_passed(values: Array) -> Array:
    """Along time, axis 1, without delay."""
    if values.size == 0:
        return values
    return np.asarray(sosfiltfilt(butter(2, BAND_HZ, fs=RATE_HZ, output="sos"), values, axis=1))
