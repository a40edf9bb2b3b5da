"""Everything that could be missing: each effect of the catalogue at each site, at each of its shapes."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.effects.order import bounded, whatever_log
from exogauge.identification.link_site import LinkSite, end_links
from exogauge.identification.model import RobotModel
from exogauge.identification.pair_site import PairSite, neighbours
from exogauge.identification.preparation import Prepared
from exogauge.identification.site import AxisSite, BaseSite, Effect, Seen, SensorSite, Site

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
    """Where effects can sit: axes whose drive is logged, neighbouring ones of them, components of sensors that carry
    bodies, links that carry nothing, the base."""
    joints = model.robot.joints
    axes = [AxisSite(axis) for axis, joint in enumerate(joints) if joint.actuation != "none"]
    components = [SensorSite(index, row) for index in range(len(model.robot.cuts)) for row in range(6)]
    return (*axes, *neighbours(model.robot), *components, *end_links(model.equations), BaseSite())


def place_kind(site: Site) -> str:
    """`Effect.place` of the effects that can sit here."""
    return {AxisSite: "joint", PairSite: "pair", SensorSite: "sensor", LinkSite: "link", BaseSite: "base"}[type(site)]


def candidates_at(effects: Sequence[Effect]) -> list[tuple[Effect, tuple[float, ...]]]:
    return [(effect, shape) for effect in effects for shape in grid(effect)]


def grid(effect: Effect) -> Iterator[tuple[float, ...]]:
    """All combinations of the shapes' grid values; the empty one where it has none."""
    yield from itertools.product(*(shape.grid for shape in effect.shapes))


def columns_of(candidates: Sequence[Candidate], seen: Seen, prepared: Prepared, kinds: int) -> Array:
    """(n, C, kinds) what they take off the site's rows per unit of each coefficient, at the log's kept samples,
    low-passed as the rows are. Effects that differ in the log alone that they begin with are filtered once."""
    if not candidates:
        return np.zeros((len(prepared.kept), 0, kinds))
    distinct: dict[tuple[Effect, tuple[float, ...], bool], slice] = {}
    raw, asked, width = list[Array](), list[slice](), 0
    for each in candidates:
        own, shapes = seen.columns(each.effect, each.shape), each.effect.shapes
        same = each.effect, whatever_log(shapes, each.shape), not bounded(shapes) or bool(own.any())
        if same not in distinct:
            distinct[same] = slice(width, width + each.width)
            raw, width = [*raw, own], width + each.width
        asked.append(distinct[same])
    kept = _filtered(np.concatenate(raw, axis=1), prepared)
    return np.concatenate([kept[:, which] for which in asked], axis=1)


def _filtered(raw: Array, prepared: Prepared) -> Array:
    """(T, C, kinds) to (n, C, kinds)."""
    flat = raw.reshape(len(raw), -1)
    some = flat.any(axis=0)
    if some.all():
        return prepared.low_pass.apply(flat)[prepared.kept].reshape(-1, *raw.shape[1:])
    kept = np.zeros((len(prepared.kept), flat.shape[1]))
    kept[:, some] = prepared.low_pass.apply(flat[:, some])[prepared.kept]
    return kept.reshape(len(kept), *raw.shape[1:])
