"""What the comparison of logs with and without a device says, joint by joint."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from typing import Literal, final

import numpy as np
from numpy.typing import NDArray

from exogauge.devices.result import Estimate
from exogauge.identification.result import Prediction
from exogauge.remarks import Remark

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.intp]
Verdict = Literal["equal", "doubtful", "different"]


@final
@dataclass(frozen=True)
class JointEquality:
    """How equal a joint's motion is in two logs, after alignment.

    q_rms [rad], dq_rms [rad/s]: of the difference. dq_share: dq_rms over the joint's own rms velocity (0 where it
    hardly moves). verdict: by the limits of the settings.
    """

    joint: str
    q_rms: float
    dq_rms: float
    dq_share: float
    verdict: Verdict


@final
@dataclass(frozen=True)
class Trial:
    """One log with the device; T samples on its own times, D joints on which the bands act.

    reference: the log without the device that it was compared with, None where there is none; lag_s: how much
    later the same motion comes in it [s].
    q: (T, D) [rad]. All torques (T, D) [N·m] on the joint, positive along it, low-passed; those of A and of the
    paired estimate are None without a reference. Where friction holds a joint the data give an interval only: low_…,
    high_… (T, D), one number elsewhere. There b, paired and prior are the value in it nearest to the line between the
    motions before and after (a passive device pulls alike while nothing moves), or its middle where the joint never
    moves; a is its middle.
    *_std: one standard deviation, of parameters, noise and coloured residuals together.
    band_model: what the device file's bands give (or identified ones, see SupportResult), None if no values are known.
    compared: A's samples in which both runs move the same way; steady: this run moves steadily, where the
    low-pass has settled; rest: it stands still.
    phase: (T,) index into phase_names. length [m], tension [N]: by band.
    prediction: measured channels of this log, and what the robot's model says without the device.
    """

    log: str
    device: str
    motion: str
    reference: str | None
    lag_s: float
    time: Array
    joints: tuple[str, ...]
    q: Array
    support_a: Array | None
    support_a_std: Array | None
    support_b: Array
    support_b_std: Array
    support_prior: Array
    band_model: Array | None
    low_a: Array | None
    high_a: Array | None
    low_b: Array
    high_b: Array
    compared: BoolArray
    steady: BoolArray
    rest: BoolArray
    equality: tuple[JointEquality, ...]
    phase: IntArray
    phase_names: tuple[str, ...]
    length: Mapping[str, Array]
    tension: Mapping[str, Array]
    prediction: Prediction
    support_paired: Array | None = None
    support_paired_std: Array | None = None
    low_paired: Array | None = None
    high_paired: Array | None = None


@final
@dataclass(frozen=True)
class Effort:
    """peak: [N·m] mean over 0.2 s where it is largest in the other trials, with its sign; mean [N·m]; integral
    [N·m·s]."""

    peak: Estimate
    mean: Estimate
    integral: Estimate

    def with_nothing_decided(self) -> Effort:
        """The same, of which the data say nothing."""
        peak, mean, integral = (replace(each, std=math.inf, parts={}) for each in (self.peak, self.mean, self.integral))
        return Effort(peak, mean, integral)


@final
@dataclass(frozen=True)
class Best:
    """approach: `a`, `b` or `paired`. as_good: those whose null test does not differ from the best one's by more than
    chance, among which the smallest doubt decides; the approach itself is among them."""

    approach: str
    as_good: tuple[str, ...]


@final
@dataclass(frozen=True)
class PhaseEffort:
    """phase: lowering, holding, raising or standing. duration_s: mean over the trials. by: approach -> effort. best:
    of which the headline is."""

    phase: str
    duration_s: float
    by: Mapping[str, Effort]
    best: Best | None = None


@final
@dataclass(frozen=True)
class JointSupport:
    """One joint in one motion with one device, over all trials. Approaches: `a`, `b`, `paired`, `prior`, `band_model`.

    rmse: approach -> RMSE [N·m] against the band model, all samples; rmse_steady: where both runs move steadily.
    by: approach -> effort over the whole motion, mean over the trials, std with their spread in it; spread: approach
    -> standard deviation of the mean supporting torque between trials [N·m].
    best: of which approach the headline is. null: approach -> RMS [N·m] of what it gives on logs without the device.
    masked_share: of A's samples left out because the runs' friction differs; rest_share: of samples at rest.
    rest_half_width: [N·m] half of the interval at rest by B.
    slides: the joint does, so that what is in N·m is in N, and what is in rad in m.
    decided: by the data; if not, there is no headline, and no approach's number has an end to its doubt.
    """

    device: str
    motion: str
    joint: str
    logs: tuple[str, ...]
    references: tuple[str, ...]
    rmse: Mapping[str, float]
    rmse_steady: Mapping[str, float]
    by: Mapping[str, Effort]
    spread: Mapping[str, float]
    phases: tuple[PhaseEffort, ...]
    null: Mapping[str, float]
    equality: tuple[JointEquality, ...]
    lag_s: tuple[float, ...]
    masked_share: float
    rest_share: float
    rest_half_width: float
    slides: bool = False
    best: Best | None = None
    decided: bool = True

    def with_nothing_decided(self) -> JointSupport:
        """The same, where no number counts as decided by the data. What the device file's bands give is no estimate."""

        def undecided(by: Mapping[str, Effort]) -> dict[str, Effort]:
            return {name: each if name == "band_model" else each.with_nothing_decided() for name, each in by.items()}

        phases = tuple(replace(each, by=undecided(each.by), best=None) for each in self.phases)
        return replace(self, by=undecided(self.by), phases=phases, best=None, decided=False)

    @property
    def unit(self) -> str:
        return "N" if self.slides else "N·m"


@final
@dataclass(frozen=True)
class SupportResult:
    """band_model: device -> where the values of its band model come from."""

    trials: tuple[Trial, ...]
    joints: tuple[JointSupport, ...]
    band_model: Mapping[str, Remark]
    remarks: tuple[Remark, ...]

    def with_nothing_decided(self, devices: Collection[str]) -> SupportResult:
        """The same, where no number of these devices counts as decided by the data."""
        joints = (each.with_nothing_decided() if each.device in devices else each for each in self.joints)
        return replace(self, joints=tuple(joints))
