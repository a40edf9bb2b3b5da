"""Everything that could be missing: each effect of the catalogue at each site, at each of its shapes."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.effects.order import bounded, whatever_log
from exogauge.identification.model import Effect, RobotModel, Seen, Site
from exogauge.identification.preparation import Prepared
from exogauge.identification.sites import (
    AxisSite,
    BaseSite,
    LinkSite,
    PairSite,
    SensorSite,
    end_links,
    neighbours,
)  # fmt: skip
from exogauge.logs.filtering import low_passed_at

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Candidate:
    """One effect at one site with one shape."""

    effect: Effect
    site: Site
    shape: tuple[float, ...]

    @property
    def width(self) -> int:
        """Number of its columns."""
        return len(self.effect.coefficients)

    @property
    def key(self) -> tuple[str, Site]:
        """What it is and where, whatever its shape."""
        return self.effect.name, self.site


def sites(model: RobotModel) -> tuple[Site, ...]:
    """Where effects can sit: axes whose drive is logged, neighbouring ones of them, components of sensors, contact
    sensors as a whole, links that carry nothing, the base."""
    joints = model.robot.joints
    axes = [AxisSite(axis) for axis, joint in enumerate(joints) if joint.actuation != "none"]
    of_cuts = [SensorSite(index, row) for index in range(len(model.robot.cuts)) for row in range(6)]
    contacts = range(len(model.robot.contacts))
    of_contacts = [SensorSite(index, row, contact=True) for index in contacts for row in (*range(6), None)]
    return (*axes, *neighbours(model.robot), *of_cuts, *of_contacts, *end_links(model.equations), BaseSite())


def place_kind(site: Site) -> str:
    """`Effect.place` of the effects that can sit here."""
    if isinstance(site, SensorSite) and site.component is None:
        return "whole_sensor"
    return {AxisSite: "joint", PairSite: "pair", SensorSite: "sensor", LinkSite: "link", BaseSite: "base"}[type(site)]


def grid(effect: Effect) -> Iterator[tuple[float, ...]]:
    """All combinations of the shapes' grid values; the empty one where it has none."""
    yield from itertools.product(*(shape.grid for shape in effect.shapes))


def columns_of(candidates: Sequence[Candidate], seen: Seen, prepared: Prepared, kinds: int) -> Array:
    """(n, C, kinds) what they take off the site's rows per unit of each coefficient, at the log's kept samples,
    low-passed as the rows are. What differs in the log alone that it begins with is filtered once; two effects may
    share a name (`ImuTilt`)."""
    raw, asked = [np.zeros((0, prepared.log.samples))], list[NDArray[np.intp]]()
    for _, alike in itertools.groupby(candidates, key=lambda each: id(each.effect)):
        those = list(alike)
        effect, high = those[0].effect, those[0].width * kinds
        own = seen.channels(effect, [each.shape for each in those]).reshape(len(those), high, -1)
        same = [(whatever_log(effect.shapes, each.shape), bounded(effect.shapes) and bool(columns.any()))
                for each, columns in zip(those, own, strict=True)]  # fmt: skip
        first = {each: same.index(each) for each in same}
        place, start = {n: k for k, n in enumerate(first.values())}, sum(len(each) for each in raw)
        raw.append(own[list(first.values())].reshape(-1, own.shape[2]))
        asked += [start + place[first[each]] * high + np.arange(high) for each in same]
    if not asked:
        return np.zeros((len(prepared.kept), 0, kinds))
    kept = _filtered(np.concatenate(raw), prepared)
    return kept[:, np.concatenate(asked)].reshape(len(kept), -1, kinds)


def _filtered(channels: Array, prepared: Prepared) -> Array:
    """(K, T) to (n, K)."""
    some = channels.any(axis=1)
    if some.all():
        return low_passed_at(prepared.low_pass, channels, prepared.kept)
    kept = np.zeros((len(prepared.kept), len(channels)))
    kept[:, some] = low_passed_at(prepared.low_pass, channels[some], prepared.kept)
    return kept
