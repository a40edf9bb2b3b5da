"""An identified robot, ready to be applied to further logs; effects that it got beside its own, each at one site."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Protocol, final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.criteria import Criteria
from exogauge.effects.shaped import AxisSignals, ManyShapes, MissingEffect
from exogauge.identification.added_columns import AddedColumn, of_loads
from exogauge.identification.equations import Equations
from exogauge.identification.noise_bias import NoiseFloor
from exogauge.identification.per_log import PerLog
from exogauge.identification.predict import Parameters, motor_gain
from exogauge.identification.preparation import Prepared, prepare
from exogauge.identification.solution import Solution
from exogauge.identification.turns import RestDetection
from exogauge.identification.type_b import TypeB, by_source, of_covariance
from exogauge.logs.model import Log
from exogauge.robots.description import Robot

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
    inputs: what declared uncertainties have done to x.
    sizes: of the fitted motions. known_scale: something fixes the scale of all torques (`common_factor`).
    criteria: by which it was made, and is judged.
    order: name of a log -> its number in the order of the study, from 0.
    extension: effects that were added to a parent model, None for a first one.
    prepared: logs as they are without an extension; models that prepare them alike share it. computed: what
    `axis_signals` and `sites` have computed with this model's numbers. attached: what the extension adds to each log.
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
    criteria: Criteria = field(default_factory=Criteria)
    prepared: PerLog = field(default_factory=PerLog, repr=False, compare=False)
    computed: PerLog = field(default_factory=PerLog, repr=False, compare=False)
    attached: PerLog = field(default_factory=PerLog, repr=False, compare=False)
    inputs: TypeB = field(default_factory=TypeB)

    @property
    def doubt(self) -> Array:
        """(P + I, P + I) of x, as it would be without the declared uncertainties that all logs share, and of these."""
        return of_covariance(self.covariance, self.inputs)

    @cached_property
    def doubt_by_source(self) -> dict[str, Array]:
        """Source -> its part of `doubt`."""
        return by_source(self.covariance, self.inputs)

    @property
    def a_priori_doubt(self) -> Array:
        """The same of the maker's values, which no log has moved."""
        stated = self.a_priori_covariance
        return of_covariance(stated + self.inputs.alike if self.inputs.names else stated, self.inputs)

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
        if (extension := self.extension) is None:
            return bare
        return bare.with_added(*self.attached.of(log, "attached", lambda: extension.added_to(bare)))

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


@final
@dataclass(frozen=True)
class AddedEffect:
    """An effect at a site, with the values of its shapes."""

    effect: Effect
    site: Site
    shape: tuple[float, ...] = ()


@final
@dataclass(frozen=True)
class Extension:
    """parent: the model that the effects are added to; its loads and motor torques are what they see.

    noise_floors: (log, channel) -> what was found with the parent; sensors' noise does not change with the model.
    """

    parent: RobotModel
    effects: tuple[AddedEffect, ...]
    noise_floors: Mapping[tuple[str, str], NoiseFloor] = field(default_factory=dict)

    @property
    def columns(self) -> tuple[AddedColumn, ...]:
        """In the order of x."""
        return tuple(self._columns())

    def _columns(self) -> Iterator[AddedColumn]:
        equations = self.parent.equations
        for each in self.effects:
            _, name, part = each.site.label(equations)
            place = f"{name}.{part}" if part else name
            for coefficient in each.effect.coefficients:
                unit = each.site.in_si(self.parent, coefficient.unit, each.shape)[1]
                named = f"{each.effect.name}.{coefficient.name}"
                yield AddedColumn(named, place, each.site.kinds(equations), replace(coefficient, unit=unit))

    def attach(self, prepared: Prepared) -> Prepared:
        """The same log with what the added effects do to its rows."""
        return prepared.with_added(*self.added_to(prepared))

    def added_to(self, prepared: Prepared) -> tuple[Array, Array]:
        """(T, entries) each: what the added effects do to a log's rows per unit of their coefficients, filtered as
        those, and not."""
        seen: dict[Site, Seen] = {}
        raw = [np.zeros((prepared.log.samples, 0))]
        for each in self.effects:
            if each.site not in seen:
                seen[each.site] = each.site.see(self.parent, prepared)
            columns = seen[each.site].columns(each.effect, each.shape)
            raw.append(columns.reshape(prepared.log.samples, -1))
        new = np.hstack(raw)
        return prepared.low_pass.apply(new), prepared.log.as_stored(new)


class Effect(MissingEffect, Protocol):
    """Of any place: `columns`, `changes` or `present` is for its site to call."""

    def applies(self, signals: Any) -> bool: ...


@final
@dataclass(frozen=True)
class Seen:
    """What a site sees of one log. signals: what its effects take.

    columns: (effect, shape) -> (T, C, kinds) what each coefficient takes off the rows of each of the site's kinds, per
    unit, not low-passed.
    """

    signals: Any
    columns: Callable[[Any, tuple[float, ...]], Array]

    def channels(self, effect: Any, shapes: Sequence[tuple[float, ...]]) -> Array:
        """(L C kinds, T) the columns of several shapes, one after the other."""
        if isinstance(effect, ManyShapes) and isinstance(self.signals, AxisSignals):
            return effect.columns_of_all(self.signals, shapes)
        every = [self.columns(effect, shape) for shape in shapes]
        return np.concatenate([each.reshape(len(each), -1).T for each in every])

    def coordinate(self, name: str, shape: tuple[float, ...] = ()) -> Array:
        """(T,) of the evidence plot, which may depend on the shape; time where the log does not hold it."""
        values = getattr(self.signals, name, None)
        values = values(shape) if callable(values) else values
        return np.asarray(values if values is not None else self.signals.time)


class Site(Protocol):
    """label: (`joint` | `sensor` | `base`, name, part of it or "")."""

    def label(self, equations: Equations) -> tuple[str, str, str]: ...

    def kinds(self, equations: Equations) -> tuple[int, ...]: ...

    def see(self, model: RobotModel, prepared: Prepared) -> Seen: ...

    def in_si(self, model: RobotModel, unit: str, shape: tuple[float, ...]) -> tuple[float, str]: ...
