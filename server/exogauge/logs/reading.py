"""Bytes to a Log: tables in the contract's own columns, refused with every fault named."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from exogauge.criteria.logs import LOGS
from exogauge.errors import BadLog, Fault
from exogauge.logs.bursts import evened
from exogauge.logs.channels import parse_channel, shorten, suggestion
from exogauge.logs.limits import rows_outside
from exogauge.logs.model import Array, Log
from exogauge.logs.open_table import open_table
from exogauge.logs.tables import as_vector, read_names


def read_log(
    path: Path, name: str, rows: tuple[int, int] | None = None, *, file: str | None = None, allow_gaps: bool = False,
    left_out: str | None = None,
) -> Log:  # fmt: skip
    """The log in a CSV or Parquet table of contract columns.

    rows: (start, stop) of the data rows to keep, from 0, stop not included; what is wrong with others does not
    matter. file: the name that faults carry.
    allow_gaps: keep NaN (for the doctor, who reports them) instead of refusing.
    left_out: what columns begin with that are passed over.
    Raises BadLog with up to 20 faults, TooLarge.
    """
    file = file or path.name
    table = open_table(path, file, rows=rows)
    names = tuple(each for each in read_names(table) if left_out is None or not each.startswith(left_out))
    _check_names(names, file)
    columns = {
        column: np.asarray(as_vector(values, file, column), np.float64) for column, values in table.read(names).items()
    }
    _check_lengths(columns, file)
    left = None if table.part else rows
    columns = {column: cut(values, left, file) for column, values in columns.items()}
    first, notes = rows[0] if rows else 0, table.notes
    if np.isfinite(columns["t"]).all():
        columns["t"], note = evened(columns["t"])
        notes = (*notes, *([note] if note else []))
    faults = time_faults(columns["t"], file, "t", first)
    for column, values in columns.items():
        if column != "t":
            faults += value_faults(values, file, column, allow_gaps=allow_gaps, first=first)
    refuse(faults)
    time = columns.pop("t")
    return Log(name, time, columns, notes=notes)


def _check_names(names: tuple[str, ...], file: str) -> None:
    faults = list[Fault]()
    for name in names:
        try:
            parse_channel(name, file)
        except BadLog as bad:
            faults += bad.faults
    if "t" not in names:
        times = [name for name in names if suggestion(name) == "Did you mean 't'?"]
        advice = (
            f"Rename {shorten(times[0])!r} to 't' [s]."
            if times
            else "Give 't' in seconds, or use a mapping with rate_hz."
        )
        faults.insert(0, Fault("there is no time column 't'", "no_time", advice, file, 0, "t"))
    elif len(names) == 1:
        faults.append(Fault("there is no channel beside 't'", "no_channels", "", file, 0))
    refuse(faults)


def _check_lengths(columns: dict[str, Array], file: str) -> None:
    lengths = {values.size for values in columns.values()}
    if len(lengths) > 1:
        size = columns["t"].size
        refuse(
            [
                Fault(f"{values.size} values, but {size} times", "length_differs", "", file, column=shorten(column))
                for column, values in columns.items()
                if values.size != size
            ]
        )


def cut(values: Array, rows: tuple[int, int] | None, file: str) -> Array:
    """The chosen rows; too few rows, or rows that are not there, are faults."""
    if rows is not None:
        start, stop = rows
        if not 0 <= start < stop <= values.size:
            raise BadLog(rows_outside(rows, values.size, file))
        values = values[start:stop]
    if values.size < LOGS.fewest_samples:
        raise BadLog(
            Fault(
                f"{values.size} samples are too few; at least {LOGS.fewest_samples} are needed",
                "too_few_samples",
                "Check that the recording is complete.",
                file,
                value=str(values.size),
            )
        )
    return values


def time_faults(time: Array, file: str, column: str, first: int = 0) -> list[Fault]:
    """time: (T,) in any unit. Missing values, and the first place where it does not increase. first: row before it."""
    missing = value_faults(time, file, column, allow_gaps=False, first=first)
    if missing:
        return missing
    steps = np.diff(time)
    wrong = np.flatnonzero(steps <= 0)
    if not wrong.size:
        return []
    at = int(wrong[0])
    times = "" if wrong.size == 1 else f" (and {wrong.size - 1} more times)"
    detail = f"time repeats {time[at + 1]!s}{times}" if steps[at] == 0 else f"time goes back from {time[at]!s}{times}"
    advice = "Time must increase from row to row: sort, remove repeated rows, or split where the clock was reset."
    return [Fault(detail, "time_not_increasing", advice, file, first + at + 2, shorten(column), str(time[at + 1]))]


def value_faults(values: Array, file: str, column: str, *, allow_gaps: bool, first: int = 0) -> list[Fault]:
    """Missing (NaN) values of one column, and those that no reading can be, infinite ones too; each named by its first
    row and how many more there are."""
    beyond = ~(np.abs(values) <= LOGS.largest)
    if not beyond.any():
        return []
    beyond &= ~np.isnan(values)
    faults = list[Fault]()
    checks = [(beyond, "the value is infinite or beyond any reading", "not_finite", "Correct or remove it.")]
    if not allow_gaps:
        advice = "Remove these rows or split the log there; nothing is filled in silence."
        checks.insert(0, (np.isnan(values), "the value is missing", "missing_value", advice))
    for found, detail, rule, advice in checks:
        places = np.flatnonzero(found)
        if places.size:
            more = "" if places.size == 1 else f", like {places.size - 1} more in this column"
            at = int(places[0])
            faults.append(
                Fault(f"{detail}{more}", rule, advice, file, first + at + 1, shorten(column), str(values[at]))
            )
    return faults


def refuse(faults: list[Fault]) -> None:
    """Raise what was collected, at most `LOGS.most_faults` of it."""
    if len(faults) > LOGS.most_faults:
        rest = len(faults) - LOGS.most_faults + 1
        faults = [
            *faults[: LOGS.most_faults - 1],
            Fault(f"{rest} more faults are not listed", "more_faults", "", faults[0].file),
        ]
    if faults:
        raise BadLog(faults)
