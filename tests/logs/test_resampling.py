import numpy as np
import pytest

from exogauge.errors import BadLog
from exogauge.logs.model import Log
from exogauge.logs.resampling import is_even, to_common_clock, uniform


def motion(time: np.ndarray) -> np.ndarray:
    return np.sin(2 * np.pi * 1.3 * time) + 0.3 * np.cos(2 * np.pi * 4.0 * time)


def sampled(name: str, start: float, end: float, rate: float, **channels) -> Log:
    time = np.arange(round((end - start) * rate) + 1) / rate + start
    return Log(name, time, {channel.replace("_", "."): signal(time) for channel, signal in channels.items()})


def test_logs_of_three_rates_agree_on_the_time_they_share():
    body = sampled("body", 0.0, 4.0, 200.0, q_knee=motion)
    imu = sampled("imu", 0.5, 4.3, 333.0, acc_x=motion)
    foot = sampled("foot", -0.2, 3.9, 1000.0, ft_l_fx=motion)
    both = to_common_clock([body, imu, foot], 100.0, "all")
    assert (both.name, both.rate_hz) == ("all", pytest.approx(100.0))
    assert both.time[0] == 0.5
    assert 3.9 - 0.01 < both.time[-1] <= 3.9
    inner = slice(10, -10)  # a tenth of a second: the anti-alias filter's ends
    for channel, values in both.channels.items():
        np.testing.assert_allclose(values[inner], motion(both.time)[inner], atol=3e-3, err_msg=channel)


def test_the_fastest_log_sets_the_rate_when_none_is_asked_for():
    both = to_common_clock([sampled("a", 0, 2, 50.0, q_a=motion), sampled("b", 0, 2, 250.0, q_b=motion)], None, "ab")
    assert both.rate_hz == pytest.approx(250.0)
    np.testing.assert_allclose(both.channels["q.b"], motion(both.time), atol=1e-9)
    np.testing.assert_allclose(both.channels["q.a"][15:-15], motion(both.time)[15:-15], atol=2e-3)


def test_what_the_new_rate_cannot_hold_is_removed_instead_of_folded():
    buzz = sampled("buzz", 0.0, 5.0, 1000.0, i_a=lambda t: np.sin(2 * np.pi * 97.0 * t))
    slow = to_common_clock([buzz], 100.0, "slow")
    assert np.std(slow.channels["i.a"][20:-20]) < 1e-3


def test_jittered_stamps_are_believed():
    rng = np.random.default_rng(0)
    time = np.cumsum(rng.uniform(0.002, 0.0036, 3000))
    log = Log("jittered", time, {"q.a": motion(time)})
    assert not is_even(log.time)
    even = uniform(log)
    assert is_even(even.time)
    assert even.time[-1] <= time[-1]
    np.testing.assert_allclose(even.channels["q.a"], motion(even.time), atol=1e-5)


def test_an_even_log_is_left_alone_even_if_its_stamps_were_rounded():
    time = np.round(np.arange(1000) / 300.0, 6)
    log = Log("printed", time, {"q.a": motion(time)})
    assert uniform(log) is log
    assert uniform(log, 100.0).rate_hz == pytest.approx(100.0)


def test_a_short_gap_is_bridged_and_a_long_one_refused_by_name_and_time():
    log = sampled("log", 0.0, 5.0, 100.0, q_a=motion, q_b=motion)
    keep = np.ones(log.samples, dtype=bool)
    keep[200:203] = False
    holed = Log("holed", log.time[keep], {name: values[keep] for name, values in log.channels.items()})
    np.testing.assert_allclose(uniform(holed).channels["q.a"], motion(log.time), atol=2e-3)

    torn = {name: values.copy() for name, values in log.channels.items()}
    torn["q.b"][300:340] = np.nan
    with pytest.raises(BadLog, match=r"q\.b.*0\.41 s from t = 2\.99 s") as caught:
        to_common_clock([Log("torn", log.time, torn)], 100.0, "torn")
    assert (caught.value.faults[0].row, caught.value.faults[0].column) == (300, "q.b")
    assert uniform(Log("torn", log.time, torn), 50.0, longest_gap_s=0.5).samples == 251


@pytest.mark.parametrize("lost", [slice(0, 50), slice(-50, None), slice(None)])
def test_nothing_is_extrapolated(lost):
    log = sampled("log", 0.0, 2.0, 100.0, q_a=motion, q_b=motion)
    log.channels["q.b"][lost] = np.nan
    with pytest.raises(BadLog, match=r"q\.b"):
        to_common_clock([log], 100.0, "log")


def test_a_quaternion_stays_one_rotation_when_its_sign_flips():
    time = np.arange(300) / 100.0
    half = 0.4 * np.sin(time)
    names = ("base.qx", "base.qy", "base.qz", "base.qw")
    sign = np.where(np.arange(300) % 7 < 3, -1.0, 1.0)
    parts = (sign * np.sin(half), 0 * time, 0 * time, sign * np.cos(half))
    fine = uniform(Log("base", time, dict(zip(names, parts, strict=True))), 400.0)
    np.testing.assert_allclose(np.linalg.norm(fine.stack(names), axis=1), 1.0, atol=1e-12)
    angle = 2 * np.arctan2(fine.channels["base.qx"], fine.channels["base.qw"])
    np.testing.assert_allclose(np.sin(angle), np.sin(0.8 * np.sin(fine.time)), atol=1e-6)


def test_clocks_without_common_time_and_channels_held_twice_are_refused():
    early, late = sampled("early", 0, 1, 100.0, q_a=motion), sampled("late", 5, 6, 100.0, q_b=motion)
    with pytest.raises(BadLog, match="already ended"):
        to_common_clock([early, late], None, "none")
    with pytest.raises(BadLog, match="also in"):
        to_common_clock([early, early], None, "twice")
