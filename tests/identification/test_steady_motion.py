"""What counts as error in steady motion: all that the equations speak of, and above their cut-off the noise alone."""

from dataclasses import replace

import numpy as np
import pytest

from exogauge.identification.identify import identify
from exogauge.identification.settings import Recording, Settings

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
