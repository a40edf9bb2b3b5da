"""The force laws of device.yaml and what-if: the spring, and every effect of a band that has a name there."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cache
from types import MappingProxyType
from typing import final

import numpy as np

from exogauge.effects.band import Array, BandEffect, Stated, WireMotion
from exogauge.effects.catalogue import band_effects
from exogauge.effects.effect import Quantity
from exogauge.effects.shaped import Shape
from exogauge.errors import BadInput, Fault

LINEAR = "linear"
AND = "+"  # between laws that a band has at once
SPRING = "It pulls in proportion to its stretch, and is slack below its natural length."


@final
@dataclass(frozen=True)
class LawValue:
    """A value beside stiffness and natural length."""

    name: str
    unit: str
    words: str
    stated: Stated


@final
@dataclass(frozen=True)
class BandLaw:
    """T = max(k x + Σ T_e, 0), x = max(l - l_0, 0), T_e what each effect adds; without effects the linear law.

    Implements [Evaluator] (25), where f = -T. Differs from print: 0 for l < l_0 (printed l < 0).
    What rubs is added last, per segment.
    """

    name: str
    effects: tuple[BandEffect, ...] = ()

    @property
    def values(self) -> tuple[LawValue, ...]:
        found = dict[str, LawValue]()
        for effect in self.effects:
            own: tuple[Quantity | Shape, ...] = (*effect.coefficients, *effect.shapes)
            for each in own:
                found.setdefault(each.name, LawValue(each.name, each.unit, each.words, effect.stated[each.name]))
        return tuple(found.values())

    def parts(self, values: Mapping[str, float]) -> list[tuple[BandEffect, tuple[float, ...], tuple[float, ...]]]:
        """Each effect with its shape and its coefficients. values: by name; what is left out has its default."""
        given = {each.name: each.stated.default for each in self.values} | dict(values)

        def of(names: Sequence[Quantity | Shape]) -> tuple[float, ...]:
            return tuple(float(given[each.name] or 0.0) for each in names)

        return [(effect, of(effect.shapes), of(effect.coefficients)) for effect in self.effects]

    @property
    def sentence(self) -> str:
        return " ".join(effect.sentence for effect in self.effects) or SPRING

    @property
    def per_segment(self) -> bool:
        """The tension differs along the band."""
        return any(effect.per_segment for effect in self.effects)

    def tension(
        self, motion: WireMotion, stiffness: float, natural_length: float, values: Mapping[str, float]
    ) -> Array:
        """(T,), or (T, S) per segment, [N], not negative. stiffness [N/m], natural_length [m]. values: by name."""
        signals, parts = motion.with_spring(stiffness, natural_length), self.parts(values)
        whole = signals.tension
        for effect, shape, coefficients in parts:
            if not effect.per_segment:
                whole = whole + effect.added_tension(signals, shape) @ np.array(coefficients)
        whole = np.maximum(whole, 0.0)
        if not self.per_segment:
            return whole
        if motion.segment_length is None or motion.wrap is None:
            raise ValueError(f"the law {self.name!r} needs segment lengths and wrap angles")
        along = np.repeat(whole[:, None], motion.segment_length.shape[1], axis=1)
        for effect, shape, coefficients in parts:
            if effect.per_segment:
                along += effect.added_tension(signals, shape) @ np.array(coefficients)
        return np.maximum(along, 0.0)


@cache
def all_laws() -> Mapping[str, BandLaw]:
    """Identifier -> law."""
    named = {effect.law: BandLaw(effect.law, (effect,)) for effect in band_effects().values() if effect.law}
    return MappingProxyType({LINEAR: BandLaw(LINEAR)} | named)


def law_named(name: str) -> BandLaw:
    """Of one law, or of several with `+` between them. Raises BadInput."""
    faults = list(_name_faults(name, "law"))
    if faults:
        raise BadInput(faults)
    return BandLaw(name, tuple(effect for part in _parts(name) for effect in all_laws()[part].effects))


def check_values(
    law: str, values: Mapping[str, float], law_key: str = "law", values_key: str = "law_values"
) -> BandLaw:
    """The named law, if the values are its own. Raises BadInput, with the keys as the faults' columns."""
    faults = list(law_faults(law, values, law_key, values_key))
    if faults:
        raise BadInput(faults)
    return law_named(law)


def law_faults(
    law: str, values: Mapping[str, float], law_key: str = "law", values_key: str = "law_values"
) -> Iterator[Fault]:
    """An unknown law; values that it does not know, lacks, or cannot take."""
    unknown = list(_name_faults(law, law_key))
    if unknown:
        yield from unknown
        return
    quantities = {each.name: each for each in law_named(law).values}
    for name in values:
        if name not in quantities:
            advice = f"It has {', '.join(quantities)}" if quantities else "Leave it out"
            detail = f"the law {law!r} has no parameter {name!r}"
            yield Fault(detail, "unknown_law_value", advice, column=f"{values_key}.{name}", value=name[:80])
    for name, each in quantities.items():
        stated, column = each.stated, f"{values_key}.{name}"
        advice = f"{each.words[:1].upper()}{each.words[1:]}. Typical: {stated.typical:g} {each.unit}"
        if name not in values:
            if stated.default is None:
                yield Fault(f"the law {law!r} needs {name!r}", "missing_law_value", advice, column=column)
        elif not stated.low <= values[name] <= stated.high or abs(values[name]) == float("inf"):
            detail = f"{name!r} must be between {stated.low:g} and {stated.high:g} {each.unit}"
            yield Fault(detail, "law_value_range", advice, column=column, value=f"{values[name]:g}")


def _name_faults(law: str, key: str) -> Iterator[Fault]:
    known, parts = all_laws(), _parts(law)
    for part in parts:
        if part not in known:
            close = get_close_matches(part, list(known), n=1)
            advice = f"Did you mean {close[0]!r}?" if close else f"Known laws: {', '.join(sorted(known))}"
            yield Fault(f"there is no force law {part!r}", "unknown_law", advice, column=key, value=part[:80])
    for part in dict.fromkeys(part for part in parts if parts.count(part) > 1):
        yield Fault(f"the law {part!r} stands there twice", "law_twice", "Name it once", column=key, value=part[:80])


def _parts(law: str) -> list[str]:
    return [part.strip() for part in law.split(AND)]
