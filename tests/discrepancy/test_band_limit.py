"""A low-pass before storage makes friction look soft; it is seen, its cut-off found, and the model filtered alike."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import bessel, butter, lfilter, sosfilt, sosfiltfilt

from exogauge.discrepancy.band_limit import band_limits
from exogauge.discrepancy.workflow import find_missing_effects
from exogauge.effects.catalogue import shaped_effects
from exogauge.identification.identify import identify
from exogauge.identification.settings import Settings
from exogauge.logs.stored_band import stored_edge

RATE = 200.0
SETTINGS = Settings(cutoff_hz=20.0)


def changed(recordings, change):
    """change: (name of a channel, (T,)) -> (T,)."""
    return [
        replace(each, log=replace(each.log, channels={name: change(name, x) for name, x in each.log.channels.items()}))
        for each in recordings
    ]


def stored_through(sections, both_ways=True):
    passed = sosfiltfilt if both_ways else sosfilt
    return lambda _name, values: passed(sections, values - values[0]) + values[0]


def limits(robot, recordings):
    def anew(each):
        return identify(robot, each, SETTINGS)

    return band_limits(anew(recordings), recordings, anew)


@pytest.mark.parametrize("hz", [2.0, 3.0, 5.0])
@pytest.mark.parametrize("decimals", [12, 3])
def test_the_cut_off_comes_out_within_its_doubt(robot, study, hz, decimals):
    through = stored_through(butter(4, hz, fs=RATE, output="sos"))

    def stored(name, values):
        passed = through(name, values)
        return np.round(passed, decimals) if name.startswith("tau") else passed

    found = limits(robot, changed(study(), stored))
    assert found is not None
    assert abs(found.band.hz - hz) < 2.0 * found.band.std
    assert found.band.std < 0.1 * hz
    assert found.finding.parameters["cutoff"].value == found.band.hz
    assert (found.finding.place.kind, found.finding.place.name) == ("log", "all")
    assert found.finding.held_out.rmse_after < 0.5 * found.finding.held_out.rmse_before


@pytest.mark.parametrize(
    ("sections", "both_ways"),
    [
        (butter(8, 3.0, fs=RATE, output="sos"), True),
        (bessel(8, 3.0, fs=RATE, output="sos", norm="mag"), True),
        (butter(8, 3.0, fs=RATE, output="sos"), False),
    ],
    ids=["steeper", "bessel", "one way"],
)
def test_a_filter_of_another_shape_is_seen_too(robot, study, sections, both_ways):
    found = limits(robot, changed(study(), stored_through(sections, both_ways)))
    assert found is not None
    assert 2.0 < found.band.hz < 4.0


def dahl(motion):
    """Four springs that slip, on the second joint, by 1.5 N·m: friction soft at turns, though stored as it is."""
    torque, held = np.zeros_like(motion.q), np.zeros(4)
    reach = np.array([0.01, 0.02, 0.04, 0.08])
    for k in range(1, len(motion.t)):
        held = np.clip(held + motion.q[k, 1] - motion.q[k - 1, 1], -reach, reach)
        torque[k, 1] = 1.5 * np.mean(held / reach)
    return torque


def none(name, values):
    return values


def on_efforts(change):
    return lambda name, values: change(values) if name.startswith("tau") else values


CLEAN = {
    "as it is": ({}, none),
    "hardly any noise": ({"noise": 1e-3}, none),
    "much noise": ({"noise": 1.0}, none),
    "no noise": ({"noise": 0.0}, none),
    "no noise, in steps": ({"noise": 0.0}, on_efforts(lambda x: np.round(x, 2))),
    "no noise, in coarse steps": ({"noise": 0.0}, on_efforts(lambda x: 0.2 * np.round(x / 0.2))),
    "single precision": ({"noise": 0.0}, on_efforts(lambda x: x.astype(np.float32).astype(float))),
    "short": ({"seconds": 8.0}, none),
    "one joint still": ({"still": 1}, none),
    "one joint still, no noise": ({"still": 1, "noise": 0.0}, none),
    "a lag of 10 ms": ({}, on_efforts(lambda x: lfilter([0.4], [1.0, -0.6], x))),
    "a drive's second-order filter": ({}, on_efforts(lambda x: sosfilt(butter(2, 30.0, fs=RATE, output="sos"), x))),
    "the same, slow": ({}, on_efforts(lambda x: sosfilt(butter(2, 10.0, fs=RATE, output="sos"), x))),
    "anti-aliasing": ({"noise": 0.01}, on_efforts(lambda x: sosfilt(butter(8, 60.0, fs=RATE, output="sos"), x))),
    "mean of five": ({}, on_efforts(lambda x: np.convolve(x, np.ones(5) / 5, mode="same"))),
    "every second value twice": ({}, on_efforts(lambda x: np.repeat(x[::2], 2)[: len(x)])),
}


@pytest.mark.parametrize("variant", CLEAN)
def test_logs_that_were_not_low_passed_do_not_end(study, variant):
    how, change = CLEAN[variant]
    assert [stored_edge(each.log) for each in changed(study(**how), change)] == [None] * 3


@pytest.mark.parametrize("noise", [0.05, 0.0])
def test_friction_that_is_soft_at_turns_is_no_filter(study, noise):
    assert [stored_edge(each.log) for each in study(dahl, noise=noise)] == [None] * 3


def test_smooth_motion_without_friction_or_noise_ends_as_well_but_asks_for_no_filter(robot, study):
    smooth = study(lambda motion: motion.load - motion.drive, noise=0.0)
    assert stored_edge(smooth[0].log) is not None
    assert limits(robot, smooth) is None


def test_noise_free_logs_without_a_low_pass_are_left_alone(robot, study):
    assert limits(robot, study(noise=0.0)) is None


def test_without_a_held_out_log_nothing_is_claimed(robot, study):
    recordings = changed(study(), stored_through(butter(4, 3.0, fs=RATE, output="sos")))
    assert limits(robot, [replace(each, held_out=False) for each in recordings]) is None


@pytest.mark.slow
def test_a_low_passed_log_is_named_first_and_no_friction_with_it(robot, study):
    recordings = changed(study(), stored_through(butter(4, 2.0, fs=RATE, output="sos")))
    found = find_missing_effects(
        identify(robot, recordings, SETTINGS), recordings, tuple(shaped_effects().values()), SETTINGS
    ).discrepancy
    assert [each.effect for each in found.findings] == ["band_limited_log"]
    assert found.chain[1].rmse < found.chain[0].rmse
