"""Effects that the model gets beside its own: each at one site, with their shapes chosen before."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.identification.added_column import AddedColumn
from exogauge.identification.model import RobotModel
from exogauge.identification.preparation import Prepared
from exogauge.identification.site import Effect, Seen, Site
from exogauge.identification.validate import NoiseFloor

Array = NDArray[np.float64]


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
        """The same log with what the added effects do to its rows per unit of their coefficients, filtered as those."""
        seen: dict[Site, Seen] = {}
        raw = list[Array]()
        for each in self.effects:
            if each.site not in seen:
                seen[each.site] = each.site.see(self.parent, prepared)
            columns = seen[each.site].columns(each.effect, each.shape)
            raw.append(columns.reshape(prepared.log.samples, -1))
        new = np.hstack(raw) if raw else np.zeros((prepared.log.samples, 0))
        return replace(
            prepared,
            added=np.hstack([prepared.added, prepared.low_pass.apply(new)]),
            raw_added=np.hstack([prepared.raw_added, prepared.log.as_stored(new)]),
        )
