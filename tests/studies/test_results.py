"""results.json, series, tables and report say the same, exactly, and belong together."""

from __future__ import annotations

import csv
import dataclasses
import html
import io
import json
import math
import re
import shutil
from collections.abc import Sequence
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from exogauge.errors import PhysicallyImpossible
from exogauge.identification.result import Identification
from exogauge.studies import evaluate as module
from exogauge.studies.evaluate import write
from exogauge.studies.intake.open import Study, open_study
from exogauge.studies.report.figures import thin_out
from exogauge.studies.report.report_tables import combination
from exogauge.studies.report.write import render_report
from exogauge.studies.results.document import Evaluation, results
from exogauge.studies.words.rounding import significant, with_std

FINDING = {
    "log": "id_1", "severity": "warning", "channel": "q.r_elbow", "rule": "dead", "detail": "dead <b>for</b> 0.4 s",
    "advice": "Check the cable.", "row": 12, "value": 0.4,
}  # fmt: skip


def whole(study: Study, found: Identification, findings: Sequence[dict] = ()) -> Evaluation:
    """The evaluation of a study without a device."""
    return Evaluation(
        study.name, study.robot, study.settings, study.steps, study.bundle.inputs, findings, found, [], {}
    )


@pytest.fixture(scope="module")
def out(pristine: Path, identification: Identification, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The results of one evaluation; not to be changed."""
    written = tmp_path_factory.mktemp("results") / "out"
    with open_study(pristine) as study:
        write(study, whole(study, identification, [FINDING]), written)
    return written


def content(out: Path) -> dict:
    return json.loads((out / "results.json").read_text(), parse_constant=pytest.fail)


@pytest.mark.slow
def test_results_hold_the_contract(out: Path, identification: Identification) -> None:
    found = content(out)
    assert found["version"] == 1
    said = found["identification"]
    words = [each.pop("channel_words") for each in said["validation"]]
    assert words[:6] == [f"base {what} {axis}" for what in ("force", "moment") for axis in "xyz"]
    assert said["validation"] == [dataclasses.asdict(fit) for fit in identification.validation]
    for entry, parameter in zip(said["parameters"], identification.parameters, strict=True):
        assert entry["name"] == parameter.name
        assert entry["value"] == float(parameter.value)
        assert {"value", "std", "unit", "prior", "identifiable"} <= entry.keys()
    assert [entry["joint"] for entry in said["joints"]] == ["torso_yaw", "torso_pitch", "r_elbow"]
    assert said["joints"][1]["k_T"] == {
        "value": 5.7312, "std": 0.0213, "unit": "N·m/A", "prior": 4.7312, "identifiable": True,
    }  # fmt: skip
    assert {"k_T", "k_d", "tau_c", "tau_s", "tau_o"} <= said["joints"][0].keys()
    assert {each["file"] for each in found["inputs"]} >= {"study.yaml", "robot.yaml", "robot.urdf"}
    assert all((out / name).is_file() for name in found["files"].values())


def test_what_stands_beside_what_is_told_in_the_same_words_everywhere(
    pristine: Path, identification: Identification
) -> None:
    """Steady motion and all samples: two columns of one table, in results.json for the page and in the report."""
    fits = tuple(dataclasses.replace(fit, rmse_moving=0.123, rmse_at_rest=0.456) for fit in identification.validation)
    with open_study(pristine) as study:
        evaluation = whole(study, dataclasses.replace(identification, validation=fits))
    said = results(evaluation)
    assert {fit["rmse_moving"] for fit in said["identification"]["validation"]} == {0.123}
    assert said["reading"]["steady"] in html.unescape(render_report(evaluation))


def test_series_are_the_predictions(out: Path, identification: Identification) -> None:
    prediction = identification.predictions[1]
    table = pq.read_table(out / "series" / "val_1.parquet")
    np.testing.assert_array_equal(table["t"], prediction.time)
    for part in ("measured", "predicted", "predicted_prior"):
        for channel, values in getattr(prediction.channels(), part).items():
            np.testing.assert_array_equal(table[f"{part}.{channel}"], values)
    assert table.schema.field("measured.base.my").metadata[b"unit"].decode() == "N·m"
    meta = pq.ParquetFile(out / "series" / "val_1.parquet").metadata
    assert meta.row_group(0).column(0).compression == "ZSTD"


def test_a_reader_of_the_series_finds_the_stated_rmse(out: Path) -> None:
    table = pq.read_table(out / "series" / "val_1.parquet")
    for fit in content(out)["identification"]["validation"]:
        if fit["log"] == "val_1":
            error = np.asarray(table[f"measured.{fit['channel']}"]) - np.asarray(table[f"predicted.{fit['channel']}"])
            assert math.sqrt(np.mean(error**2)) == pytest.approx(fit["rmse_identified"], rel=1e-12)


def test_tables_hold_every_row(out: Path, identification: Identification) -> None:
    parameters = list(csv.DictReader(io.StringIO((out / "parameters.csv").read_text())))
    assert [float(row["value"]) for row in parameters] == [float(each.value) for each in identification.parameters]
    validation = list(csv.DictReader(io.StringIO((out / "validation.csv").read_text())))
    assert [row["channel"] for row in validation] == [fit.channel for fit in identification.validation]
    assert {row["held_out"] for row in validation} == {"true", "false"}


def test_summary_pools_the_held_out_base_moment(out: Path, identification: Identification) -> None:
    (summary,) = (each for each in content(out)["identification"]["summary"] if each["kind"] == "base_moment")
    fits = [fit for fit in identification.validation if fit.held_out and fit.channel.startswith("base.m")]
    assert summary["logs"] == ["val_1"]
    assert summary["rmse_prior"] == pytest.approx(math.sqrt(np.mean([fit.rmse_prior**2 for fit in fits])))


@pytest.mark.slow
def test_not_a_number_becomes_null(folder: Path, identification: Identification, tmp_path: Path) -> None:
    odd = dataclasses.replace(identification.parameters[0], std=math.inf, prior_std=math.nan)
    found = dataclasses.replace(identification, parameters=(odd, *identification.parameters[1:]), condition=math.inf)
    with open_study(folder) as study:
        write(study, whole(study, found, []), tmp_path / "out")
    said = content(tmp_path / "out")["identification"]
    assert said["condition"] is None
    assert said["parameters"][0]["std"] is None


@pytest.mark.slow
def test_the_same_inputs_give_the_same_bytes(
    out: Path, folder: Path, identification: Identification, tmp_path: Path
) -> None:
    again = Path(shutil.copytree(out, tmp_path / "again"))
    (again / "series" / "stale.parquet").write_bytes(b"of an earlier run")
    with open_study(folder) as study:
        write(study, whole(study, identification, [FINDING]), again)
    first, second = ({path.relative_to(root): path.read_bytes() for path in root.rglob("*.*")} for root in (out, again))
    assert first == second


@pytest.mark.slow
def test_a_failed_run_never_looks_whole(
    out: Path, folder: Path, identification: Identification, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = Path(shutil.copytree(out, tmp_path / "again"))
    (out / "notes.txt").write_text("mine")

    def fail(source: Path, target: Path) -> None:
        raise OSError(28, "no space")

    monkeypatch.setattr(module.os, "replace", fail)
    with open_study(folder) as study, pytest.raises(OSError, match="no space"):
        write(study, whole(study, identification, []), out)
    assert sorted(path.name for path in out.iterdir()) == ["notes.txt"]


@pytest.mark.slow
def test_an_impossible_link_is_a_warning_not_a_urdf(
    folder: Path, identification: Identification, tmp_path: Path
) -> None:
    phi = identification.phi.copy()
    phi[1, 0] = -1.0
    with open_study(folder) as study:
        with pytest.raises(PhysicallyImpossible):
            module.export_urdf(study.urdf, study.robot.tree, phi)
        write(study, whole(study, dataclasses.replace(identification, phi=phi), []), tmp_path / "out")
    assert not (tmp_path / "out" / "identified.urdf").exists()
    assert "chest_0" in content(tmp_path / "out")["warnings"][0]


class Page(HTMLParser):
    """Open tags, ids, addresses, and the text."""

    VOID = frozenset({"meta", "br", "hr", "img", "link", "input"})

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.ids: list[str] = []
        self.addresses: list[str] = []
        self.tags: list[str] = []
        self.text = ""
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        for name, value in attrs:
            if name == "id":
                self.ids.append(value or "")
            if name in ("href", "src", "xlink:href", "action", "srcset"):
                self.addresses.append(value or "")
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.handle_starttag(tag, attrs)
        if tag not in self.VOID:
            self.open.pop()

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text += data


def test_the_report_is_whole_and_asks_nothing_of_the_world(out: Path) -> None:
    text = (out / "report.html").read_text()
    page = Page(text)
    assert page.open == []
    assert len(page.ids) == len(set(page.ids))
    assert all(address.startswith("#") for address in page.addresses)
    assert {address[1:] for address in page.addresses} <= set(page.ids)
    assert not {"script", "iframe", "object", "link", "img"} & set(page.tags)
    assert not re.search(r"url\((?!#)|@import|@font-face", text)
    assert page.tags.count("caption") == page.tags.count("table")
    assert page.tags.count("h1") == 1


def test_the_report_shows_the_numbers(out: Path, identification: Identification) -> None:
    page = Page((out / "report.html").read_text())
    for fit in identification.validation:
        assert significant(fit.rmse_prior) in page.text
        assert significant(fit.rmse_identified) in page.text
    assert "5.731 ± 0.021" in re.sub(r"\s+", " ", page.text)
    assert "Synthetic data" in page.text
    assert "r_arm: all ten" in page.text
    assert "dead <b>for</b> 0.4 s" in page.text  # shown as text: markup from outside stays text


@pytest.mark.slow
def test_names_that_mean_something_elsewhere_are_shown_as_text(
    folder: Path, identification: Identification, tmp_path: Path
) -> None:
    prediction = identification.predictions[1]
    renamed = dataclasses.replace(prediction, log="<i>$x_1$&")
    fits = tuple(
        dataclasses.replace(fit, log=renamed.log) if fit.log == prediction.log else fit
        for fit in identification.validation
    )
    found = dataclasses.replace(identification, predictions=(renamed,), validation=fits)
    with open_study(folder) as study:
        write(study, whole(study, found, []), tmp_path / "out")
    page = Page((tmp_path / "out" / "report.html").read_text())
    assert page.open == []
    assert "<i>$x_1$&" in page.text


@pytest.mark.slow
def test_without_held_out_logs_the_report_says_so(folder: Path, identification: Identification, tmp_path: Path) -> None:
    found = dataclasses.replace(
        identification,
        predictions=identification.predictions[:1],
        validation=tuple(fit for fit in identification.validation if not fit.held_out),
    )
    with open_study(folder) as study:
        write(study, whole(study, found, []), tmp_path / "out")
    assert "No log was held out" in (tmp_path / "out" / "report.html").read_text()


@pytest.mark.parametrize(
    ("value", "std", "shown"),
    [
        (5.0316, 0.0412, ("5.032", "0.041")),
        (5.0316, 0.0998, ("5.03", "0.10")),
        (-0.2, 0.0213, ("−0.200", "0.021")),
        (1234.5, 87.0, ("1234", "87")),
        (123456.0, 870.0, ("123460", "870")),
        (3.2e-5, 4.1e-7, ("3.200·10⁻⁵", "4.1·10⁻⁷")),
        (5.0, 0.0, ("5.000", "–")),
        (-1e-9, 0.01, ("0.000", "0.010")),
    ],
)
def test_the_std_decides_the_digits(value: float, std: float, shown: tuple[str, str]) -> None:
    assert with_std(value, std) == shown


@pytest.mark.parametrize(
    ("value", "shown"), [(3.568, "3.57"), (0.0, "0"), (9.999, "10.0"), (123456.0, "1.23·10⁵"), (math.nan, "–")]
)
def test_significant_digits(value: float, shown: str) -> None:
    assert significant(value) == shown


def test_drawing_keeps_every_peak() -> None:
    time = np.arange(100_000.0)
    values = np.sin(time / 3000.0)
    values[[777, 50_001]] = [9.0, -9.0]
    drawn_time, drawn = thin_out(time, values)
    assert drawn.size <= 1000
    assert drawn.max() == 9.0
    assert drawn.min() == -9.0
    assert (np.diff(drawn_time) > 0).all()


def test_a_combination_reads_like_a_sum() -> None:
    assert combination({"mx[a]": 1.0, "m[b]": -0.31}) == "mx[a] − 0.310 m[b]"
