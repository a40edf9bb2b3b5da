"""What the first lines of a text table tell: its delimiter, its decimal sign, where the names of columns stand."""

from __future__ import annotations

import csv
import re
import zlib
from collections.abc import Sequence

import pyarrow as pa
import pyarrow.compute as pc

from exogauge.errors import BadLog, Fault
from exogauge.logs.channels import shorten

ARROW_FAILURES = (pa.ArrowException, OSError, ValueError, EOFError, zlib.error)
_QUOTED = re.compile(r'"[^"]*"')
_USUAL_NUMBER = {sign: re.compile(rf"[+-]?[0-9]+({re.escape(sign)}[0-9]+)?([eE][+-]?[0-9]+)?") for sign in ".,"}


def delimiter_of(line: str) -> str:
    bare = _QUOTED.sub("", line)
    for mark in (";", "\t", ","):
        if mark in bare:
            return mark
    return " " if re.search(r"\S\s+\S", bare.strip()) else ","


def decimal_of(lines: Sequence[str], delimiter: str, file: str) -> str:
    """Decimal sign of a table whose delimiter leaves the comma free."""
    if delimiter == ",":
        return "."
    sample = [cell for line in lines[:200] for cell in line.split(None if delimiter == " " else delimiter)]
    comma = next((cell for cell in sample if re.fullmatch(r'\s*"?[+-]?\d*,\d+([eE][+-]?\d+)?"?\s*', cell)), None)
    point = next((cell for cell in sample if re.fullmatch(r'\s*"?[+-]?\d*\.\d+([eE][+-]?\d+)?"?\s*', cell)), None)
    if comma and point:
        raise BadLog(
            Fault(
                f"numbers are written with a decimal comma ({comma.strip()}) and with a point ({point.strip()})",
                "two_decimal_signs",
                "Export with one of them, or give `decimal` in the mapping.",
                file=file,
            )
        )
    return "," if comma else "."


def refuse_lines_before(lines: Sequence[str], file: str) -> None:
    """Lines of something else before the names of columns: the names' cells are as many as those of rows below."""
    looked_at = 50  # lines: no preface is longer
    first = next((k for k in range(min(looked_at, len(lines))) if _begins(lines[k : k + looked_at])), 0)
    if first:
        raise BadLog(
            Fault(
                f"the table begins in line {first + 1}, after {first} line{'s' if first > 1 else ''} of something else",
                "lines_before",
                f"Say `layout: {{skip_lines: {first}}}` in a mapping, or remove {'them' if first > 1 else 'it'}.",
                file=file,
                row=0,
                value=str(first),
            )
        )


def _begins(lines: Sequence[str]) -> bool:
    """Whether the first is a header: no number, several cells, and as many in the rows below, which hold numbers."""
    mark = delimiter_of(lines[0])
    names, *rows = (_split(line, mark) for line in lines if line.strip()) if lines[0].strip() else ([],)
    few = 2  # rows: one may be as long as a line of something else by chance
    rows = rows[:-1] if len(rows) > few else rows  # the last may be cut off
    return (
        len(names) > 1
        and len(rows) >= few
        and all(len(row) == len(names) for row in rows)
        and not any(_has_digits_alone(cell) for cell in names)
        and any(_has_digits_alone(cell) for cell in rows[-1])
    )


def _split(line: str, mark: str) -> list[str]:
    return line.split() if mark == " " else next(csv.reader([line], delimiter=mark))


def _has_digits_alone(cell: str) -> bool:
    return any(_USUAL_NUMBER[sign].fullmatch(cell.strip()) for sign in ".,")


def refuse_numeric_header(cells: Sequence[str], file: str) -> None:
    if all(is_number(cell, ".") for cell in cells):
        raise BadLog(
            Fault(
                "the first line holds numbers, not column names",
                "no_header",
                "Add a header line, or read the file through a mapping with `header: false`.",
                file=file,
                row=0,
                value=shorten(", ".join(cells)),
            )
        )


def is_number(text: str, decimal: str) -> bool:
    """As pyarrow reads it (Python would also take `1_0` and other scripts' digits)."""
    if _USUAL_NUMBER[decimal].fullmatch(text):
        return True
    try:
        pc.cast(pa.scalar(text.replace(decimal, ".") if decimal == "," else text), pa.float64())
    except ARROW_FAILURES:
        return False
    return True
