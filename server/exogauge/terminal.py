"""What is written to a terminal: a progress bar on stderr, tables on stdout."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any, final

from tqdm import tqdm

SHAPE = "{desc} {percentage:3.0f}%|{bar:30}| {elapsed} {unit}"
LINE_EVERY_S = 5.0  # where stderr is a file and not a terminal


@final
class Bar:
    """Called as bar(fraction, phrase): what every long computation calls."""

    def __init__(self, drawn: tqdm[Any]) -> None:
        self._drawn = drawn
        self._pause = 0.1 if sys.stderr.isatty() else LINE_EVERY_S
        self._next = 0.0

    def __call__(self, fraction: float, phrase: str, name: str | None = None) -> None:
        self._drawn.n = min(max(fraction, 0.0), 1.0)
        if name is not None:
            self._drawn.set_description_str(name, refresh=False)
        self._drawn.unit = phrase
        now = time.monotonic()
        if now >= self._next:
            self._drawn.refresh()
            self._next = now + self._pause


@contextmanager
def bar(name: str, shown: bool = True) -> Iterator[Bar]:
    """A bar on stderr: drawn in place on a terminal, a line now and then elsewhere."""
    with tqdm(total=1.0, bar_format=SHAPE, desc=name, unit="", disable=not shown) as drawn:
        yield Bar(drawn)


def text_table(columns: Sequence[str], rows: Sequence[Sequence[Any]], widest: int = 40) -> str:
    """Columns aligned, numbers to the right with four digits, long text cut at `widest` with an ellipsis."""
    cells = [[shown(value, widest) for value in row] for row in rows]
    widths = [max(len(line[k]) for line in [list(columns), *cells]) for k in range(len(columns))]
    numeric = [
        bool(rows) and all(isinstance(row[k], int | float) or row[k] is None for row in rows)
        for k in range(len(columns))
    ]

    def line(texts: Sequence[str]) -> str:
        padded = (
            text.rjust(width) if right else text.ljust(width)
            for text, width, right in zip(texts, widths, numeric, strict=True)
        )
        return "  ".join(padded).rstrip()

    return "\n".join([line(columns), line(["-" * width for width in widths]), *(line(row) for row in cells)])


def shown(value: Any, widest: int) -> str:
    if value is None:
        return ""
    if isinstance(value, float):
        return f"{value:.4g}"
    text = " ".join(str(value).split())
    return text if len(text) <= widest else text[: widest - 1] + "…"
