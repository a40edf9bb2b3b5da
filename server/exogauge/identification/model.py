"""An identified robot, ready to be applied to further logs: parameters, their covariance, and how signals are made."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, final

import numpy as np
from numpy.typing import NDArray

from exogauge.identification.equations import Equations
from exogauge.identification.load_columns import of_loads
from exogauge.identification.per_log import PerLog
from exogauge.identification.predict import Parameters, motor_gain
from exogauge.identification.preparation import Prepared, prepare
from exogauge.identification.solution import Solution
from exogauge.identification.turns import RestDetection
from exogauge.logs.model import Log
from exogauge.robots.description import Robot

if TYPE_CHECKING:
    from exogauge.identification.added import Extension

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class AxisSizes:
    """Of the axes in the fitted logs, (A,): rms velocity [rad/s] and torque [N·m], range of position [rad], mean
    inertia [kg·m²]."""

    velocity: Array
    torque: Array
    range: Array
    inertia: Array


@final
@dataclass(frozen=True)
class RobotModel:
    """x = [φ_b; ξ]: (P,) in the parameters of `equations`.

    identified, a_priori: the same model with other numbers. covariance, a_priori_covariance: (P, P) of x about the
    truth; static friction is not in them (see `identification.static_friction`). solution: what they come from.
    sizes: of the fitted motions. known_scale: something fixes the scale of all torques (`common_factor`).
    order: name of a log -> its number in the order of the study, from 0.
    extension: effects that were added to a parent model, None for a first one.
    prepared: logs as they are without an extension; models that prepare them alike share it. computed: what
    `axis_signals.loads`, `site.carried` and `swings` have computed with this model's numbers.
    """

    equations: Equations
    identified: Parameters
    a_priori: Parameters
    covariance: Array
    a_priori_covariance: Array
    at_rest: RestDetection
    cutoff_hz: float
    solution: Solution
    sizes: AxisSizes
    extension: Extension | None = None
    order: Mapping[str, int] = field(default_factory=dict)
    known_scale: bool = True
    prepared: PerLog = field(default_factory=PerLog, repr=False, compare=False)
    computed: PerLog = field(default_factory=PerLog, repr=False, compare=False)

    @property
    def robot(self) -> Robot:
        return self.equations.robot

    @property
    def k_T(self) -> Array:
        """(A,) identified motor gains; 1 where torque is logged."""
        return motor_gain(self.equations, self.identified)

    def prepare(self, log: Log) -> Prepared:
        """A further log, filtered and differentiated as the identified ones were."""
        bare = self.prepare_bare(log)
        return self.extension.attach(bare) if self.extension else bare

    def prepare_bare(self, log: Log) -> Prepared:
        """The same without what an extension adds."""
        return self.prepared.of(log, "prepared", lambda: prepare(self.robot, log, self.cutoff_hz, self.at_rest))

    def bodies_in(self, recording: str) -> Array:
        """(B,) base parameters of the identified bodies, with the loads that a recording carries."""
        phi = self.identified.phi.copy()
        for load, coefficients in zip(
            self.robot.loads, of_loads(self.equations.added, self.identified.added), strict=True
        ):
            if recording in load.logs:
                phi[load.body] += load.columns @ coefficients
        return np.asarray(self.equations.base.regroup @ phi.ravel())
