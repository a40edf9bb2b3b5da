"""The words by which a laboratory is asked for."""

from __future__ import annotations

from pathlib import Path

import pytest

from exogauge.cli import main
from exogauge.errors import BadInput
from exogauge.synthetic.disturbances import CATALOGUE, IDEAL, LAB, TOGETHER, chosen, table
from exogauge.synthetic.tolerances import TOLERANCES, declared

DOCUMENT = Path(__file__).parents[2] / "docs" / "sample.md"


def test_a_good_laboratory_is_the_default_and_ideal_is_without_any() -> None:
    assert chosen() == LAB
    assert chosen("ideal") == IDEAL == {}
    assert chosen("lab", left_out=list(LAB)) == {}


@pytest.mark.parametrize(
    ("word", "size"),
    [
        ("feet_gain", 0.03),
        ("feet_gain=0.02", 0.02),
        ("feet_gain=-3%", -0.03),
        ("runs_differ=4mrad", 0.004),
        ("imu_mounting=1deg", 0.0174533),
        ("via_points = 7 mm", 0.007),
        ("clock_jitter=20us", 2e-5),
        ("feet_drift=2N", 2.0),
        ("encoder_steps=1.5e-5", 1.5e-5),
    ],
)
def test_a_size_is_a_number_in_si_or_with_its_unit(word: str, size: float) -> None:
    (found,) = chosen("ideal", [word]).values()
    assert found == pytest.approx(size, rel=1e-5)


def test_one_is_added_resized_or_left_out_and_the_others_stay() -> None:
    sizes = chosen("lab", ["via_points=1mm", "load_friction"], ["donning"])
    expected = {**LAB, "via_points": 1e-3, "load_friction": 0.05}
    del expected["donning"]
    assert sizes == pytest.approx(expected)
    assert chosen("ideal", ["all_smooth"]).keys() == set(TOGETHER["all_smooth"])


@pytest.mark.parametrize(
    ("realism", "added", "left_out", "rule"),
    [
        ("real", [], [], "unknown_realism"),
        ("lab", ["gremlins"], [], "unknown_disturbance"),
        ("lab", [], ["gremlins"], "unknown_disturbance"),
        ("lab", ["via_points=5N"], [], "disturbance_size"),
        ("lab", ["via_points=much"], [], "disturbance_size"),
        ("lab", ["via_points=1.2.3"], [], "disturbance_size"),
        ("lab", ["via_points=-5mm"], [], "disturbance_size"),
    ],
)
def test_what_is_not_understood_is_refused_with_what_is_known(realism, added, left_out, rule) -> None:
    with pytest.raises(BadInput) as caught:
        chosen(realism, added, left_out)
    assert caught.value.faults[0].rule == rule


def test_the_command_refuses_before_anything_is_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "out"
    assert main(["sample", str(out), "--seed", "1", "--with", "gremlins"]) == 2
    assert "via_points" in capsys.readouterr().err
    assert main(["sample", str(out), "--seed", "1", "--payload", "--with", "via_points"]) == 2
    assert not out.exists()


def test_every_disturbance_is_in_the_help_and_in_the_document() -> None:
    document, text = DOCUMENT.read_text(encoding="utf-8"), table()
    for each in CATALOGUE:
        assert each.name in text
        (row,) = [line for line in document.splitlines() if line.startswith(f"| `{each.name}` ")]
        assert f"| {each.value:g} {each.unit} |" in row
        assert ("| lab |" in row) == each.in_lab


def test_tolerances_name_known_disturbances_and_all_that_a_laboratory_could_state() -> None:
    stated = {each.disturbance for each in TOLERANCES}
    measured = {"runs_differ", "runs_amplitude", "runs_timing", "encoder_steps"}  # by the logs, or as noise of q
    assert stated == set(LAB) - measured | {"feet_gain"}
    assert all(each["std"] > 0.0 for each in declared(LAB))
    assert declared(IDEAL) == []
