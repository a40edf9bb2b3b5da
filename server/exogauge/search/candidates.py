"""Everything that could be missing: each effect of the catalogue at each site, at each of its shapes."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.effects.order import present, whatever_log
from exogauge.identification.model import Effect, RobotModel, Seen, Site
from exogauge.identification.preparation import Prepared
from exogauge.identification.sites import (
    AxisSite,
    BaseSite,
    EncoderSite,
    LinkSite,
    PairSite,
    SensorSite,
    encoders,
    end_links,
    neighbours,
)  # fmt: skip
from exogauge.logs.filtering import low_passed_at
from exogauge.search.sums import Columns

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
    """Where effects can sit: axes whose drive is logged, neighbouring ones of them, encoders, components of sensors,
    contact sensors as a whole, links that carry nothing, the base."""
    joints = model.robot.joints
    axes = [AxisSite(axis) for axis, joint in enumerate(joints) if joint.actuation != "none"]
    of_cuts = [SensorSite(index, row) for index in range(len(model.robot.cuts)) for row in range(6)]
    tree = model.robot.tree
    contacts = [index for index, sensor in enumerate(model.robot.contacts) if tree.frames[sensor.frame][0] >= 0]
    of_contacts = [SensorSite(index, row, contact=True) for index in contacts for row in (*range(6), None)]
    return (
        *axes,
        *neighbours(model.robot),
        *encoders(model.robot),
        *of_cuts,
        *of_contacts,
        *end_links(model.equations),
        BaseSite(),
    )


def place_kind(site: Site) -> str:
    """`Effect.place` of the effects that can sit here."""
    if isinstance(site, SensorSite) and site.component is None:
        return "whole_sensor"
    return {
        AxisSite: "joint",
        PairSite: "pair",
        EncoderSite: "encoder",
        SensorSite: "sensor",
        LinkSite: "link",
        BaseSite: "base",
    }[type(site)]


def of_measurement(site: Site) -> bool:
    """Whether what sits here is wrong with a sensor, and not with the robot."""
    return isinstance(site, SensorSite | BaseSite)


def grid(effect: Effect) -> Iterator[tuple[float, ...]]:
    """All combinations of the shapes' grid values; the empty one where it has none."""
    yield from itertools.product(*(shape.grid for shape in effect.shapes))


def columns_of(candidates: Sequence[Candidate], seen: Seen, prepared: Prepared, kinds: int) -> Columns:
    """What they take off the site's rows per unit of each coefficient, at the log's kept samples, low-passed as the
    rows are. Two effects may share a name (`ImuTilt`)."""
    held = 500_000  # values of columns that are filtered at once: 4 MB
    number = int(getattr(seen.signals, "number", -1))
    raw, which, filtered, waiting = list[Array](), list[NDArray[np.intp]](), [np.zeros((len(prepared.kept), 0))], 0
    last = 0  # of the different ones
    for _, alike in itertools.groupby(candidates, key=lambda each: id(each.effect)):
        those = list(alike)
        effect, width = those[0].effect, those[0].width
        here = [(whatever_log(effect.shapes, each.shape), present(effect.shapes, each.shape, number)) for each in those]
        first = {each: those[here.index(each)].shape for each in dict.fromkeys(here) if each[1]}
        place = {each: last + k * width for k, each in enumerate(first)}
        which += [place[each] + np.arange(width) if each[1] else np.full(width, -1) for each in here]
        last += len(first) * width
        shapes, together = list(first.values()), max(1, held // (width * kinds * prepared.log.samples))
        for some in (shapes[k : k + together] for k in range(0, len(shapes), together)):
            raw.append(seen.channels(effect, some))
            waiting += len(raw[-1])
            if waiting * prepared.log.samples > held:
                filtered.append(_filtered(np.concatenate(raw), prepared))
                raw, waiting = [], 0
    if raw:
        filtered.append(_filtered(np.concatenate(raw), prepared))
    different = np.concatenate(filtered, axis=1).reshape(len(prepared.kept), last, kinds)
    return Columns(different, np.concatenate([*which, np.zeros(0, dtype=np.intp)]) % (last + 1))


def _filtered(channels: Array, prepared: Prepared) -> Array:
    """(K, T) to (n, K)."""
    some = channels.any(axis=1)
    if some.all():
        return low_passed_at(prepared.low_pass, channels, prepared.kept)
    kept = np.zeros((len(prepared.kept), len(channels)))
    kept[:, some] = low_passed_at(prepared.low_pass, channels[some], prepared.kept)
    return kept
