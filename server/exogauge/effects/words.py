"""What the identifiers of effects and places mean, in a person's words."""

from __future__ import annotations

from collections.abc import Mapping

from exogauge.effects.band import BandEffect
from exogauge.effects.catalogue import every_effect
from exogauge.effects.effect import JointEffect, Quantity
from exogauge.effects.shaped import MissingEffect, Shape

DETECTED = {
    "link_mass": "a wrong link mass",
    "contact": "an unannounced contact",
    "band_limited_log": "signals low-passed before they were stored",
}  # named by a detector of its own, which no file of an effect describes

ALL = "all"  # name of a place: each of its kind


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


def opening(kind: str, name: str, part: str = "") -> str:
    """What a sentence on a place begins with: `torso_pitch: `; nothing of the base, whose sentences name it."""
    if kind == "base":
        return ""
    place = place_words(kind, name, part)
    return f"{place if name != ALL else place[:1].upper() + place[1:]}: "


def _parameters(effect: JointEffect | MissingEffect | BandEffect) -> Mapping[str, str]:
    own: tuple[Quantity | Shape, ...] = getattr(effect, "coefficients", ())
    return {each.name: each.words for each in (*own, *getattr(effect, "shapes", ()))}
