"""What a result named of bands, written into the device file that they came from."""

from __future__ import annotations

import json

import pytest
import yaml

from exogauge.cli import main
from exogauge.effects.band_laws import all_laws
from exogauge.errors import BadInput
from exogauge.studies.device_pages.device_content import device_from
from exogauge.studies.results.taken_over import taken_over, taken_over_of

POINTS = [{"link": "chest", "xyz": [0.0, 0.1, 0.2]}, {"link": "pelvis", "xyz": [0.0, 0.1, 0.0]}]


def device(**of_left):
    left = {"name": "left", "group": "back", "via_points": POINTS, "stiffness_n_per_m": 400.0} | of_left
    right = {"name": "right", "group": "back", "via_points": POINTS, "stiffness_n_per_m": 400.0}
    return {"version": 1, "name": "suit", "bands": [left, right], "tied": ["back"], "record": {"size": "M"}}


def measured(value, std, unit):
    return {"value": value, "std": std, "unit": unit}


def finding(effect, band="left", rank=1, **parameters):
    found = {name: measured(*each) for name, each in parameters.items()}
    return {"rank": rank, "effect": effect, "where": {"band": band}, "title": effect, "parameters": found}


def springs(*bands, approach="A", stiffness=412.0, length=0.51):
    return [{"device": "suit", "approach": approach, "band": band, "stiffness_n_per_m": measured(stiffness, 6.0, "N/m"),
             "natural_length_m": measured(length, 0.0006, "m")} for band in bands]  # fmt: skip


HARDENING = {"hardening": (900.0, 30.0, "N/m²"), "hardening_power": (2.1, 0.05, "1")}


def test_a_law_stands_there_with_its_springs_units_and_doubts():
    taken = taken_over(device(), [finding("band_hardening", **HARDENING)], springs("left", "right"))
    left, right = device_from({k: v for k, v in taken.content.items() if k != "record"}).bands
    assert (left.law, dict(left.law_values)) == ("hardening", {"hardening": 900.0, "hardening_power": 2.1})
    assert (left.stiffness, left.natural_length, left.group) == (412.0, 0.51, "left")
    assert (right.law, right.stiffness, right.group) == ("linear", 400.0, "back")
    assert taken.content["record"] == {"size": "M"}
    head = taken.text("results.json").split("version:")[0]
    assert "hardening 900 ± 30 N/m²" in head
    assert "stiffness 412.0 ± 6.0 N/m" in head
    assert "natural length 0.51000 ± 0.00060 m" in head
    assert all(line.startswith("# ") for line in head.splitlines())


def test_bands_of_which_the_same_is_said_stay_a_group():
    both = [finding("band_hardening", name, rank, **HARDENING) for rank, name in enumerate(("left", "right"), 1)]
    taken = taken_over(device(), both, springs("left", "right"))
    assert [band["group"] for band in taken.content["bands"]] == ["back", "back"]
    assert taken.content["tied"] == ["back"]
    assert taken.ranks == (1, 2)


def test_a_law_joins_the_one_that_is_stated_and_the_same_law_grows():
    damped = {"law": "kelvin_voigt", "law_values": {"damping": 10.0, "damping_power": 1.0}}
    taken = taken_over(device(**damped), [finding("band_hardening", **HARDENING)], springs("left"))
    left = taken.content["bands"][0]
    assert left["law"] == "kelvin_voigt+hardening"
    assert left["law_values"] == {"damping": 10.0, "damping_power": 1.0, "hardening": 900.0, "hardening_power": 2.1}
    more = finding("band_viscous", damping=(4.0, 1.0, "N·s/m"), damping_power=(1.0, 0.0, "1"))
    assert taken_over(device(**damped), [more], springs("left")).content["bands"][0]["law_values"]["damping"] == 14.0
    other = finding("band_viscous", damping=(4.0, 1.0, "N·s/m"), damping_power=(0.8, 0.0, "1"))
    refused = taken_over(device(**damped), [other], springs("left"))
    assert not refused.ranks
    assert "damping_power" in refused.left[0]


def test_what_no_device_file_can_hold_is_said():
    found = [finding("band_slip", slip=(0.012, 0.001, "m")), finding("extra_band", "right", 2), finding("stribeck")]
    found[2]["where"] = {"joint": "torso"}
    taken = taken_over(device(), found, springs("left", "right"))
    assert taken.content["bands"] == device()["bands"]
    assert len(taken.left) == 2
    with pytest.raises(BadInput) as refused:
        taken_over_of({"discrepancy": {"findings": found}, "stiffness": []}, device())
    (fault,) = refused.value.faults
    assert fault.rule == "nothing_to_take_over"
    assert "one moment" in fault.advice


def test_a_shape_that_the_logs_do_not_decide_is_not_made_up():
    taken = taken_over(device(), [finding("band_hardening", hardening=(900.0, 30.0, "N/m²"))], springs("left"))
    assert not taken.ranks
    assert "hardening_power" in taken.left[0]


def test_of_two_devices_each_gets_its_own():
    found = finding("band_hardening", **HARDENING) | {"device": "another suit"}
    assert not taken_over(device(), [found], springs("left")).ranks


def test_a_true_value_is_no_longer_called_true():
    taken = taken_over(
        device(ground_truth=True), [finding("band_stiffness", stiffness=(300.0, 4.0, "N/m"))], springs("left")
    )
    assert "ground_truth" not in taken.content["bands"][0]


@pytest.mark.parametrize("law", sorted(set(all_laws()) - {"linear", "smooth_slack"}))  # that one is not looked for
def test_every_law_that_can_be_named_can_be_stated(law):
    (effect,) = all_laws()[law].effects
    values = {each.name: (each.grid[0], 0.01, each.unit) for each in effect.shapes}
    values |= {each.name: (0.5, 0.01, each.unit) for each in effect.coefficients}
    taken = taken_over(device(), [finding(effect.name, **values)], springs("left"))
    left = device_from({key: each for key, each in taken.content.items() if key != "record"}).bands[0]
    assert left.law == law
    assert set(left.law_values) == set(values)


def test_by_one_command(tmp_path, capsys):
    results = {"name": "a study", "discrepancy": {"findings": [finding("band_hardening", **HARDENING)]},
               "stiffness": springs("left")}  # fmt: skip
    (tmp_path / "results.json").write_text(json.dumps(results))
    (tmp_path / "device.yaml").write_text(yaml.safe_dump(device()))
    out = tmp_path / "stated.yaml"
    assert main(["take-over", str(tmp_path), str(tmp_path / "device.yaml"), "--out", str(out)]) == 0
    assert "left: hardening 900" in capsys.readouterr().out
    assert yaml.safe_load(out.read_text())["bands"][0]["law"] == "hardening"
    assert main(["take-over", str(tmp_path), str(tmp_path / "device.yaml")]) == 0
    assert capsys.readouterr().out == out.read_text()
