"""What is written to a terminal: a progress bar on stderr, tables on stdout."""

from __future__ import annotations

import re
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any, Protocol, final

from tqdm import tqdm

SHAPE = "{desc:9} {percentage:3.0f}%|{bar:30}| {elapsed} {unit}"
DRAW_EVERY_S = 0.1
LINE_EVERY_S = 15.0  # where stderr is a file and not a terminal
NUMBER = re.compile(r"([-−]?[\d.]+( ?%)?)?|–")


class Progress(Protocol):
    """What every long computation calls: how much is done, 0 to 1, and what is being done."""

    def __call__(self, fraction: float, phrase: str, name: str | None = None) -> None: ...


@final
class Bar:
    """Drawn in place."""

    def __init__(self, drawn: tqdm[Any]) -> None:
        self._drawn = drawn
        self._next = 0.0

    def __call__(self, fraction: float, phrase: str, name: str | None = None) -> None:
        self._drawn.n = min(max(fraction, 0.0), 1.0)
        if name is not None:
            self._drawn.set_description_str(name, refresh=False)
        self._drawn.unit = phrase
        now = time.monotonic()
        if now >= self._next:
            self._drawn.refresh()
            self._next = now + DRAW_EVERY_S


@final
class Lines:
    """A whole line now and then and one at the end, for logs of builds and pipes."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._line = ""
        self._next = time.monotonic() + LINE_EVERY_S

    def __call__(self, fraction: float, phrase: str, name: str | None = None) -> None:
        self._name = name or self._name
        self._line = f"{self._name} {100 * fraction:.0f} % {phrase}".rstrip()
        now = time.monotonic()
        if now >= self._next:
            self.write()
            self._next = now + LINE_EVERY_S

    def write(self) -> None:
        """What was said last, unless it is written already."""
        if self._line:
            print(self._line, file=sys.stderr, flush=True)
            self._line = ""


def silent(fraction: float, phrase: str, name: str | None = None) -> None:
    """Progress that nobody watches."""


@contextmanager
def bar(name: str, shown: bool = True) -> Iterator[Progress]:
    """Progress on stderr: a bar on a terminal, a line now and then elsewhere."""
    if not shown:
        yield silent
    elif not sys.stderr.isatty():
        lines = Lines(name)
        try:
            yield lines
        finally:
            lines.write()
    else:
        with tqdm(total=1.0, bar_format=SHAPE, desc=name, unit="") as drawn:
            yield Bar(drawn)


def text_table(columns: Sequence[str], rows: Sequence[Sequence[Any]], widest: int = 40) -> str:
    """Columns aligned, numbers to the right (four digits, or as text gives them), long text cut at `widest`."""
    cells = [[shown(value, widest) for value in row] for row in rows]
    widths = [max(len(line[k]) for line in [list(columns), *cells]) for k in range(len(columns))]
    numeric = [bool(rows) and all(is_number(row[k]) for row in rows) for k in range(len(columns))]

    def line(texts: Sequence[str]) -> str:
        padded = (
            text.rjust(width) if right else text.ljust(width)
            for text, width, right in zip(texts, widths, numeric, strict=True)
        )
        return "  ".join(padded).rstrip()

    return "\n".join([line(columns), line(["-" * width for width in widths]), *(line(row) for row in cells)])


def is_number(value: Any) -> bool:
    """Whether a cell belongs to the right: a number, a number in text, or nothing."""
    return value is None or isinstance(value, int | float) or bool(NUMBER.fullmatch(str(value)))


def shown(value: Any, widest: int) -> str:
    if value is None:
        return ""
    if isinstance(value, float):
        return f"{value:.4g}"
    text = " ".join(str(value).split())
    return text if len(text) <= widest else text[: widest - 1] + "…"
