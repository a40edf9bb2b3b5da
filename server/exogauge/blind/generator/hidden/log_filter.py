"""Logs whose signals were low-passed before they were stored."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar, Self, final

import numpy as np
from scipy.signal import bessel, butter, sosfilt, sosfilt_zi, sosfiltfilt

from exogauge.blind.generator.dynamics import joint_torques
from exogauge.blind.generator.excess import baselines, moving
from exogauge.blind.generator.hidden.effect import Array
from exogauge.blind.generator.motion import RATE_HZ, Motion
from exogauge.blind.generator.scene import Scene

ALL = "all"
_LONGEST_S = 20.0  # of an answer to an impulse
_CREEP = 1e-3  # [rad/s] below which what is left of a rest counts as one


@final
@dataclass(frozen=True)
class BandLimitedLog:
    """Every signal alike, stored at the full rate; size: 1 / cut-off [s]. log: index, None for all.

    order, kind: of the filter; there_and_back: without delay, as a program does it afterwards.
    """

    log: int | None
    order: int
    kind: str
    there_and_back: bool

    name: ClassVar[str] = "band_limited_log"

    @classmethod
    def draw(cls, rng: np.random.Generator, scene: Scene) -> Self:
        log = None if rng.uniform() < 0.6 else int(rng.choice(scene.plain))
        kind = str(rng.choice(["butter", "bessel"]))
        return cls(log, int(rng.integers(1, 4)), kind, bool(rng.uniform() < 0.4))

    def limits(self) -> tuple[float, float]:
        return 1.0 / 5.0, 1.0 / 2.0

    def hits(self, log: int) -> bool:
        return self.log is None or self.log == log

    def filtered(self, values: Array, size: float, axis: int = 0) -> Array:
        """Along time; before a log began nothing moved."""
        design = butter if self.kind == "butter" else bessel
        sos = design(self.order, 1.0 / size, fs=RATE_HZ, output="sos")
        rows = np.moveaxis(values, axis, -1)
        if self.there_and_back:
            out = sosfiltfilt(sos, rows, axis=-1)
        else:
            zi = sosfilt_zi(sos)
            start = zi.reshape(len(zi), *([1] * (rows.ndim - 1)), 2) * rows[..., 0][None, ..., None]
            out, _ = sosfilt(sos, rows, axis=-1, zi=start)
        return np.asarray(np.moveaxis(out, -1, axis))

    def noise_left(self, size: float) -> float:
        """Of the std of white noise."""
        one = np.zeros(round(_LONGEST_S * RATE_HZ))
        one[len(one) // 2] = 1.0
        return float(np.linalg.norm(self.filtered(one, size)))

    def excess(self, scene: Scene, size: float) -> tuple[Array, Array]:
        """(J,) [N·m] of what a baseline leaves that believes the filtered motion, turns
        included, and that over each joint's noise."""
        logs = [n for n in scene.plain if self.hits(n)]
        q, dq, ddq = (self.filtered(x[logs], size, axis=1) for x in (scene.motion.q, scene.motion.dq, scene.motion.ddq))
        shape = q.shape
        loads = joint_torques(scene.robot.tree, scene.robot.phi, *(x.reshape(-1, shape[2]) for x in (q, dq, ddq)))
        runs, left = [], []
        for j, run in enumerate(scene.runs):
            direction = np.where(np.abs(dq[:, :, j]) < _CREEP, 0.0, np.sign(dq[:, :, j]))
            runs.append(replace(run, q=q[:, :, j], dq=dq[:, :, j], ddq=ddq[:, :, j], direction=direction))
            d, load = run.drive, loads[:, j].reshape(shape[:2])
            model = load + d.J_r * ddq[:, :, j] + d.k_d * dq[:, :, j] + d.tau_c * direction - d.tau_o
            left.append(self.filtered(run.motor[logs], size, axis=1) - model)
        absorbing = baselines(scene.robot.tree, Motion(scene.motion.time, q, dq, ddq), runs, look=moving)
        excess = np.array([each.excess(torque) for each, torque in zip(absorbing, left, strict=True)])
        return excess, excess / np.array(scene.floors)
