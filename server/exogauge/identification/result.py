"""What identification says: parameters with uncertainty, how well they predict, and what the data cannot tell."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.identification.common_factor import CommonFactor
from exogauge.identification.model import RobotModel
from exogauge.identification.total_mass import TotalMass
from exogauge.remarks import Remark
from exogauge.side_by_side import each as side_by_side

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Parameter:
    """One number about the robot.

    name: `m[link]`, `mx[link]`, `Ixx[link]` … for links, `k_T[joint]` … for joints, `base[<leading name>]` for a base
    parameter, whose `combination` gives the coefficient of every standard parameter in it.
    std: standard deviation from noise, coloured residuals and prior. identifiable: the data, not the prior, decide it.
    parts: source -> standard deviation that it alone makes, `robot` and what is declared; none of a base parameter.
    """

    name: str
    value: float
    std: float
    unit: str
    prior: float
    prior_std: float
    identifiable: bool
    combination: Mapping[str, float] = field(default_factory=dict)
    parts: Mapping[str, float] = field(default_factory=dict)


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
class Channels:
    """(T,) each, channel names as in `ChannelFit`.

    measured: unfiltered (joint torques in N·m also where currents were logged, with the identified k_T).
    steady: samples in steady motion, which alone are judged.
    """

    measured: Mapping[str, Array]
    predicted: Mapping[str, Array]
    predicted_prior: Mapping[str, Array]
    steady: Mapping[str, NDArray[np.bool_]]


@final
@dataclass(frozen=True)
class Prediction:
    """One log explained, on its own sample times (T,). units: of every channel.

    channels: computes them, with the same bits whenever it is asked. They are not kept: of an hour at 200 Hz and 34
    joints they take 0.7 GB, and every model that a search has named something in has its own.
    """

    log: str
    held_out: bool
    time: Array
    units: Mapping[str, str]
    channels: Callable[[], Channels]


@final
@dataclass(frozen=True)
class SteadyShare:
    """Of one joint's actuator axis [s]: how long it moves steadily, and of that how long it moves at all, over fitted
    and over held-out logs. both_directions: whether the fitted steady motion goes both ways, or the joint does not."""

    joint: str
    fitted_s: float
    fitted_of_s: float
    held_out_s: float
    held_out_of_s: float
    both_directions: bool


@final
@dataclass(frozen=True)
class Identification:
    """The identified robot.

    phi: (N, 10) standard inertial parameters (layout of `RigidTree.phi`), prior where the data are silent.
    joint_values: joint parameter name (`k_T`, `k_d` …) -> (J,), on actuator axes, joint-side units.
    parameters: every standard, base and joint parameter. unidentifiable: names that stay (nearly) at the prior, even
    if a common factor that nothing measured fixes were known.
    model: to apply to further logs. steady: one entry per joint.
    factor: what is known of the scale of all torques. total_mass: what the contact sensors weigh, None without any.
    per_stated: channel -> factor that brings its torques to the scale of the stated k_T, for joints whose scale nothing
    measured fixes: an error in newton metres must not fall because k_T does. Empty where the scale is known.
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
    remarks: tuple[Remark, ...]
    model: RobotModel
    steady: tuple[SteadyShare, ...] = ()
    per_stated: Mapping[str, float] = field(default_factory=dict)
    factor: CommonFactor = field(default_factory=CommonFactor)
    total_mass: TotalMass | None = None

    def with_nothing_decided(self) -> Identification:
        """The same, where no number counts as decided by the data."""
        loads = "load."  # which are told by themselves
        names = tuple(each.name for each in self.parameters if not each.name.startswith(loads))
        parameters = tuple(replace(each, identifiable=False) for each in self.parameters)
        return replace(self, parameters=parameters, unidentifiable=names)

    def with_undecided(self, joints: Collection[str], coefficients: Collection[str] = ()) -> Identification:
        """The same, where no parameter of these joints, nor such a coefficient, counts as decided by the data."""
        of, such = tuple(f"[{joint}]" for joint in joints), tuple(f"{name}[" for name in coefficients)
        there = [each for each in self.parameters if each.name.endswith(of) or each.name.startswith(such)]
        parameters = tuple(replace(e, identifiable=False) if e in there else e for e in self.parameters)
        names = tuple(each.name for each in there if each.name not in self.unidentifiable)
        return replace(self, parameters=parameters, unidentifiable=(*self.unidentifiable, *names))

    def by_stated_constants(self) -> Identification:
        """The same with torques and their errors as the stated k_T make them of the currents (`per_stated`)."""
        if not self.per_stated:
            return self
        of = self.per_stated

        def scaled(values: Mapping[str, Array]) -> dict[str, Array]:
            return {channel: each * of.get(channel, 1.0) for channel, each in values.items()}

        def whole(one: Prediction) -> Channels:
            told = one.channels()
            return replace(told, measured=scaled(told.measured), predicted=scaled(told.predicted))

        def fit(each: ChannelFit, told: Channels) -> ChannelFit:
            if each.channel not in of:
                return each
            s = of[each.channel]
            before = told.measured[each.channel] - told.predicted_prior[each.channel]
            return replace(
                each,
                rmse_prior=float(np.sqrt(np.mean(before**2))),
                rmse_identified=s * each.rmse_identified,
                noise_floor=s * each.noise_floor,
                noise_beyond_band=s * each.noise_beyond_band,
                rmse_moving=None if each.rmse_moving is None else s * each.rmse_moving,
                rmse_at_rest=None if each.rmse_at_rest is None else s * each.rmse_at_rest,
            )

        predictions = tuple(replace(each, channels=partial(whole, each)) for each in self.predictions)
        by_log: dict[str, list[ChannelFit]] = {}
        for each in self.validation:
            by_log.setdefault(each.log, []).append(each)

        def fits(one: Prediction) -> list[ChannelFit]:
            told = one.channels()
            return [fit(each, told) for each in by_log.get(one.log, ())]

        validation = tuple(each for own in side_by_side(fits, predictions) for each in own)
        return replace(self, predictions=predictions, validation=validation)
