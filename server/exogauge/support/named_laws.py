"""Of what was named of a device's bands: the shapes that suit it best with all that is declared beside it, how sharply
they are known, and its numbers in SI units.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from exogauge.devices.result import Estimate
from exogauge.support.band_inputs import SHAPE_DOUBT
from exogauge.support.band_model import Added, Reached, Setting, Wear, lowest, thinned
from exogauge.support.band_rows import Wire

Array = NDArray[np.float64]


def with_best_shapes(setting: Setting, wear: Wear) -> Wear:
    """One shape after the other, from where the search found it, everything else fitted to it; and linear about what
    the coefficients then are. setting: with all that is declared beside the springs, and no shapes."""
    rounds = 2  # shapes of one law go with each other a little
    few, begun = thinned(setting), wear
    for _ in range(rounds):
        for number, added in enumerate(begun.added):
            if added.effect.once or any(_alike(each, added) for each in begun.added[:number]):
                continue
            for place in added.searched:
                believed = added.effect.shapes[place].share(added.shape[place])
                wear = moved(wear, number, place, _best_share(few, wear, number, place, believed))
        reached = lowest(setting, wear).wear
        wear = replace(reached, added=tuple(each.linear_about_itself() for each in reached.added))
    return wear


def _best_share(setting: Setting, wear: Wear, number: int, place: int, believed: float) -> float:
    """Of one shape's range. believed: where the search found it."""
    close = 0.002  # of the range: nothing is seen of a shape that is moved by less

    def cost(share: float) -> float:
        reached = lowest(setting, moved(wear, number, place, float(share)))
        return float(reached.cost + ((share - believed) / SHAPE_DOUBT) ** 2)

    return float(minimize_scalar(cost, bounds=(0.0, 1.0), method="bounded", options={"xatol": close}).x)


def moved(wear: Wear, number: int, place: int, share: float) -> Wear:
    """With one shape of what was added, and of what was added to other bands with the same shapes, elsewhere. share: of
    its range."""
    chosen = wear.added[number]
    value = chosen.effect.shapes[place].at(share)

    def there(each: Added) -> Added:
        return replace(each, shape=(*each.shape[:place], value, *each.shape[place + 1 :]))

    return replace(wear, added=tuple(there(each) if _alike(each, chosen) else each for each in wear.added))


def _alike(one: Added, other: Added) -> bool:
    """Named together, at the bands of a group."""
    same = (one.shape[place] == other.shape[place] for place in one.searched)
    return one.effect.name == other.effect.name and all(same)


@final
@dataclass(frozen=True)
class Sharpness:
    """std: of a shape. moves: (C,) by how much that moves the coefficients, which go with it."""

    std: float
    moves: Array


def sharpness(setting: Setting, wear: Wear, number: int) -> list[Sharpness]:
    """Of each shape of what was added."""
    added = wear.added[number]
    unknown = Sharpness(float("inf"), np.zeros(len(added.coefficients)))
    places = range(len(added.effect.shapes))
    return [_of_shape(setting, wear, number, place) if place in added.searched else unknown for place in places]


def _of_shape(setting: Setting, wear: Wear, number: int, place: int) -> Sharpness:
    """How far a shape must be moved for the cost to rise by one independent error, from both sides together, everything
    else fitted to it; inf where it does not rise within the shape's range."""
    most_steps = 12
    step = 0.02  # of a shape's range: how far it is moved first to see how sharply it is known
    added = wear.added[number]
    one = added.effect.shapes[place]
    here = one.share(added.shape[place])

    def at(share: float) -> Reached:
        return lowest(setting, moved(wear, number, place, share))

    least = at(here).cost
    for _ in range(most_steps):
        low, high = at(max(here - step, 0.0)), at(min(here + step, 1.0))
        risen = 0.5 * (low.cost + high.cost) - least
        if risen > 4.0:  # it is moved less, or further, until the cost rises by something between 4 and 0.5
            step *= 0.5
        elif risen < 0.5 and step < 1.0:
            step *= 2.0
        else:
            break
    ends = [each.wear.added[number] for each in (low, high)]
    way, moves = (0.5 * np.abs(np.subtract(*pair)) for pair in (
        [each.shape[place] for each in ends], [each.coefficients for each in ends]))  # fmt: skip
    known = float(np.sqrt(risen)) if risen > 0.0 else 0.0
    return Sharpness(float(way / known), moves / known) if known else Sharpness(float("inf"), moves)


def numbers(added: Added, wire: Wire, stds: Array, sharp: Sequence[Sharpness]) -> Mapping[str, Estimate]:
    """Coefficients and shapes in SI units. stds: (C,) of the coefficients."""
    found: dict[str, Estimate] = {}
    for quantity, value, std in zip(added.effect.coefficients, added.coefficients, stds, strict=True):
        angular = wire.course.routing is None and quantity.unit == "N/m"
        found[quantity.name] = Estimate(float(value), float(std), "N·m/rad" if angular else quantity.unit)
    for one, value, own in zip(added.effect.shapes, added.shape, sharp, strict=True):
        size, offset, name, unit = _in_si(one.name, one.unit, wire)
        if name and name not in found:
            found[name] = Estimate(offset + size * value, abs(size) * own.std, unit)
    return found


def _in_si(name: str, unit: str, wire: Wire) -> tuple[float, float, str, str]:
    """size, offset, name, unit in which a shape is told; name "" where it says nothing that a coefficient does not."""
    told = {
        "moment": (wire.span, 0.0, "moment", "s"),
        "lasting": (0.0, 0.0, "", ""),
        "within": (0.0, 0.0, "", ""),
        "slack": (wire.travel, wire.shortest, "natural_length", "m" if wire.course.routing is not None else "rad"),
    }
    return told.get(name, (1.0, 0.0, name, unit))
