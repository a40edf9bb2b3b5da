"""A comparison as a table to take away: CSV with every digit, LaTeX with as many as a number deserves."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from exogauge.studies.csv_table import csv_table
from exogauge.studies.words.rounding import significant, with_std

Table = Literal["support", "stiffness"]
KEYS: Mapping[Table, tuple[str, ...]] = {
    "support": ("device", "motion", "joint", "approach"),
    "stiffness": ("device", "approach", "band"),
}
PLAIN: Mapping[Table, tuple[str, ...]] = {
    "support": ("unit", "rmse", "rmse_steady", "spread", "motion_equality"),
    "stiffness": ("group", "truth_n_per_m", "error_percent", "identifiable"),
}
WITH_STD: Mapping[Table, tuple[str, ...]] = {
    "support": ("peak", "mean", "integral"),
    "stiffness": ("stiffness_n_per_m", "natural_length_m"),
}
SHOWN: Mapping[Table, tuple[tuple[str, str], ...]] = {  # in LaTeX: quantity, heading
    "support": (("rmse", "RMSE"), ("peak", "peak"), ("mean", "mean")),
    "stiffness": (("stiffness_n_per_m", "N/m"), ("error_percent", r"error \%")),
}
ESCAPED = {"\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}"} | {
    sign: f"\\{sign}" for sign in "&%$#_{}"
}
RAISED = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")


def as_csv(comparison: Mapping[str, Any], jobs: Sequence[Mapping[str, Any]], table: Table) -> bytes:
    """One row per row of the comparison and job. jobs: {id, name, verdict} in the order of the cells."""
    columns = (
        *("job", "study", "discrepancy"),
        *KEYS[table],
        *PLAIN[table],
        *(name for quantity in WITH_STD[table] for name in (quantity, f"{quantity}_std")),
    )

    def row(entry: Mapping[str, Any], job: Mapping[str, Any], cell: Mapping[str, Any]) -> list[Any]:
        numbers = [cell.get(quantity) or {} for quantity in WITH_STD[table]]
        return [
            *(job["id"], job["name"], job["verdict"]),
            *(entry[key] for key in KEYS[table]),
            *(cell.get(name) for name in PLAIN[table]),
            *(value for number in numbers for value in (number.get("value"), number.get("std"))),
        ]

    rows = (
        row(entry, job, cell)
        for entry in comparison[table]
        for job, cell in zip(jobs, entry["cells"], strict=True)
        if cell is not None
    )
    return csv_table(columns, rows)


def as_latex(comparison: Mapping[str, Any], jobs: Sequence[Mapping[str, Any]], table: Table) -> bytes:
    """A `tabular` that needs no package: one column group per job."""
    keys, shown = KEYS[table], SHOWN[table]
    heads = " & ".join(f"\\multicolumn{{{len(shown)}}}{{c}}{{{escaped(str(job['name']))}}}" for job in jobs)
    names = " & ".join([*keys, *(heading for _ in jobs for _, heading in shown)])
    lines = [
        f"\\begin{{tabular}}{{{'l' * len(keys)}{'r' * (len(shown) * len(jobs))}}}",
        "\\hline",
        f"{' & ' * (len(keys) - 1)} & {heads} \\\\",
        f"{names} \\\\",
        "\\hline",
    ]
    for entry in comparison[table]:
        cells = (_cell(cell, quantity) for cell in entry["cells"] for quantity, _ in shown)
        lines.append(" & ".join([*(escaped(str(entry[key])) for key in keys), *cells]) + r" \\")
    return "\n".join([*lines, "\\hline", "\\end{tabular}", ""]).encode()


def escaped(text: str) -> str:
    """Text that LaTeX prints and does not obey."""
    return "".join(ESCAPED.get(sign, sign if sign.isprintable() else " ") for sign in text)


def _cell(cell: Mapping[str, Any] | None, quantity: str) -> str:
    number = None if cell is None else cell.get(quantity)
    if number is None:
        return "--"
    if not isinstance(number, Mapping):
        return _math(significant(float(number)))
    if number.get("value") is None:
        return "--"
    value, std = with_std(float(number["value"]), float(number["std"] or 0.0))
    return _math(value) if std == "–" else _math(f"{value} \\pm {std}")


def _math(text: str) -> str:
    plain = re.sub(r"·10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)", lambda power: f" \\cdot 10^{{{power[1].translate(RAISED)}}}", text)
    return "--" if text == "–" else f"${plain.replace(chr(0x2212), '-')}$"
