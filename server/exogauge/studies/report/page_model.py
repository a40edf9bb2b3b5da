"""A printed page as content: rows of blocks with tables, facts and a drawing; HTML and PDF are made of the same."""

from __future__ import annotations

import re
import unicodedata
from dataclasses import dataclass
from typing import Literal, final

Colour = Literal["ink", "muted", "line", "measured", "identified", "prior"]
Anchor = Literal["start", "middle", "end"]

UNPRINTED = "□"  # in place of what would hide, turn round or break text


@final
@dataclass(frozen=True)
class Column:
    """share: of the table's width."""

    title: str
    share: float
    number: bool = False


@final
@dataclass(frozen=True)
class Table:
    caption: str
    columns: tuple[Column, ...]
    rows: tuple[tuple[str, ...], ...]


@final
@dataclass(frozen=True)
class Line:
    """From (x, y) to (to_x, to_y), width in mm."""

    x: float
    y: float
    to_x: float
    to_y: float
    colour: Colour
    width: float = 0.2


@final
@dataclass(frozen=True)
class Box:
    """A rectangle; dots are small boxes. filled, or an outline."""

    x: float
    y: float
    width: float
    height: float
    colour: Colour
    filled: bool = True


@final
@dataclass(frozen=True)
class Label:
    """Text on one line, y at its base line; size in mm."""

    x: float
    y: float
    text: str
    size: float
    colour: Colour
    anchor: Anchor = "start"


@final
@dataclass(frozen=True)
class Drawing:
    """Lengths in mm, y downwards. words: what stands in for it."""

    width: float
    height: float
    marks: tuple[Line | Box | Label, ...]
    words: str


@final
@dataclass(frozen=True)
class Block:
    """In this order: a heading, sentences, a table, a drawing, facts, a list."""

    title: str
    sentences: tuple[str, ...] = ()
    table: Table | None = None
    drawing: Drawing | None = None
    facts: tuple[tuple[str, str], ...] = ()
    points: tuple[str, ...] = ()


@final
@dataclass(frozen=True)
class Row:
    """Blocks side by side. shares: of the width."""

    blocks: tuple[Block, ...]
    shares: tuple[float, ...] = (1.0,)


@final
@dataclass(frozen=True)
class Page:
    """label: a warning that must not be overlooked, empty for none."""

    title: str
    kicker: str
    label: str
    rows: tuple[Row, ...]
    footer: str


def plain(text: str, most: int) -> str:
    """On one line, at most so many characters, without marks that would hide or turn round what follows. Where it is
    cut, it ends with a clause or at least with a word, if that leaves three quarters of it.

    Signs of double width count twice.
    """
    visible = "".join(UNPRINTED if _hides(sign) else sign for sign in re.sub(r"[ \t\r\n\f\v]+", " ", text).strip(" "))
    if sum(map(_width, visible)) <= most:
        return visible
    kept, room = "", most - 1
    for sign in visible:
        room -= _width(sign)
        if room < 0:
            break
        kept += sign
    ends = [kept.rfind(end) + len(end) for end in ("; ", ". ", " ")]
    whole = next((end for end in ends if 4 * end > 3 * len(kept)), len(kept))
    return f"{kept[:whole].rstrip()}…" if whole == len(kept) else f"{kept[:whole].rstrip()} …"


def _width(sign: str) -> int:
    return 2 if unicodedata.east_asian_width(sign) in "WF" else 1


def _hides(sign: str) -> bool:
    """Controls, breaks, surrogates, unassigned, private characters; formats that change the direction of writing."""
    if unicodedata.category(sign) in ("Cc", "Zl", "Zp", "Cs", "Cn", "Co"):
        return True
    return "\u202a" <= sign <= "\u202e" or "\u2066" <= sign <= "\u2069" or sign in "\u200e\u200f\u061c\ufeff"
