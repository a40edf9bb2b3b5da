"""What counts as error in steady motion: all that the equations speak of, and above their cut-off the noise alone."""

from dataclasses import replace

import numpy as np
import pytest

from exogauge.identification.identify import identify
from exogauge.identification.settings import Recording, Settings
from exogauge.remarks import About

CUTOFF_HZ, RATE = 8.0, 200.0


@pytest.fixture
def fits(make_truth, make_log):
    """joint -> fits of a held-out log whose torque of j2 has a sine added."""
    truth = make_truth(False, actuation="torque")
    *fitted, held_out = (make_log(truth, seed, seconds=40.0, noise=1.0) for seed in (1, 2, 3, 9))

    def of(hz: float, size: float):
        time = np.arange(held_out.samples) / RATE
        shaken = held_out.channels["tau.j2"] + size * np.sin(2 * np.pi * hz * time)
        log = replace(held_out, channels={**held_out.channels, "tau.j2": shaken})
        recordings = [*(Recording(each, False) for each in fitted), Recording(log, True)]
        found = identify(truth.robot, recordings, Settings(cutoff_hz=CUTOFF_HZ))
        return {fit.channel: fit for fit in found.validation if fit.held_out}

    return of


def test_without_anything_added_the_error_is_the_noise(fits):
    for fit in fits(1.0, 0.0).values():
        assert 0.9 * fit.noise_floor < fit.rmse_moving < 1.2 * fit.noise_floor, fit.channel
        assert 0.5 * fit.noise_floor < fit.noise_beyond_band < fit.noise_floor


def test_a_gap_below_the_cut_off_counts_in_full(fits):
    fit = fits(1.5, 0.6)["tau.j2"]
    assert fit.rmse_moving == pytest.approx(np.hypot(0.6 / np.sqrt(2), fit.noise_floor), rel=0.15)


@pytest.mark.slow
def test_shaking_above_the_cut_off_is_no_fault_of_the_model(fits):
    fit = fits(11.5, 0.6)["tau.j2"]  # below twice the cut-off: what is there is not taken for noise
    assert fit.rmse_identified > 0.4
    assert fit.rmse_moving < 1.1 * fits(1.0, 0.0)["tau.j2"].rmse_moving


def test_nothing_is_told_of_a_joint_that_never_leaves_the_span_in_which_its_gear_gives_way(make_truth, make_log):
    truth = make_truth(False, actuation="torque")
    swing, gives_way = np.array([1.0, 1.0, 0.005]), 0.004  # rad

    def log_of(seed):
        log = make_log(truth, seed, seconds=40.0, noise=0.1, swing=swing)
        way, tau_c = np.diff(log.channels["q.j3"], prepend=log.channels["q.j3"][0]), truth.xi["tau_c"][2]
        held = np.zeros(log.samples)
        for k in range(1, log.samples):  # [Dahl 1968]: a spring that slides at tau_c
            held[k] = held[k - 1] + (tau_c - held[k - 1] * np.sign(way[k])) / gives_way * way[k]
        sliding = tau_c * np.sign(way)
        return replace(log, channels={**log.channels, "tau.j3": log.channels["tau.j3"] + held - sliding})

    logs = [log_of(seed) for seed in (1, 2, 3)]
    found = identify(truth.robot, [Recording(each, False) for each in logs], Settings(cutoff_hz=CUTOFF_HZ))
    own = {each.name: each for each in found.parameters if each.name.endswith("[j3]") and "link" not in each.name}
    off = abs(own["tau_c[j3]"].value - truth.xi["tau_c"][2]) / own["tau_c[j3]"].std
    assert off > 5, "it would be wrong"
    assert own["tau_c[j3]"].std < 0.1 * own["tau_c[j3]"].prior_std, "and sure"
    assert not any(each.identifiable for each in own.values())
    assert {"tau_c[j3]", "k_d[j3]"} <= set(found.unidentifiable)
    assert [each.names for each in found.remarks if each.about == About.HARDLY_SLIDES] == [("j3",)]
    for joint, k in (("j1", 0), ("j2", 1)):
        (coulomb,) = (each for each in found.parameters if each.name == f"tau_c[{joint}]")
        assert coulomb.identifiable
        assert coulomb.value == pytest.approx(truth.xi["tau_c"][k], abs=4 * coulomb.std)
