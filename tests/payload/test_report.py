"""The report tells every number of results.json; the sheet is one sheet, whatever was found and however it is named."""

from __future__ import annotations

import io
import re
from pathlib import Path

import numpy as np
import pytest
from pypdf import PdfReader
from tests.payload.test_exports import found

from exogauge.payload.report import write_report
from exogauge.payload.schema import ContactResults, FigureResults, PayloadResults, RemainderResults
from exogauge.studies.words.rounding import with_std


def texts(results: PayloadResults, out: Path) -> tuple[str, str, str]:
    """Words of the report, of the sheet, and of its print."""
    write_report(results, out)
    pdf = PdfReader(io.BytesIO((out / "summary.pdf").read_bytes()))
    assert len(pdf.pages) == 1
    words = [re.sub(r"<[^>]+>|\s+", " ", (out / f"{name}.html").read_text()) for name in ("report", "summary")]
    return words[0], words[1], pdf.pages[0].extract_text()


def test_every_value_stands_in_the_report_with_its_doubt(tmp_path: Path) -> None:
    results = found(covariance=np.diag(np.geomspace(1e-8, 1e-3, 16)))
    assert results.dynamic is not None
    report, sheet, printed = texts(results, tmp_path)
    for each in results.dynamic.values:
        told = " ± ".join(with_std(each.value, each.std))
        assert told in report, each.name
        if not each.name.endswith("0"):
            assert told in sheet, each.name
            assert told in printed, each.name
    assert "axes and origin of the sensor (ft)" in report


def test_what_is_not_decided_is_said_first(tmp_path: Path) -> None:
    report, sheet, _ = texts(found(identified=False), tmp_path)
    for text in (report, sheet):
        assert "Not decided by these data: Ixx, Ixy, Iyy, Ixz, Iyz, Izz." in text


@pytest.mark.slow
@pytest.mark.parametrize("name", ["<script>alert(1)</script>", "長" * 300, "a\u202eb\nc"])
def test_the_sheet_is_one_sheet_with_any_name_and_any_number_of_logs(name: str, tmp_path: Path) -> None:
    figures = FigureResults(first=(1, 1), mean=(2, 2), std=(3, 3), axes=[[1.0] * 6] * 3, rms=[1.0] * 6, most=[1.0] * 6)
    left = RemainderResults(**figures.model_dump(), after_zero=figures, zero_helps=1.0)
    touch = ContactResults(start_s=1.0, end_s=2.0, force_n=(1.0, 2.0, 3.0))
    results = found(name=name).model_copy(
        update={
            "tests": {f"{name} {k}": {"all": left, "level": left, "static": left} for k in range(30)},
            "contacts": {name: [touch] * 50}, "contact_threshold_n": {name: 1.0}, "warnings": [name * 5] * 40,
        }
    )  # fmt: skip
    report, sheet, _ = texts(results, tmp_path)
    assert "26 more logs" in sheet
    assert "44 more" in sheet
    assert "more logs" not in report
    assert "<script>" not in (tmp_path / "report.html").read_text()


def test_synthetic_data_are_called_so(tmp_path: Path) -> None:
    assert "made by a simulator" in texts(found(name="SYNTHETIC door"), tmp_path)[0]
    assert "made by a simulator" not in texts(found(name="Door"), tmp_path)[0]
