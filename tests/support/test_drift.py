"""Motors that warm up between the logs: found from the runs before and after, and taken off what lies between."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from exogauge.criteria.identifying import DECLARED
from exogauge.criteria.supporting import Supporting
from exogauge.identification.session import courses
from exogauge.robots.description import Declared
from exogauge.support.balance import balance
from exogauge.support.coloured import by_autocovariance, of_one_log
from exogauge.support.drift import Drift, Runs, find_drift, told_by
from exogauge.support.evaluate import estimate_support
from exogauge.support.settings import PlainLog, SupportSettings, WornLog

SIZE, EVERY = 0.02, np.arange(6)
STARTS = {"fit": 0.0, "before1": 600.0, "before2": 640.0, "worn1": 1300.0, "worn2": 1420.0, "after1": 2200.0,
          "after2": 2240.0}  # fmt: skip
CONSTANT_S = 900.0
EACH = np.array([1.0, 0.6, 1.4, 0.8, 0.5, 1.2])  # of SIZE by the end, motor by motor


def warm(time_s):
    """From cold to 2240 s; first order, with a time constant that the estimate does not know."""
    return np.expm1(-time_s / CONSTANT_S) / np.expm1(-2240.0 / CONSTANT_S)


def drifted(log, share):
    """Motors give (1 + share) k_T i: as much less current."""
    own = {name: log.channels[name] / (1.0 + share[k]) for k, name in enumerate(f"i.{j}" for j in JOINTS)}
    return replace(log, channels={**log.channels, **own})


JOINTS = ("r_hip", "torso_pitch", "l_knee", "torso_yaw", "l_hip", "r_knee")


@pytest.fixture(scope="module")
def model(biped):
    """True but for k_T, which is 1 to 3 % off, as much in every log: a motor that drifts is not one of a wrong gain."""
    off = 1.0 + np.array([0.01, -0.02, 0.03, 0.01, -0.01, 0.02])
    declared = replace(biped, robot=replace(biped.robot, declared=Declared(kt_drift=SIZE)))
    return declared.known(k_T=biped.xi["k_T"] * off)


@pytest.fixture(scope="module")
def clean(biped, suit, recorded):
    """Logs of motors that stay as they are."""
    return recorded(biped, suit, STARTS)


def asked(clean, suit, sign):
    """(logs without, logs with) as they are when motors warm up by `sign` times SIZE."""
    spoilt = {name: drifted(log, sign * SIZE * EACH * warm(STARTS[name])) for name, log in clean.items()}
    plain = [PlainLog(spoilt[name], "stoop", name != "fit") for name in STARTS if "worn" not in name]
    return plain, [WornLog(spoilt[name], "stoop", suit) for name in STARTS if "worn" in name]


def found(model, plain, worn, started=STARTS):
    balances = {each.log.name: balance(model, model.prepare(each.log), EVERY) for each in plain}
    return find_drift(model, plain, [each.log for each in worn], balances, started)


def spread(drift, log, other):
    """(A, K) doubt of what a motor does between two logs."""
    return np.linalg.norm(np.concatenate(drift.inputs(log), 2) - np.concatenate(drift.inputs(other), 2), axis=2)


@pytest.mark.slow
def test_a_drift_that_is_known_is_taken_off_to_the_last_digit(biped, clean):
    model, share = biped.known(), SIZE * EACH
    log = clean["worn1"]
    drift = Drift(
        ("kt_drift",), {log.name: 0}, np.ones((1, 1)), share[:, None, None], np.zeros((6, 1, 1)), np.zeros((6, 1, 1)),
        np.ones(6, dtype=bool),
    )  # fmt: skip
    spoilt = balance(model, model.prepare(drifted(log, share)), EVERY)
    as_it_was = balance(model, model.prepare(log), EVERY).torque
    assert np.abs(spoilt.torque - as_it_was).max() > 0.5
    np.testing.assert_allclose(drift.without(model, spoilt).torque, as_it_was, atol=1e-9)


def test_what_is_left_in_doubt_of_it_is_what_it_takes_off_per_standard_deviation(any_biped, stoop):
    """Of several drifts that are not told apart: all that one input does, whatever it is counted as."""
    declared = Declared(kt_drift=SIZE, viscous_drift=0.1, coulomb_drift=0.05)
    model = replace(any_biped, robot=replace(any_biped.robot, declared=declared)).known()
    log, rng = any_biped.record(stoop(1), "one").log, np.random.default_rng(0)
    root, common = np.tril(rng.normal(size=(6, 6, 6))), rng.normal(size=(6, 6, 6))
    names = ("kt_drift", "viscous_drift", "coulomb_drift")
    drift = Drift(names, {"one": 0}, rng.normal(size=(1, 2)), np.zeros((6, 3, 2)), root, common, np.ones(6, dtype=bool))
    own, samples = balance(model, model.prepare(log), EVERY), np.arange(50, 400, 10)
    doubt = drift.doubt(model, own.prepared, samples, EVERY)
    for axis, column in ((1, 0), (1, 3), (3, 5), (3, 2)):
        moved = np.where(np.arange(6)[:, None] == axis, root[axis, :, column], 0.0).reshape(6, 3, 2)
        change = own.torque - replace(drift, beta=moved).without(model, own).torque
        found = doubt[names[column // 2]][:, :, 2 * axis + column % 2]
        assert np.abs(found).max() > 0.01
        np.testing.assert_allclose(found, change[samples], rtol=1e-5, atol=1e-6)
    for column in (1, 4):
        change = own.torque - replace(drift, beta=common[:, :, column].reshape(6, 3, 2)).without(model, own).torque
        found = doubt[names[column // 2]][:, :, 12 + column % 2]
        np.testing.assert_allclose(found, change[samples], rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_runs_before_and_after_tell_how_far_motors_have_warmed_between(model, clean, suit, sign):
    """The time constant is none of those that are believed in, and k_T is wrong beside."""
    plain, worn = asked(clean, suit, sign)
    drift = found(model, plain, worn)
    pitch = JOINTS.index("torso_pitch")  # what the stoop loads
    for name in ("worn1", "worn2"):
        log = clean[name]
        since = warm(STARTS[name]) - warm(STARTS["before1"])
        told = (drift.share(log) - drift.share(clean["before1"]))[:, 0]
        truth = sign * SIZE * EACH * since
        std = spread(drift, log, clean["before1"])[:, 0]
        assert np.all(np.abs(told - truth) < 3.0 * std)
        assert abs(told[pitch] - truth[pitch]) < 0.15 * SIZE, (told[pitch], truth[pitch])
        assert std[pitch] < 0.2 * SIZE


def test_the_order_in_which_logs_are_listed_does_not_matter(model, clean, suit):
    plain, worn = asked(clean, suit, -1.0)
    one, other = found(model, plain, worn), found(model, plain[::-1], worn[::-1])
    for log in clean.values():
        np.testing.assert_allclose(one.share(log), other.share(log), atol=1e-9)


def test_a_session_that_ran_the_other_way_round_is_told_as_it_was(model, clean, suit):
    """First cooled, recorded from the last log to the first: the runs say so, no sign is presumed."""
    plain, worn = asked(clean, suit, -1.0)
    back = {name: 2240.0 - each for name, each in STARTS.items()}
    drift, pitch = found(model, plain, worn, back), JOINTS.index("torso_pitch")
    told = (drift.share(clean["worn1"]) - drift.share(clean["after1"]))[:, 0]
    truth = -SIZE * EACH * (warm(STARTS["worn1"]) - warm(STARTS["after1"]))
    std = spread(drift, clean["worn1"], clean["after1"])[:, 0]
    assert abs(told[pitch] - truth[pitch]) < 3.0 * std[pitch] + 1e-4


@pytest.fixture(scope="module")
def warmed(biped, suit, stoop):
    """Logs of drives that rub less as they warm: viscous friction by 10 % by the end, Coulomb by half of it."""

    def of_log(k, name):
        less = 0.1 * EACH * warm(STARTS[name])
        xi = biped.xi | {"k_d": biped.xi["k_d"] * (1.0 - less), "tau_c": biped.xi["tau_c"] * (1.0 - 0.5 * less)}
        bands = suit.bands if "worn" in name else ()
        return replace(biped, xi=xi).record(stoop(k), name, bands, noise=1.0, seed=k).log

    return {name: of_log(k, name) for k, name in enumerate(STARTS)}


RUBS = Declared(kt_drift=SIZE, viscous_drift=0.1, coulomb_drift=0.05)


@pytest.mark.slow
def test_drives_that_rub_less_as_they_warm_are_told_from_motors_that_give_more(biped, warmed, suit):
    model = replace(biped, robot=replace(biped.robot, declared=RUBS)).known()
    plain = [PlainLog(warmed[name], "stoop", name != "fit") for name in STARTS if "worn" not in name]
    worn = [WornLog(warmed[name], "stoop", suit) for name in STARTS if "worn" in name]
    drift, pitch = found(model, plain, worn), JOINTS.index("torso_pitch")
    assert drift.names == ("kt_drift", "viscous_drift", "coulomb_drift")
    for name in ("worn1", "worn2"):
        told = drift.share(warmed[name]) - drift.share(warmed["before1"])
        truth = np.multiply.outer(EACH * (warm(STARTS["before1"]) - warm(STARTS[name])), [0.0, 0.1, 0.05])
        std = spread(drift, warmed[name], warmed["before1"])
        assert np.all(np.abs(told - truth) < 3.0 * std)
        rubs = np.array([0.0, biped.xi["k_d"][pitch] * 0.4, biped.xi["tau_c"][pitch]])  # at a usual speed [rad/s]
        assert abs(rubs @ (told - truth)[pitch]) < 0.3 * abs(rubs @ truth[pitch])
        assert abs(told[pitch, 0]) < 0.1 * SIZE


@pytest.mark.slow
@pytest.mark.parametrize("untold", ["fit", "worn2", "after1"])
def test_where_a_log_does_not_say_when_it_began_nothing_is_corrected(model, clean, suit, untold):
    plain, worn = asked(clean, suit, -1.0)
    started = {name: each for name, each in STARTS.items() if name != untold}
    assert found(model, plain, worn, started) is None
    as_today, less = (estimate_support(model, plain, worn, SupportSettings(started=each))[1] for each in ({}, started))
    assert [each.bands for each in as_today] == [each.bands for each in less]


def test_runs_without_the_device_alone_leave_all_that_is_declared_in_doubt(model, clean, suit):
    plain, worn = asked(clean, suit, -1.0)
    once = [each for each in plain if each.log.name in ("fit", "before1")]
    session = [each.log.name for each in (*once, *worn)]
    drift = found(model, once, worn, {name: STARTS[name] for name in session})
    assert not drift.told.any()
    np.testing.assert_array_equal(drift.beta, 0.0)
    np.testing.assert_allclose(drift.std, SIZE, rtol=0.1)


@pytest.mark.slow
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_the_stiffness_is_that_of_motors_that_stay_as_they_are_and_is_doubted_less(model, clean, suit, sign):
    unknown = replace(suit, bands=tuple(replace(b, stiffness=None, natural_length=None) for b in suit.bands))

    def stiffness(sign, started):
        found = estimate_support(model, *asked(clean, unknown, sign), SupportSettings(started=started))[1]
        return {each.approach: each.bands[0].stiffness for each in found}

    steady, today, told = stiffness(0.0, {}), stiffness(sign, {}), stiffness(sign, STARTS)
    for approach in ("A", "paired"):
        off = abs(told[approach].value - steady[approach].value)
        assert told[approach].parts["kt_drift"] < 0.5 * today[approach].parts["kt_drift"]
        assert off < 2.0 * told[approach].std
        assert off < 0.5 * abs(today[approach].value - steady[approach].value)


@pytest.mark.slow
def test_a_share_in_between_is_doubted_as_it_errs():
    """Motors of any time constant that is believed in, seen before and after with some error: errors over their
    doubt."""
    rng, z = np.random.default_rng(1), []
    starts = np.array([30.0, 600.0, 700.0, 1300.0, 2200.0, 2300.0])
    fitted, runs = np.arange(6) == 0, np.array([1, 2, 4, 5])
    course = courses(starts, 2320.0)
    course = course - course[fitted].mean(axis=0)
    R = course.shape[1]
    for _ in range(2000):
        truth = SIZE * course @ rng.normal(size=R) / np.sqrt(R)
        seen = truth[runs] + 0.05 * rng.normal() + 0.001 * rng.normal(size=4)
        told = Runs(course[runs], ["a"] * 4, seen[:, None], np.full((4, 1, 1), 1e-6))
        beta, *roots = told_by([told], np.full((1, 1, R), SIZE / np.sqrt(R)), Supporting())
        change = course[3] - course[1]
        std = np.linalg.norm([each[0].T @ change for each in roots])
        z.append((change @ beta[0, 0] - (truth[3] - truth[1])) / std)
    assert len(DECLARED.warming_s) == R
    assert 0.93 < np.mean(np.abs(z) < 1.96) < 0.97 + 0.02
    assert abs(np.mean(z)) < 0.1


@pytest.mark.slow
@pytest.mark.parametrize("alike", [0.0, DECLARED.motors_alike, 1.0])
def test_motors_that_no_run_tells_of_are_believed_to_warm_as_those_that_are_told(alike):
    """Four of six are told, by runs that err; in the sum of the other two all motors' common warming counts twice."""
    rng, R, runs = np.random.default_rng(2), len(DECLARED.warming_s), np.array([1, 2, 4, 5])
    course = courses(np.array([30.0, 600.0, 700.0, 1300.0, 2200.0, 2300.0]), 2320.0)
    course, size = course - course[0], SIZE / np.sqrt(R)
    change, z, errors, sums = course[3] - course[1], [], [], []
    for _ in range(1000):
        common, own = rng.normal(size=R), rng.normal(size=(6, R))
        truth = size * (np.sqrt(alike) * common + np.sqrt(1.0 - alike) * own)
        seen = truth @ course[runs].T + 0.05 * rng.normal(size=(6, 1)) + 0.002 * rng.normal(size=(6, 4))
        told = [Runs(course[runs], ["a"] * 4, each[:, None], np.full((4, 1, 1), 4e-6)) for each in seen[:4]]
        beta, root, shared = told_by([*told, None, None], np.full((6, 1, R), size), Supporting())
        off = (beta[:, 0] - truth) @ change
        std = np.hypot(np.linalg.norm(change @ root, axis=1), np.linalg.norm(change @ shared, axis=1))
        both = np.linalg.norm([*(change @ root[4:]), change @ (shared[4] + shared[5])])
        z.append(off / std)
        errors.append((off[4:], truth[4:] @ change))
        sums.append(off[4:].sum() / np.linalg.norm(both))
    told_off, untold_off = np.std(np.array(z)[:, :4]), np.std(np.array(z)[:, 4:])
    off, size_of_truth = np.std(np.array(errors), axis=(0, 2))
    if alike == DECLARED.motors_alike:
        assert 0.93 < told_off < 1.07
        assert 0.93 < untold_off < 1.07
        assert 0.93 < np.std(sums) < 1.07
        assert off < 0.9 * size_of_truth
    if alike == 1.0:
        assert off < 0.6 * size_of_truth
        assert max(told_off, untold_off, np.std(sums)) < 1.07
    if alike == 0.0:
        assert untold_off < 1.5, untold_off


def test_what_a_log_says_of_a_drive_is_never_known_better_than_by_errors_that_do_not_last():
    """Two columns that are nearly alike, and errors whose memory is cut off: a sum of theirs was known to less than
    nothing, and moved a drive's friction by 97 %."""
    time = np.arange(400) / 50.0
    slow = np.sin(0.9 * time)
    columns = np.stack([slow, slow + 0.02 * np.sin(9.0 * time)], axis=1)[:, None, :]
    errors = (np.sin(2.0 * time) + 0.1 * np.random.default_rng(0).normal(size=400))[:, None]
    counts = np.ones((400, 1), dtype=bool)
    cut_off = by_autocovariance((slice(0, 400),), counts, errors, columns)
    assert np.linalg.eigvalsh(cut_off)[0] < 0.0
    alone = np.mean(errors**2) * columns[:, 0].T @ columns[:, 0]
    found = of_one_log(counts, errors, columns)
    assert np.linalg.eigvalsh(found - alone)[0] > -1e-9 * np.trace(alone)
    assert np.linalg.eigvalsh(found - cut_off)[0] > -1e-9 * np.trace(alone)


@pytest.mark.parametrize(("sizes", "followed"), [(0.8, True), (-0.8, True), (5.0, False), (-30.0, False)])
def test_repetitions_that_differ_by_far_more_than_is_declared_tell_of_no_motor(sizes, followed):
    """A joint's friction is another in each repetition where it creeps, and what a run says of its motor is as sure as
    noise lets it be."""
    starts = np.array([30.0, 600.0, 2200.0])
    course = courses(starts, 2320.0)
    course, R = course - course[0], course.shape[1]
    seen = np.array([0.0, sizes * SIZE])
    told = Runs(course[[1, 2]], ["a"] * 2, seen[:, None], np.full((2, 1, 1), (0.05 * SIZE) ** 2))
    beta, *roots = told_by([told], np.full((1, 1, R), SIZE / np.sqrt(R)), Supporting())
    change = course[2] - course[1]
    moved, std = change @ beta[0, 0], np.linalg.norm([each[0].T @ change for each in roots])
    if followed:
        assert moved == pytest.approx(seen[1], abs=0.1 * SIZE)
        assert std < 0.1 * SIZE
    else:
        assert abs(moved) < SIZE
        assert abs(moved) < 2.0 * std


@pytest.mark.parametrize("seed", range(5))
def test_a_joint_that_creeps_tells_nothing_of_how_its_friction_drifts(seed):
    """Below the speed at which friction turns round there is a hundredth of Coulomb's, more or less in each repetition
    as it is faster or slower, and a motion of the same speeds finds it again to a thousandth of what is modelled."""
    rng, course = np.random.default_rng(seed), courses(np.array([0.0, 600.0, 1300.0, 2240.0]), 2320.0)
    left = np.exp(rng.normal(np.log(0.02), 0.6, (6, 4))) * np.array([1.0, 1.1, 0.5, 0.45])  # in all joints alike
    runs = [Runs(course, ["a"] * 4, (each - 1.0)[:, None], np.full((4, 1, 1), 0.001**2)) for each in left]
    beta, root, common = told_by(runs, np.full((6, 1, course.shape[1]), 0.05 / np.sqrt(course.shape[1])), Supporting())
    moved = np.einsum("akr,r->ak", beta, course[-1])
    of_inputs = [np.einsum("r,ars->as", course[-1], each) for each in (root, common)]
    std = np.linalg.norm(np.concatenate(of_inputs, axis=1), axis=1)
    assert np.all(np.abs(moved[:, 0]) < 2.0 * std)
    assert np.all(std > 0.03)


@pytest.mark.parametrize("there", [0.4, 1.0, 2.0])
def test_a_drift_is_a_share_of_what_is_there(there):
    course = courses(np.array([0.0, 600.0, 1300.0, 2240.0]), 2320.0)
    R, true = course.shape[1], -0.02
    seen = there * (1.0 + true * course.mean(axis=1)) - 1.0
    told = Runs(course, ["a"] * 4, seen[:, None], np.full((4, 1, 1), 1e-8))
    beta, *_ = told_by([told], np.full((1, 1, R), 0.1 / np.sqrt(R)), Supporting())
    change = course[-1] - course[0]
    assert float(beta[0, 0] @ change) == pytest.approx(true * float(change.mean()), rel=0.02)
