"""What is written to a terminal: a progress bar on stderr, tables on stdout."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from tqdm import tqdm

SHAPE = "{desc} {percentage:3.0f}%|{bar}| {elapsed}{postfix}"


@contextmanager
def bar(name: str) -> Iterator[Callable[[float, str], None]]:
    """Yields progress(fraction, phrase): what every long computation calls."""
    with tqdm(total=1.0, bar_format=SHAPE, desc=name) as drawn:

        def progress(fraction: float, phrase: str) -> None:
            drawn.n = min(max(fraction, 0.0), 1.0)
            drawn.set_postfix_str(phrase, refresh=True)

        yield progress


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
