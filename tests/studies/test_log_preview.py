"""A column of a foreign log that holds no numbers: what to do is said by what stands in it."""

from __future__ import annotations

from pathlib import Path

import pytest

from exogauge.studies.import_log.column_words import Wearer
from exogauge.studies.import_log.log_preview import preview


@pytest.mark.parametrize(
    ("cell", "said"),
    [
        ("[rad]", "take the line of units out"),
        ("(N·m)", "take the line of units out"),
        ("deg/s", "take the line of units out"),
        ('"[0.1, -0.2]"', "each value of the list into a column of its own"),
        ("\"array('d', [0.1, 0.2])\"", "each value of the list into a column of its own"),
        ("2026-03-01 12:00:00.5", "in seconds"),
        ("12:00:01.250", "in seconds"),
        ("idle", "list it under `ignore`, or correct the cell"),
    ],
)
def test_text_in_a_column_is_told_by_what_it_looks_like(tmp_path: Path, cell: str, said: str) -> None:
    path = tmp_path / "log.csv"
    path.write_text("time,a\n" + "".join(f"{k / 100},{cell}\n" for k in range(5)))
    (found,) = (each for each in preview(path, path.name, Wearer())["columns"] if each["name"] == "a")
    assert said in found["advice"]
