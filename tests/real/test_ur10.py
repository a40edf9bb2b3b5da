"""UR10: an exciting trajectory, 27.5 s at 125 Hz, in a rosbag2; low-passed below 2 Hz before it was stored."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from tests.real.recordings.ur10 import BAG, FILES, JOINTS, RECORDING, joint_states, write

from exogauge.logs.mapping import read_mapped
from exogauge.studies.import_log.column_words import Wearer
from exogauge.studies.import_log.log_preview import preview
from exogauge.studies.intake.mapping_file import parse_mapping

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def folder(recording: Callable[..., Path]) -> Path:
    folder = recording(RECORDING, FILES)
    write(folder)
    return folder


@pytest.fixture(scope="module")
def found(folder: Path, answer: Callable[..., Mapping[str, Any]]) -> Mapping[str, Any]:
    """With every setting at its default."""
    return answer(folder / "forward.yaml")


@pytest.fixture(scope="module", params=["forward", "reverse"])
def either(folder: Path, answer: Callable[..., Mapping[str, Any]], request: pytest.FixtureRequest) -> Mapping[str, Any]:
    """With every setting at its default, whichever part is fitted."""
    return answer(folder / f"{request.param}.yaml")


def on_joints(found: Mapping[str, Any]) -> dict[tuple[str, str], Mapping[str, Any]]:
    """(effect, joint) -> finding."""
    findings = found["discrepancy"]["findings"]
    return {(each["effect"], each["where"]["joint"]): each for each in findings if "joint" in each["where"]}


@pytest.mark.parametrize("ending", ["db3", "mcap"])
def test_the_bag_itself_is_read_as_the_drafted_mapping_says(recording: Callable[..., Path], ending: str) -> None:
    name = BAG.replace("db3", ending)
    folder = recording("ur10_rosbag2", (BAG, name))
    drafted = preview(folder / name, name, Wearer())["proposal"]
    (folder / "mapping.yaml").write_text(yaml.safe_dump(drafted))
    mapping = parse_mapping((folder / "mapping.yaml").read_bytes(), "mapping.yaml")
    joints = [joint.removesuffix("_joint") for joint in JOINTS]
    log = read_mapped({name: folder / name}, mapping, joints=joints, motor_from_joint=None, name="ur10")
    written = joint_states(folder / BAG)
    np.testing.assert_allclose(log.time, written["t"], atol=1e-6)
    for joint in joints:
        assert np.array_equal(log.channels[f"q.{joint}"], written[f"q.{joint}_joint"])
        assert np.array_equal(log.channels[f"tau.{joint}"], written[f"tau.{joint}_joint"])


def test_held_out_torques_are_predicted_three_times_as_well_as_by_the_stock_model(found: Mapping[str, Any]) -> None:
    fits = [each for each in found["identification"]["validation"] if each["held_out"]]
    assert len(fits) == len(JOINTS)
    for fit in fits:
        assert fit["rmse_identified"] < 0.33 * fit["rmse_prior"], fit["channel"]


def test_the_log_is_found_to_be_low_passed_before_anything_else_is_sought(either: Mapping[str, Any]) -> None:
    first = either["discrepancy"]["findings"][0]
    assert (first["effect"], first["where"]) == ("band_limited_log", {"log": "all"})
    assert 1.6 < first["parameters"]["cutoff"]["value"] < 2.0
    assert first["held_out"]["rmse_after"] < 0.7 * first["held_out"]["rmse_before"]  # of the channel that gains most


def test_cut_offs_of_both_parts_agree(folder: Path, answer: Callable[..., Mapping[str, Any]]) -> None:
    values = [
        answer(folder / f"{part}.yaml")["discrepancy"]["findings"][0]["parameters"]["cutoff"]
        for part in ("forward", "reverse")
    ]
    doubt = np.hypot(values[0]["std"], values[1]["std"])
    assert abs(values[0]["value"] - values[1]["value"]) < 2.0 * doubt


@pytest.mark.xfail(
    strict=False,
    reason="0.04 N·m per N·m stands at the edge of what is asked for, and falls on either side of it with the cut-off "
    "(docs/measured/real-logs.md)",
)
def test_the_lifted_arm_rubs_more_under_load_whichever_part_is_fitted(either: Mapping[str, Any]) -> None:
    """Least squares beside the product agree: 0.04 and 0.06 N·m of friction per N·m of gravity
    (docs/measured/real-logs.md).

    And nothing else is named than, from one of the parts, the elbow's viscous friction as a curve: the filter is not
    taken for friction, nor friction for a load on a link.
    """
    named = {(each["effect"], *each["where"].values()): each for each in either["discrepancy"]["findings"]}
    curve = ("nonlinear_viscous", "elbow_joint")
    assert set(named) - {curve} == {("band_limited_log", "all"), ("load_coulomb", "shoulder_lift_joint")}
    finding = named["load_coulomb", "shoulder_lift_joint"]
    assert 0.03 < finding["parameters"]["mu"]["value"] < 0.06
    assert finding["held_out"]["rmse_after"] < 0.6 * finding["held_out"]["rmse_before"]


def test_a_filter_is_not_taken_for_friction(found: Mapping[str, Any]) -> None:
    assert ("presliding", "shoulder_pan_joint") not in on_joints(found)


def test_friction_is_not_taken_for_a_load_on_a_link(found: Mapping[str, Any]) -> None:
    assert [each for each in found["discrepancy"]["findings"] if "link" in each["where"]] == []


def test_what_is_added_makes_the_held_out_error_smaller(found: Mapping[str, Any]) -> None:
    for (effect, _), finding in on_joints(found).items():
        assert finding["held_out"]["rmse_after"] < finding["held_out"]["rmse_before"], effect
