"""Where held-out logs go beyond what was fitted, a formula is only continued, and the finding says so."""

from dataclasses import replace

import numpy as np
import pytest

from exogauge.studies.words.finding_sentences import finding_sentence

pytestmark = pytest.mark.slow


def warmed(recording, begin):
    """From `begin` [°C] on by 6 K in each log; j1's viscous friction falls by 0.02 N·m·s/rad per kelvin."""
    log = recording.log
    temperature = begin + 0.2 * log.time
    speed = np.gradient(log.channels["q.j1"], log.time)
    torque = log.channels["tau.j1"] - 0.02 * (temperature - 25.0) * speed
    return replace(recording, log=replace(log, channels=log.channels | {"tau.j1": torque, "temp.j1": temperature}))


@pytest.mark.parametrize(("begins", "beyond"), [((25.0, 37.0, 50.0), True), ((25.0, 45.0, 36.0), False)])
def test_a_log_that_is_warmer_than_all_that_were_fitted_is_told(study, search, begins, beyond):
    found = search([warmed(each, begin) for each, begin in zip(study(noise=0.02), begins, strict=True)])
    (finding,) = found.discrepancy.findings
    assert (finding.effect, finding.place.name) == ("thermal_viscous", "j1")
    assert ("only continued" in finding_sentence(finding)) is beyond
    told = finding.basis.continued
    assert bool(told) is beyond
    if told:  # most of 50 to 56 °C, and of 37 to 43 °C
        assert (told.coordinate, told.unit) == ("temperature", "°C")
        assert [told.reached, told.fitted] == pytest.approx([56.0, 43.0], abs=0.3)


def test_friction_that_warms_up_is_drawn_over_time_where_no_thermometer_is_logged(study, search):
    found = search([without_thermometer(each) for each in study(seconds=60.0, noise=0.02)])
    (finding,) = found.discrepancy.findings
    assert (finding.effect, finding.place.name) == ("thermal_viscous", "j1")
    assert (finding.evidence.coordinate, finding.evidence.unit) == ("time", "s")
    assert "°C" not in finding_sentence(finding)
    assert finding.evidence.at.max() <= 60.0


def without_thermometer(recording):
    """j1 warms up by friction as it runs, and nobody logs how warm it is."""
    log = recording.log
    speed = np.gradient(log.channels["q.j1"], log.time)
    warmth = 1.0 - np.exp(-log.time / 20.0)
    return replace(recording, log=replace(log, channels=log.channels | {
        "tau.j1": log.channels["tau.j1"] - 0.4 * warmth * speed
    }))  # fmt: skip
