"""Effects at a sensor inside the robot or at the base are told where they are, in their own units."""

from __future__ import annotations

import dataclasses
import json
from typing import Any

import numpy as np
import pytest

from exogauge.devices.result import Estimate
from exogauge.effects.catalogue import missing_effects
from exogauge.effects.imu_tilt import ImuTilt
from exogauge.findings.basis import OfRobot
from exogauge.findings.result import (
    Alternative,
    ChainStep,
    Discrepancy,
    Evidence,
    Excess,
    Finding,
    HeldOut,
    Link,
    Place,
)
from exogauge.findings.verdict import Objection, Why
from exogauge.studies.report.discrepancy_figures import draw_chain, draw_evidence
from exogauge.studies.report.discrepancy_section import discrepancy_view
from exogauge.studies.report.figures import label
from exogauge.studies.results.discrepancy_results import discrepancy_entry
from exogauge.studies.results.plain_values import finite
from exogauge.studies.words.names import at_place, channel, place_words

FX, BASE = Place("sensor", "wrist", "fx"), Place("base", "base")


def finding(rank: int, effect: str, where: Place, held: HeldOut, coordinate: str, unit: str) -> Finding:
    at_ = np.linspace(-30.0, 40.0, 15)
    seen = Evidence(coordinate, unit, at_, 0.1 * at_, 0.0 * at_, np.full(15, 0.05), 0.1 * at_)
    other = Alternative("ft_crosstalk", Place("sensor", "wrist", "mz"), 0.31, Objection(Why.LESS))
    (known,) = [each for each in missing_effects() if each.name == effect and not isinstance(each, ImuTilt)]
    found = {"gain": Estimate(0.1, 0.002, "1")}
    return Finding(rank, effect, where, found, held, 0.97, OfRobot(known), (other,), (), seen)


@pytest.fixture
def found(clean: Discrepancy) -> Discrepancy:
    """A wrong gain of a force, and a base that is tilted, seen best in a moment."""
    held = HeldOut("ft.wrist.fx", "N", 3.2, 0.52, 0.5), HeldOut("ft.wrist.mz", "N·m", 0.09, 0.011, 0.01)
    return dataclasses.replace(
        clean,
        findings=(
            finding(1, "ft_gain", FX, held[0], "reading", "N"),
            finding(2, "base_tilt", BASE, held[1], "time", "s"),
        ),
        chain=(
            Link(ChainStep("robot"), 6.4, 1.0, "ft.wrist.mz", 0.09, 0.01, "floors"),
            Link(
                ChainStep("effect", "ft_gain", Place("sensor", "wrist", "fx")), 2.1, 1.0, "tau.j1", 2.5, 1.1, "floors"
            ),
            Link(
                ChainStep("effect", "base_tilt", Place("base", "base")),
                0.99,
                1.0,
                "ft.wrist.fx",
                0.49,
                0.5,
                "floors",
                "N",
            ),
        ),
        unexplained=(Excess("ft.wrist.fy", "N", 0.9, 0.5, 5.0),),
    )


def content(found: Discrepancy) -> dict[str, Any]:
    channels = ("tau.j1", "tau.j2", *(f"ft.wrist.{component}" for component in ("fx", "fy", "fz", "mx", "my", "mz")))
    fits = [{"channel": name, "log": "val_1", "held_out": True} for name in channels]
    told = {"discrepancy": finite(discrepancy_entry(found)), "identification": {"validation": fits}}
    return dict(json.loads(json.dumps(told)))


def test_a_component_of_a_sensor_is_called_as_in_the_log() -> None:
    assert place_words("sensor", "wrist", "fx") == "wrist.fx"
    assert at_place("ft_gain", "sensor", "wrist", "fx") == "a wrong gain of the force/torque sensor at wrist.fx"
    assert channel("ft.wrist.fx") == label("ft.wrist.fx") == "wrist.fx"


def test_results_name_sensor_and_axis_and_what_reads_them_understands(found: Discrepancy) -> None:
    first, second = content(found)["discrepancy"]["findings"]
    assert (first["where"], second["where"]) == ({"sensor": "wrist", "axis": "fx"}, {"base": True})
    assert first["title"] == "a wrong gain of the force/torque sensor at wrist.fx"
    assert second["title"] == "a tilted base"
    assert first["alternatives"][0]["title"] == "crosstalk of the force/torque sensor at wrist.mz"


def test_sentences_hold_each_channels_own_unit(found: Discrepancy) -> None:
    entry = content(found)["discrepancy"]
    assert entry["sentence"].startswith(
        "The identified model does not know of 2 effects: a wrong gain of the force/torque sensor at wrist.fx "
        "(3.20 → 0.520 N, noise floor 0.500) and a tilted base (wrist.mz: 0.0900 → 0.0110 N·m, noise floor 0.0100)."
    )
    assert entry["left_sentence"] == "One channel stays above the noise, at wrist.fy (0.900 N RMSE, noise floor 0.500)."


def test_a_chain_over_several_units_is_told_in_multiples_of_the_floors(found: Discrepancy) -> None:
    drawn = draw_chain(found.chain, "k")
    for said in ("6.40 × floor", "1.00 × floor", "wrist.mz, 0.0900 over 0.0100 N·m", "joint" not in drawn):
        assert said is True or said in drawn
    assert "every channel at its floor or below" in drawn
    view = discrepancy_view(found, content(found))
    assert view is not None
    assert view.chain is not None
    assert "each in multiples of its noise floor" in view.chain.caption
    assert "Looked at: 2 joint torques and 6 sensor readings" in view.looked_at


def test_the_section_draws_evidence_in_the_unit_of_its_channel(found: Discrepancy) -> None:
    view = discrepancy_view(found, content(found))
    assert view is not None
    force, moment = (each.picture for each in view.findings)
    assert force is not None
    assert moment is not None
    assert "[N]" in force.svg
    assert "expected reading [N]" in force.svg
    assert "[N·m]" in moment.svg
    assert force.caption.startswith("What wrist.fx reads beyond the model, over expected reading")
    assert "reaches 4.0 N, after 0 N." in force.words
    assert view.channels == "channels"
    assert [each.channel for each in view.findings] == ["wrist.fx", "wrist.mz"]


def test_a_torques_evidence_stays_in_newton_metres(found: Discrepancy) -> None:
    assert "[N·m]" in draw_evidence(found.findings[0].evidence, {}, "k")
