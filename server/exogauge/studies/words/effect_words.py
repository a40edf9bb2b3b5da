"""Words put together for a reader: those of effects and places, and lists of them."""

from __future__ import annotations

from collections.abc import Sequence

from exogauge.effects.words import at_place, effect_words, parameter_words, place_words

__all__ = ["at_place", "capital", "effect_words", "listed", "parameter_words", "place_words"]


def listed(words: Sequence[str]) -> str:
    """`a`, `a and b`, `a, b and c`."""
    return " and ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)


def capital(text: str) -> str:
    """The first letter large: names of joints stay as they are."""
    return text[:1].upper() + text[1:]
