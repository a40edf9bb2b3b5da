"""Friction that turns round over a span of speeds: no name, and no rows where it matters."""

import numpy as np
import pytest
from tests.discrepancy.conftest import FRICTION, SETTINGS

from exogauge.detect.pipeline import find_missing_effects
from exogauge.effects.catalogue import missing_effects
from exogauge.identification.identify import identify
from exogauge.identification.settings import Settings
from exogauge.identification.steady import seconds, steady_shares
from exogauge.remarks import About

SPAN = 0.08  # [rad/s]


def soft(form):
    """Coulomb friction of joint 2 by `form` of the velocity instead of its sign."""

    def hidden(motion):
        return FRICTION["tau_c"] * (form(motion.v / SPAN) - np.sign(motion.v)) * (np.arange(3) == 1)

    return hidden


@pytest.mark.parametrize("form", [np.tanh, lambda x: x / np.hypot(1.0, x)], ids=["tanh", "root"])
@pytest.mark.slow
def test_soft_friction_is_no_effect_and_its_rows_are_no_steady_motion(form, study, search):
    found = search(study(soft(form)))
    assert found.discrepancy.findings == ()
    assert found.discrepancy.verdict == "none"
    assert [joint for joint, speed in found.settings.creeping.items() if speed > 2.0 * SPAN] == ["j2"]
    for fit in found.identification.validation:
        assert fit.rmse_moving < 1.05 * fit.noise_floor
    assert ["j2" in each.names for each in found.identification.remarks if each.about == About.CREEPING] == [True]


def test_a_joint_that_creeps_gives_no_row_below_its_speed(robot, study):
    recordings = study()
    found = identify(robot, recordings, Settings(cutoff_hz=8.0, creeping={"j2": 0.5}))
    prepared = found.model.prepare(recordings[0].log)
    slowest = [np.abs(prepared.axis_velocity[prepared.steady[:, axis], axis]).min() for axis in range(3)]
    assert slowest[1] >= 0.5
    assert max(slowest[0], slowest[2]) < 0.5
    (_, second, _) = steady_shares(["j1", "j2", "j3"], [seconds(prepared)], [])
    assert 0.0 < second.fitted_s < second.fitted_of_s


@pytest.mark.slow
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_friction_that_is_larger_at_low_speed_is_not_taken_for_soft(sign, robot, study):
    """Stribeck's curve lives at the same speeds; only what is less than Coulomb friction there is soft."""

    def hidden(motion):
        own = 0.6 * np.exp(-np.abs(motion.v) / SPAN) * np.sign(motion.v)
        return sign * own * (np.arange(3) == 1)

    recordings = study(hidden)
    found = identify(robot, recordings, SETTINGS)
    missing = find_missing_effects(found, recordings, missing_effects(), SETTINGS)
    named = [each.effect for each in missing.discrepancy.findings]
    assert named == (["stribeck"] if sign > 0.0 else [])
    assert list(missing.settings.creeping) == ([] if sign > 0.0 else ["j2"])


@pytest.mark.slow
def test_stribecks_numbers_are_those_of_steady_motion_where_the_joint_creeps_too(robot, study):
    """All friction fades in over a span of speeds, below that of the curve, as simulators have it."""
    size, v_s, fading = 1.5, 0.5, 0.08

    def hidden(motion):
        turned, curve = np.tanh(motion.v / fading), size * np.exp(-((motion.v / v_s) ** 2))
        return (FRICTION["tau_c"] * (turned - np.sign(motion.v)) + curve * turned) * (np.arange(3) == 1)

    recordings = study(hidden)
    missing = find_missing_effects(identify(robot, recordings, SETTINGS), recordings, missing_effects(), SETTINGS)
    (named,) = missing.discrepancy.findings
    assert (named.effect, named.place.name) == ("stribeck", "j2")
    for name, truth in {"tau_b": size, "v_s": v_s, "delta": 2.0}.items():
        found = named.parameters[name]
        assert abs(found.value - truth) < 3.0 * found.std
    assert fading < missing.settings.creeping["j2"] < v_s
