"""A channel is located where it is off by more than its sensor's noise, and it is said where."""

from dataclasses import replace

import numpy as np
import pytest

from exogauge.search.baseline import lay_ground
from exogauge.search.declared import left_over
from exogauge.search.locate import located, pooled
from exogauge.studies.words.finding_sentences import where_words


@pytest.fixture
def located_in(identified):
    def find(recordings):
        found = identified(recordings)
        ground = lay_ground(found.model, recordings, (), lambda *_: None)
        return located(found.model.equations, found, ground.residuals)

    return find


def test_channels_at_their_noise_floor_are_not_located(located_in, study):
    assert located_in(study()) == ()


def test_a_log_that_begins_and_ends_in_full_motion_is_at_its_floor(identified, study):
    for fit in identified(study()).validation:
        assert fit.rmse_moving == pytest.approx(fit.noise_floor, rel=0.05), (fit.log, fit.channel)


def test_a_channel_above_its_floor_is_located_with_how_far(located_in, study, on_joint):
    (excess,) = located_in(study(on_joint(2, lambda m: 0.8 * np.abs(m.v))))
    assert (excess.channel, excess.unit) == ("tau.j3", "N·m")
    assert excess.rmse > 1.25 * excess.noise_floor
    assert excess.noise_floor == pytest.approx(0.05, rel=0.2)  # of the torque sensor
    assert excess.z > 3.0


WHERE = [
    (lambda m: 2.0 * np.sin(20.0 * m.t)[:, None] * (np.abs(m.v) > 1.5), "at a speed above"),
    (lambda m: 2.0 * np.sin(20.0 * m.t)[:, None] * (m.q > np.quantile(m.q, 0.7, axis=0)), "at a position above"),
    (lambda m: 2.0 * np.sin(20.0 * m.t)[:, None] * (m.t > 22.0)[:, None], "at a time since the start above"),
    (lambda m: 2.0 * np.sin(20.0 * m.t)[:, None] * np.ones(3), "throughout"),
    (lambda m: 2.0 * (np.abs(m.t - 6.5) < 0.2)[:, None] * np.ones(3), "in a few moments: at 6 s of log9"),
]


@pytest.mark.parametrize(("hidden", "words"), WHERE)
def test_it_is_said_where_a_channel_is_off(located_in, study, on_joint, hidden, words):
    (excess,) = located_in(study(on_joint(2, hidden)))
    assert where_words(excess).replace("\u00a0", " ").startswith(words)


def test_the_widest_gap_comes_first(located_in, study, on_joint):
    small, large = on_joint(0, lambda m: 0.8 * np.abs(m.v)), on_joint(2, lambda m: 3.0 * np.abs(m.v))
    ratios = [each.rmse / each.noise_floor for each in located_in(study(lambda m: small(m) + large(m)))]
    assert len(ratios) == 2
    assert ratios == sorted(ratios, reverse=True)


def test_what_is_left_of_a_log_that_joined_is_unexplained_where_no_other_is_held_out(identified, study, on_joint):
    """A name was given for the only log that had been held out, and of the seven noise floors left nothing was said."""
    recordings = [replace(each, held_out=False) for each in study(on_joint(2, lambda m: 3.0 * np.abs(m.v)))]
    found = identified(recordings)
    ground = lay_ground(found.model, recordings, (), lambda *_: None)
    assert left_over(found, ground.residuals, recordings)[0] == ()
    (left,), _ = left_over(found, ground.residuals, recordings, {recordings[-1].log.name})
    assert left.channel == "tau.j3"


def test_without_a_held_out_log_nothing_is_located(located_in, study, on_joint):
    assert located_in(study(on_joint(2, lambda m: 3.0 * np.abs(m.v)))[:2]) == ()
    assert all(np.isnan(pooled([])))
