"""What the identifiers of effects, places and channels mean, in a person's words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from exogauge.effects.band import BandEffect
from exogauge.effects.catalogue import every_effect
from exogauge.effects.effect import JointEffect, Quantity
from exogauge.effects.shaped import MissingEffect, Shape
from exogauge.findings.as_told import ALL
from exogauge.findings.result import ChainStep, Place

DETECTED = {
    "link_mass": "a wrong link mass",
    "contact": "an unannounced contact",
    "band_limited_log": "signals low-passed before they were stored",
}  # named by a detector of its own, which no file of an effect describes

FIRST_MODELS = {"robot": "identified model", "bands": "supporting torque, bands as springs"}
NO_BREAK = "\u00a0"


def words_of_effects() -> Mapping[str, str]:
    """Identifier -> what a person reads, of every effect of the catalogue and of what detectors name."""
    return {effect.name: effect.words for effect in every_effect()} | DETECTED


def effect_words(effect: str) -> str:
    """`stribeck` -> `Stribeck friction`; an identifier that is not known here, with spaces."""
    return words_of_effects().get(effect, effect.replace("_", " "))


def parameter_words(effect: str, parameter: str) -> str:
    """`stribeck`, `v_s` -> `speed over which it falls`; "" where the effect does not say."""
    known = (each for each in every_effect() if each.name == effect)
    return next((said for each in known if (said := _parameters(each).get(parameter))), "")


def place_words(kind: str, name: str, part: str = "") -> str:
    """`torso_pitch`, `wrist.fx`; with its kind where the name alone does not say what it is."""
    if part:
        return f"{name}.{part}"
    if name in ("", kind, "true"):
        return f"the {kind}"
    if name == ALL:
        return f"every {kind}"
    return name if kind in ("joint", "link") else f"{kind} {name}"


def at_place(effect: str, kind: str, name: str, part: str = "") -> str:
    """`Stribeck friction at torso_pitch`; of the base, of which there is one, the effect alone."""
    if kind == "base":
        return effect_words(effect)
    return f"{effect_words(effect)} {'in' if kind == 'log' else 'at'} {place_words(kind, name, part)}"


def titled(effect: str, place: Place) -> str:
    return at_place(effect, place.kind, place.name, place.part)


def channel(name: str) -> str:
    """`tau.torso_pitch` -> `torso_pitch`, `ft.wrist.fx` -> `wrist.fx`, `base.my` -> `base moment y`."""
    kind, _, rest = name.partition(".")
    if kind == "support":
        return f"{rest} (support)"
    if kind == "base":
        return f"base {'force' if rest[0] == 'f' else 'moment'} {rest[1:]}"
    return rest if kind in ("tau", "ft") else name


def step_words(step: ChainStep) -> str:
    """`identified model`, `+ Stribeck friction at torso_pitch`, `+ own curve of Stribeck friction at torso_pitch`."""
    return added_words(step) if step.place is None else f"+ {added_words(step)}"


def added_words(step: ChainStep) -> str:
    if step.place is None:
        return FIRST_MODELS[step.what]
    sort = "" if step.what == "effect" else f"{step.what.replace('_', ' ')} of "
    more = f" and at {counted(step.more, 'more place')}" if step.more else ""
    return f"{sort}{titled(step.effect, step.place)}{more}"


def told(value: float, form: str, unit: str = "") -> str:
    """`−3.1 N·m`: a true minus sign, and no line break before the unit."""
    return f"{value:{form}}{NO_BREAK if unit else ''}{unit}".replace("-", "\u2212")


def plus_minus(value: float, std: float, unit: str = "", forms: tuple[str, str] = (".2g", ".2g")) -> str:
    return f"{told(value, forms[0])} ±{NO_BREAK}{told(std, forms[1], unit)}"


def counted(number: int, noun: str) -> str:
    return f"{number:,} {noun}{'' if number == 1 else 's'}".replace(",", "\u202f")


def listed(words: Sequence[str]) -> str:
    """`a`, `a and b`, `a, b and c`."""
    return " and ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)


def capital(text: str) -> str:
    """The first letter large: names of joints stay as they are."""
    return text[:1].upper() + text[1:]


def _parameters(effect: JointEffect | MissingEffect | BandEffect) -> Mapping[str, str]:
    own: tuple[Quantity | Shape, ...] = getattr(effect, "shapes", ())
    return {each.name: each.words for each in (*own, *getattr(effect, "coefficients", ()))}
