"""What identification says: parameters with uncertainty, how well they predict, and what the data cannot tell."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.identification.model import RobotModel

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Parameter:
    """One number about the robot.

    name: `m[link]`, `mx[link]`, `Ixx[link]` … for links, `k_T[joint]` … for joints, `base[<leading name>]` for a base
    parameter, whose `combination` gives the coefficient of every standard parameter in it.
    std: standard deviation from noise, coloured residuals and prior. identifiable: the data, not the prior, decide it.
    """

    name: str
    value: float
    std: float
    unit: str
    prior: float
    prior_std: float
    identifiable: bool
    combination: Mapping[str, float] = field(default_factory=dict)


@final
@dataclass(frozen=True)
class ChannelFit:
    """RMSE of one predicted channel on one log. channel: `base.fx` … `base.mz` or `tau.<joint>`; unit N or N·m.

    noise_floor: what a model that lacks nothing leaves in steady motion; noise_beyond_band: of it, above the cut-off.
    rest_share: share of samples at which the joint stands still, where only an interval of the torque is predictable.
    rmse_moving, rmse_at_rest: the identified RMSE in steady motion and at rest; starts, stops and turns are in neither.
    Above the cut-off, where the equations say nothing, rmse_moving counts the sensors' noise alone.
    steady_s, moved_s: how long it is in steady motion, and how long it is not at rest.
    """

    channel: str
    unit: str
    log: str
    held_out: bool
    rmse_prior: float
    rmse_identified: float
    noise_floor: float
    rest_share: float = 0.0
    rmse_moving: float | None = None
    rmse_at_rest: float | None = None
    noise_beyond_band: float = 0.0
    steady_s: float = 0.0
    moved_s: float = 0.0


@final
@dataclass(frozen=True)
class Prediction:
    """One log explained: on the log's own sample times, (T,) each, channel names as in `ChannelFit`.

    measured: unfiltered (joint torques in N·m also where currents were logged, with the identified k_T).
    """

    log: str
    held_out: bool
    time: Array
    measured: Mapping[str, Array]
    predicted: Mapping[str, Array]
    predicted_prior: Mapping[str, Array]
    units: Mapping[str, str]


@final
@dataclass(frozen=True)
class Identification:
    """The identified robot.

    phi: (N, 10) standard inertial parameters (layout of `RigidTree.phi`), prior where the data are silent.
    joint_values: joint parameter name (`k_T`, `k_d` …) -> (J,), on actuator axes, joint-side units.
    parameters: every standard, base and joint parameter. unidentifiable: names that stay (nearly) at the prior.
    model: to apply to further logs.
    prior_strength: chosen factor on the prior's weight; prior_curve: (factor, held-out score) for all that were tried.
    """

    phi: Array
    joint_values: Mapping[str, Array]
    parameters: tuple[Parameter, ...]
    unidentifiable: tuple[str, ...]
    validation: tuple[ChannelFit, ...]
    predictions: tuple[Prediction, ...]
    consistent_links: tuple[bool, ...]
    prior_strength: float
    prior_curve: tuple[tuple[float, float], ...]
    condition: float
    rank: int
    samples: int
    cutoff_hz: float
    velocity_threshold: Array
    warnings: tuple[str, ...]
    model: RobotModel
