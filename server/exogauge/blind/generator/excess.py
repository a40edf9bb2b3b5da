"""How much of an effect no baseline can absorb, in units of the noise that the joint's channel has anyway."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d
from scipy.signal import butter, sosfiltfilt

from exogauge.blind.generator.axis_run import AxisRun
from exogauge.blind.generator.dynamics import Kinematics, kinematics, regressor_row
from exogauge.blind.generator.motion import RATE_HZ, Motion
from exogauge.blind.generator.tree import Tree

Array = NDArray[np.float64]

BAND_HZ = 10.0  # what encoders can bear to be differentiated twice, about
_EVERY = 10  # samples: above twice the band nothing is left
STEADY_S = 0.12  # before and after it, a joint neither rests nor turns: then it is in steady motion
_RANK = 1e-9


@final
@dataclass(frozen=True)
class Baseline:
    """What a joint's own rows can absorb: its bodies' parameters all free, rotor, viscous and Coulomb friction, offset.

    kept: (L, n) bool, steady motion. Q: (N, R) orthonormal, of those samples.
    """

    kept: NDArray[np.bool_]
    Q: Array

    def excess(self, torque: Array) -> float:
        """[N·m] rms, in steady motion, of what is left of `torque` (L, T). A real baseline leaves more: it
        knows something of its parameters beforehand, and shares bodies among joints."""
        e = _low_passed(torque)[:, ::_EVERY][self.kept]
        left = e - self.Q @ (self.Q.T @ e)
        return float(np.sqrt(np.mean(left**2)))


def baselines(tree: Tree, motion: Motion, runs: list[AxisRun]) -> list[Baseline]:
    """One for every joint."""
    joints = motion.q.shape[2]
    thinned = [_low_passed(x)[:, ::_EVERY].reshape(-1, joints) for x in (motion.q, motion.dq, motion.ddq)]
    moving = kinematics(tree, thinned[0], thinned[1], thinned[2])
    return [_baseline(tree, moving, joint, run) for joint, run in enumerate(runs)]


def _baseline(tree: Tree, moving: Kinematics, joint: int, run: AxisRun) -> Baseline:
    direction = run.direction[:, ::_EVERY]
    kept = steady(run.direction)[:, ::_EVERY]
    own = [_low_passed(x)[:, ::_EVERY].ravel() for x in (run.dq, run.ddq)]
    columns = [regressor_row(tree, moving, joint), *own, direction.ravel(), np.ones(direction.size)]
    A = np.column_stack(columns)[kept.ravel()]
    sizes = np.linalg.norm(A, axis=0)
    U, s, _ = np.linalg.svd(A[:, sizes > 0.0] / sizes[sizes > 0.0], full_matrices=False)
    return Baseline(kept, U[:, s > _RANK * s[0]])


def steady(direction: Array) -> NDArray[np.bool_]:
    """(L, T) where a joint keeps moving the same way for `STEADY_S` before and after; direction: (L, T) -1, 0, 1."""
    width = 2 * round(STEADY_S * RATE_HZ) + 1
    mean = uniform_filter1d(direction, width, axis=1, mode="nearest")
    return np.abs(mean) > 1.0 - 0.5 / width


def _low_passed(values: Array) -> Array:
    """Along time, axis 1, without delay."""
    return np.asarray(sosfiltfilt(butter(2, BAND_HZ, fs=RATE_HZ, output="sos"), values, axis=1))
