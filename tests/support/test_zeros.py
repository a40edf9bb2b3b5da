"""Zeros of the feet that move between the logs: their sum is found from the balance of the whole robot's forces."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from exogauge.devices.device import ViaPoint
from exogauge.robots.description import Declared
from exogauge.support.balance import balance
from exogauge.support.evaluate import estimate_support
from exogauge.support.notes import notes_on_zeros
from exogauge.support.settings import PlainLog, SupportSettings, WornLog
from exogauge.support.zeros import Zeros, find_zeros

FORCE, MOMENT = 4.0, 0.8  # declared: by the end of the session
SIZE = np.repeat([FORCE, MOMENT, FORCE, MOMENT], 3)
EVERY = np.arange(6)
STARTS = {"fit": 0.0, "before1": 600.0, "before2": 640.0, "worn1": 1300.0, "worn2": 1420.0, "after1": 2200.0,
          "after2": 2240.0}  # fmt: skip
AXES = ("fx", "fy", "fz", "mx", "my", "mz")


@pytest.fixture(scope="module")
def model(biped):
    return of_zeros(biped, taken_once=True)


def of_zeros(biped, taken_once):
    """Every mass is as it is, but every moment a little wrong: what is missed alike in all repetitions is no zero."""
    declared = Declared(ft_zero_force=FORCE, ft_zero_moment=MOMENT, zeros_taken="session" if taken_once else None)
    phi = biped.phi.copy()
    phi[:, 1:4] *= 1.03
    return replace(biped, robot=replace(biped.robot, declared=declared), phi=phi).known()


@pytest.fixture(scope="module")
def suit(suit):
    """Bands that go on to the thighs: the hips feel what the feet read."""
    ends = {"left": ViaPoint("l_thigh", (-0.08, 0.0, -0.2)), "right": ViaPoint("r_thigh", (-0.08, 0.0, -0.2))}
    return replace(
        suit,
        bands=tuple(
            replace(band, via_points=(*band.via_points, ends[band.name]), natural_length=band.natural_length + 0.15)
            for band in suit.bands
        ),
    )


@pytest.fixture(scope="module")
def clean(biped, suit, recorded):
    return recorded(biped, suit, STARTS)


@pytest.fixture(scope="module")
def end():
    """(12,) zeros at the end of the session."""
    return SIZE * np.random.default_rng(5).choice([-1.0, 1.0], 12) * np.random.default_rng(6).uniform(0.5, 1.0, 12)


def read(robot, log, zeros):
    """As feet read it whose zeros (6 S,) are on top of what the log holds, in its own sign."""
    own = dict(log.channels)
    for sensor, values in zip(robot.contacts, zeros.reshape(-1, 6), strict=True):
        for axis, value in zip(AXES, values, strict=True):
            own[f"ft.{sensor.name}.{axis}"] = own[f"ft.{sensor.name}.{axis}"] + sensor.sign * value
    return replace(log, channels=own)


def asked(robot, clean, suit, end, weight=0.0):
    """(logs without, logs with) as feet drift in proportion to time; the device weighs something on top [N]."""
    spoilt = {}
    for name, log in clean.items():
        on_top = np.zeros(12)
        on_top[[2, 8]] = 0.5 * weight if "worn" in name else 0.0
        spoilt[name] = read(robot, log, end * STARTS[name] / 2240.0 + on_top)
    plain = [PlainLog(spoilt[name], "stoop", name != "fit") for name in STARTS if "worn" not in name]
    return plain, [WornLog(spoilt[name], "stoop", suit) for name in STARTS if "worn" in name]


@pytest.mark.slow
def test_zeros_that_are_known_are_taken_off_to_the_last_digit(biped, clean, end):
    model, log = biped.known(), clean["worn1"]
    zeros = Zeros({log.name: 0}, np.ones((1, 1)), end[None], np.zeros((1, 12, 1)))
    spoilt = balance(model, model.prepare(read(model.robot, log, end)), EVERY)
    as_it_was = balance(model, model.prepare(log), EVERY).torque
    assert np.abs(spoilt.torque - as_it_was).max() > 0.5
    np.testing.assert_allclose(zeros.without(model, spoilt).torque, as_it_was, atol=1e-9)


def test_what_is_left_in_doubt_of_them_is_what_they_take_off_per_standard_deviation(model, clean, end):
    log, rng = clean["worn1"], np.random.default_rng(0)
    zeros = Zeros({log.name: 0}, np.array([[0.4, 1.1]]), np.zeros((2, 12)), rng.normal(size=(2, 12, 3)))
    own, samples = balance(model, model.prepare(log), EVERY), np.arange(50, 400, 10)
    doubt = zeros.doubt(model, own.prepared, samples, EVERY)["ft_zero"]
    for column in range(3):
        change = own.torque - replace(zeros, beta=zeros.root[:, :, column]).without(model, own).torque
        np.testing.assert_allclose(doubt[:, :, column], change[samples], rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize("weight", [0.0, 12.0])
def test_the_sum_is_found_in_logs_with_the_device_too_whatever_it_weighs(model, clean, suit, end, weight):
    zeros = find_zeros(model, *asked(model.robot, clean, suit, end, weight), STARTS)
    both = np.hstack([np.eye(6), np.eye(6)])[:3]  # forces: both feet have the same axes, and stand
    for name in ("worn1", "worn2", "after1"):
        told = zeros.of(clean[name]) - zeros.of(clean["before1"])
        truth = end * (STARTS[name] - STARTS["before1"]) / 2240.0
        doubt = zeros.inputs(clean[name]) - zeros.inputs(clean["before1"])
        std = np.linalg.norm(both @ doubt, axis=1)
        assert np.all(std < 0.25 * np.sqrt(2.0) * FORCE)
        assert np.all(np.abs(both @ (told - truth)) < 3.0 * std), (both @ told, both @ truth, std)
        each = np.linalg.norm(doubt, axis=1)  # how it is shared between the feet nothing tells
        assert np.all(np.abs(told - truth) < 3.0 * each)


def test_only_sums_that_surely_moved_are_told(model, clean, suit, end):
    moved = find_zeros(model, *asked(model.robot, clean, suit, end), STARTS)
    (said,) = notes_on_zeros(model, moved)
    truth = dict(zip(AXES, end.reshape(2, 6).sum(axis=0), strict=True))
    for name, (value, std) in zip(said.names, said.each, strict=True):
        assert abs(value) > 2.0 * std
        assert np.sign(value) == np.sign(truth[name])
    assert {"fx", "fy", "fz"} & set(said.names)
    assert notes_on_zeros(model, find_zeros(model, *asked(model.robot, clean, suit, 0.0 * end), STARTS)) == ()


def test_where_a_log_does_not_say_when_it_began_nothing_is_corrected(model, clean, suit, end):
    plain, worn = asked(model.robot, clean, suit, end)
    assert find_zeros(model, plain, worn, {name: each for name, each in STARTS.items() if name != "worn2"}) is None


@pytest.mark.slow
def test_zeros_that_were_taken_anew_before_each_log_are_doubted_by_all_that_is_declared(biped, clean, suit):
    """What one foot reads more and the other less no base row tells: as a course it would go with the partner's."""
    anew = of_zeros(biped, taken_once=False)
    rng = np.random.default_rng(4)
    zeros = {name: SIZE * rng.standard_normal(12) for name in STARTS}
    logs = {name: read(anew.robot, log, zeros[name]) for name, log in clean.items()}
    plain = [PlainLog(logs[name], "stoop", name != "fit") for name in STARTS if "worn" not in name]
    worn = [WornLog(logs[name], "stoop", suit) for name in STARTS if "worn" in name]
    without, with_times = (
        estimate_support(anew, plain, worn, SupportSettings(started=started))[1] for started in ({}, STARTS)
    )
    for unknown, known in zip(without, with_times, strict=True):
        for one, other in zip(unknown.bands, known.bands, strict=True):
            assert other.stiffness.parts["ft_zero"] == pytest.approx(one.stiffness.parts["ft_zero"], rel=0.2)
            assert other.stiffness.parts["ft_zero"] > 0.0
    assert find_zeros(anew, plain, worn, STARTS) is None


def test_with_no_run_before_and_after_all_that_is_declared_stays_in_doubt(model, clean, suit, end):
    plain, worn = asked(model.robot, clean, suit, end)
    zeros = find_zeros(model, [each for each in plain if each.log.name in ("fit", "before1")], worn[:1], STARTS)
    last = np.linalg.norm(zeros.inputs(clean["worn1"]), axis=1)
    course = np.linalg.norm(zeros.course[zeros.logs["worn1"]]) / np.sqrt(zeros.course.shape[1])
    np.testing.assert_allclose(last, SIZE * course, rtol=0.02)


@pytest.mark.slow
def test_the_stiffness_is_that_of_feet_that_stay_as_they_are_and_is_doubted_less_for_what_is_known(
    model, clean, suit, end
):
    """Held against feet that stay, without their session: there what is declared is all in doubt, but for what the fit
    of the bands has followed of it."""
    unknown = replace(suit, bands=tuple(replace(b, stiffness=None, natural_length=None) for b in suit.bands))

    def stiffness(zeros, started):
        found = estimate_support(model, *asked(model.robot, clean, unknown, zeros), SupportSettings(started=started))[1]
        return {each.approach: each.bands[0].stiffness for each in found}

    steady, told = stiffness(0.0 * end, {}), stiffness(end, STARTS)
    for approach in ("A", "B", "paired"):
        assert told[approach].parts["ft_zero"] < steady[approach].parts["ft_zero"] < 1e-3 * steady[approach].value
        assert abs(told[approach].value - steady[approach].value) < 2.0 * told[approach].std
