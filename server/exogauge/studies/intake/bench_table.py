"""The table of a force-length test of a bare band (columns length_m, force_n), with the place of every fault."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterator, Sequence

from exogauge.devices.bench import bench_line
from exogauge.devices.device import BenchTest
from exogauge.errors import BadStudy, Fault
from exogauge.logs.channels import shorten
from exogauge.studies.intake.bundle import Bundle
from exogauge.studies.intake.yaml_file import suggestion

LENGTH, FORCE = "length_m", "force_n"
MAX_BYTES = 2_000_000
MAX_FAULTS = 20
LONGEST_M = 20.0  # a longer band is a table in millimetres
STRONGEST_N = 1e5
PUSH_SHARE = 0.05  # of the largest force: a zero error of the force gauge; below, a sign


def read_bench(bundle: Bundle, file: str, is_truth: bool, *, named_in: str, column: str, row: int | None) -> BenchTest:
    """named_in, column, row: where the table's name is written. Raises BadStudy with every fault of the table."""
    data = bundle.read(file, limit=MAX_BYTES, named_in=named_in, column=column, row=row)
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as problem:
        line = data[: problem.start].count(b"\n")
        raise BadStudy(Fault("the file is not UTF-8 text", "not_utf8", "Save it as CSV, UTF-8.", file, line)) from None
    lines = [line for line in text.splitlines() if line.strip()]
    if not lines:
        raise BadStudy(Fault("the table is empty", "empty_file", f"It needs columns {LENGTH}, {FORCE}.", file))
    delimiter = next((mark for mark in (";", "\t") if mark in lines[0]), ",")
    try:
        cells = list(csv.reader(io.StringIO("\n".join(lines)), delimiter=delimiter, skipinitialspace=True))
    except csv.Error as problem:
        raise BadStudy(Fault(f"not readable as CSV: {problem}", "not_csv", "Save it as CSV.", file)) from None
    lengths, forces = _columns(cells, delimiter, file)
    bench = BenchTest(tuple(lengths), tuple(forces), is_truth)
    faults = list(_cell_faults(bench, file)) or list(_line_faults(bench, file))
    if faults:
        raise BadStudy(faults[:MAX_FAULTS])
    return bench


def _columns(cells: Sequence[Sequence[str]], delimiter: str, file: str) -> tuple[list[float], list[float]]:
    header = [shorten(cell.strip()) for cell in cells[0]]
    missing = [
        Fault("the table lacks a column", "missing_column", _column_advice(name, header), file, 0, name)
        for name in (LENGTH, FORCE)
        if header.count(name) != 1
    ]
    if missing:
        raise BadStudy(missing)
    values: dict[str, list[float]] = {}
    faults = list[Fault]()
    for name in (LENGTH, FORCE):
        k = header.index(name)
        values[name] = []
        for row, line in enumerate(cells[1:], start=1):
            cell = line[k].strip() if k < len(line) else ""
            number = _number(cell, delimiter)
            if not math.isfinite(number):
                advice = "Correct the cell or remove the row."
                if delimiter == "," and ("," in cell or len(line) > len(header)):
                    advice = "Numbers with a decimal comma need ';' or tab between the columns."
                detail = "the cell is not a finite number"
                faults.append(Fault(detail, "not_a_number", advice, file, row, name, shorten(cell)))
            values[name].append(number)
    if faults:
        raise BadStudy(faults[:MAX_FAULTS])
    return values[LENGTH], values[FORCE]


def _column_advice(name: str, header: Sequence[str]) -> str:
    meaning = "length of the band [m]" if name == LENGTH else "force it pulls with [N], positive"
    return f"It holds the {meaning}. {suggestion(name, header).replace('Did you mean', 'Is it')}".strip()


def _number(cell: str, delimiter: str) -> float:
    try:
        return float(cell.replace(",", ".") if delimiter != "," else cell)
    except ValueError:
        return math.nan


def _cell_faults(bench: BenchTest, file: str) -> Iterator[Fault]:
    largest = max(bench.force, default=0.0)
    if largest <= 0.0:
        yield Fault("the table holds no pull", "no_pull", "Pull counts as positive [N].", file, column=FORCE)
    for row, (length, force) in enumerate(zip(bench.length, bench.force, strict=True), start=1):
        if not 0.0 < length <= LONGEST_M:
            detail = "a band's length is above 0 and a few metres at most"
            yield Fault(detail, "odd_length", "Lengths are in metres.", file, row, LENGTH, f"{length:g}")
        if abs(force) > STRONGEST_N:
            detail = f"no band pulls with more than {STRONGEST_N:g} N"
            yield Fault(detail, "odd_force", "Forces are in newtons.", file, row, FORCE, f"{force:g}")
        elif force < -PUSH_SHARE * abs(largest):
            detail = "a band cannot push"
            yield Fault(detail, "negative_force", "Pull counts as positive [N].", file, row, FORCE, f"{force:g}")


def _line_faults(bench: BenchTest, file: str) -> Iterator[Fault]:
    """What the estimates take from the test: a straight line through its taut part."""
    try:
        line = bench_line(bench)
    except ValueError:
        detail, advice = (
            "the band pulls at fewer than two lengths",
            "Ten lengths from slack to the longest in use are good.",
        )
        yield Fault(detail, "too_few_points", advice, file)
        return
    if line.stiffness <= 0.0:
        detail, advice = "the force does not grow with the length", "Are the columns swapped?"
        yield Fault(detail, "force_falls", advice, file, column=FORCE)
    elif line.natural_length <= 0.0:
        detail = f"the straight line through it ends at a natural length of {line.natural_length:.3g} m"
        advice = "Lengths are those of the whole band [m], not of its stretch."
        yield Fault(detail, "odd_natural_length", advice, file, column=LENGTH)
