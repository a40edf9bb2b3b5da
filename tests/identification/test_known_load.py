"""A weighed load in some logs of an arm that logs currents alone: it fixes the factor that they leave open."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin
import pytest

from exogauge.estimation.least_squares import PriorLeastSquares
from exogauge.estimation.prior import Prior
from exogauge.estimation.statistics import Statistics
from exogauge.identification.identify import identify
from exogauge.identification.settings import Recording, Settings
from exogauge.plausibility.examine import examine_against_robot
from exogauge.remarks import About, Remark
from exogauge.robots.description import KnownLoad
from exogauge.support.balance import balance

OPEN = Remark(About.FACTOR_OPEN)

SETTINGS = Settings(cutoff_hz=10.0, prior_strength=1.0, consistency="free")
MASS, STD = 5.0, 0.005  # [kg] as weighed
OFF = np.array([1.25, 0.8, 1.1])  # stated k_T over the true one
DRAWS = 24


@dataclass
class Arm:
    """truth: with nothing in its hand. loaded: with what is weighed there, off its flange. robot: as its maker says."""

    truth: object
    loaded: object
    robot: object


def in_hand(truth, mass):
    body = pin.Inertia(mass, np.array([0.01, 0.02, 0.06]), np.diag([0.01, 0.012, 0.008]))
    phi = truth.phi.copy()
    phi[-1] += body.toDynamicParameters()
    return replace(truth, phi=phi)


def stated(truth, off):
    joints = tuple(
        replace(joint, prior={"k_T": k * each}, prior_std={"k_T": 0.3 * k})
        for joint, k, each in zip(truth.robot.joints, truth.xi["k_T"], off, strict=True)
    )
    return replace(truth.robot, joints=joints)


def carrying(robot, *logs, mass=MASS, std=STD, **more):
    load = {"name": "l3", "centre": (0.0, 0.0, 0.0), "std_centre": 0.1} | more
    return replace(robot, loads=(KnownLoad(body=2, mass=mass, std=std, logs=tuple(logs), **load),))


def gains(truth, found):
    named = {each.name: each for each in found.parameters}
    own = [named[f"k_T[{joint.name}]"] for joint in truth.robot.joints]
    return np.array([p.value for p in own]) - truth.xi["k_T"], np.array([p.std for p in own])


@pytest.fixture(scope="module")
def found():
    """name -> identification, made once."""
    return {}


@pytest.fixture
def arm(make_truth):
    truth = make_truth(False, seed=1)
    return Arm(truth, in_hand(truth, MASS + 0.003), stated(truth, OFF))


@pytest.fixture
def logs(found, arm, make_log):
    """empty, loaded (fitted), held_out (loaded, other motion), always (loaded, motion of empty)."""
    if "logs" not in found:
        made = {
            "empty": (arm.truth, 1),
            "loaded": (arm.loaded, 2),
            "held_out": (arm.loaded, 3),
            "always": (arm.loaded, 1),
        }
        found["logs"] = {
            name: replace(make_log(truth, seed=seed, seconds=12.0, noise=1.0), name=name)
            for name, (truth, seed) in made.items()
        }
    return found["logs"]


@pytest.fixture
def identified(found, arm, logs):
    def of(robot, *names, settings=SETTINGS, key=None):
        key = key or (robot.loads, names, settings.prior_strength, settings.consistency)
        if key not in found:
            recordings = [*(Recording(logs[name], False) for name in names), Recording(logs["held_out"], True)]
            found[key] = identify(robot, recordings, settings)
        return found[key]

    return of


def test_torque_constants_come_out_right_and_several_times_surer(arm, identified):
    with_it = identified(carrying(arm.robot, "loaded", "held_out"), "empty", "loaded")
    without = identified(arm.robot, "empty")
    error, std = gains(arm.truth, with_it)
    assert np.all(np.abs(error) < 2.5 * std)
    assert np.all(np.abs(error) < 0.04 * arm.truth.xi["k_T"])
    assert np.all(std < gains(arm.truth, without)[1] / 4.0)
    assert with_it.factor.known
    assert not with_it.per_stated
    assert OPEN not in with_it.remarks
    assert OPEN in without.remarks


def test_the_open_factor_is_said_once_and_not_as_a_list(arm, identified):
    with_it = identified(carrying(arm.robot, "loaded", "held_out"), "empty", "loaded")
    assert not [name for name in with_it.unidentifiable if name.startswith(("k_T", "load."))]
    without = identified(arm.robot, "empty")
    assert without.remarks.count(OPEN) == 1
    assert not [name for name in without.unidentifiable if name.startswith("k_T")]


def test_a_held_out_log_with_the_load_is_predicted_with_it(arm, identified):
    found = identified(carrying(arm.robot, "loaded", "held_out"), "empty", "loaded")
    fits = [fit for fit in found.validation if fit.log == "held_out"]
    assert all(fit.rmse_moving < 1.1 * fit.noise_floor for fit in fits)
    forgotten = identified(carrying(arm.robot, "loaded"), "empty", "loaded")
    assert max(fit.rmse_moving / fit.noise_floor for fit in forgotten.validation if fit.log == "held_out") > 10.0


def test_nothing_supports_an_arm_that_only_holds_the_known_load(arm, logs, identified):
    """Approach B: what the model leaves unexplained."""
    model = identified(carrying(arm.robot, "loaded", "held_out"), "empty", "loaded").model
    own = balance(model, model.prepare(logs["held_out"]), np.arange(3))
    bare = identified(carrying(arm.robot, "loaded"), "empty", "loaded").model
    forgotten = balance(bare, bare.prepare(logs["held_out"]), np.arange(3))
    for joint in (1, 2):  # the first turns about the vertical
        steady = own.steady[:, joint]
        left, load = (np.sqrt(np.mean(each.torque[steady, joint] ** 2)) for each in (own, forgotten))
        assert left < 0.1 * load
        assert left < 0.02 * arm.truth.xi["k_T"][joint]  # less than 0.02 A, the noise before the low-pass


def test_a_load_in_every_log_fixes_nothing_and_says_so(arm, logs, identified):
    fitted = ("always", "loaded")
    every = identified(carrying(arm.robot, *logs), *fitted)
    described = arm.robot.tree.phi.copy()  # by a maker who draws the load as a part of the link
    described[2] += carrying(arm.robot).loads[0].phi
    drawn = replace(arm.robot, tree=replace(arm.robot.tree, phi=described))
    of_maker = identified(drawn, *fitted, key="drawn").factor.std
    np.testing.assert_allclose(every.factor.std, of_maker, rtol=0.2)
    np.testing.assert_allclose(every.factor.std, identified(arm.robot, "empty").factor.std, rtol=0.2)
    assert not every.factor.known
    assert OPEN in every.remarks
    assert [each.about for each in every.remarks if each.each] == [About.LOAD_IN_EVERY_LOG]
    error, std = gains(arm.truth, every)
    assert np.all(np.abs(error) < 2.5 * std)


def test_a_load_that_no_fitted_log_carries_says_so(arm, identified):
    found = identified(carrying(arm.robot, "held_out"), "empty")
    assert About.LOAD_NOT_FITTED in [each.about for each in found.remarks]
    assert not found.factor.known
    np.testing.assert_allclose(found.factor.std, identified(arm.robot, "empty").factor.std, rtol=1e-3)


def test_a_load_too_light_to_be_felt_says_so(arm, identified):
    """20 g, weighed to 15 g: by the differences of the currents nobody knows a factor."""
    found = identified(carrying(arm.robot, "loaded", mass=0.02, std=0.015), "empty", "loaded")
    assert not found.factor.known
    (told,) = [each for each in found.remarks if each.about == About.LOAD_FELT_TOO_LITTLE]
    assert told.each == ((0.02,),)
    assert told.numbers[1] > 0.5 * told.numbers[0] > 0.0


def test_two_masses_fix_it_as_one_and_none(arm, make_log, logs):
    heavy = replace(make_log(in_hand(arm.truth, 2.0), seed=1, seconds=12.0, noise=1.0), name="light")
    both = (
        KnownLoad("l3", 2, MASS, STD, (0.0, 0.0, 0.0), 0.1, ("loaded",)),
        KnownLoad("l3 2", 2, 2.0, STD, (0.0, 0.0, 0.0), 0.1, ("light",)),
    )
    found = identify(
        replace(arm.robot, loads=both), [Recording(heavy, False), Recording(logs["loaded"], False)], SETTINGS
    )
    error, std = gains(arm.truth, found)
    assert found.factor.known
    assert np.all(np.abs(error) < 2.5 * std)


def test_possible_bodies_keep_the_scale_that_the_load_gives(arm, identified):
    robot = carrying(arm.robot, "loaded", "held_out")
    free = identified(robot, "empty", "loaded")
    possible = identified(robot, "empty", "loaded", settings=replace(SETTINGS, consistency="physical"))
    np.testing.assert_allclose(gains(arm.truth, possible)[0], gains(arm.truth, free)[0], atol=1e-9)
    (mass,) = [each for each in possible.parameters if each.name == "load.m[l3]"]
    assert abs(mass.value - MASS) < 2.0 * STD


@pytest.mark.parametrize("strength", [1e-2, 1e2])
def test_scales_count_as_stated_whatever_strength_the_makers_values_get(arm, identified, strength):
    robot, settings = carrying(arm.robot, "loaded", "held_out"), replace(SETTINGS, prior_strength=strength)
    found = identified(robot, "empty", "loaded", settings=settings)
    (mass,) = [each for each in found.parameters if each.name == "load.m[l3]"]
    assert abs(mass.value - MASS) < STD
    assert found.factor.known
    error, std = gains(arm.truth, found)
    assert np.all(np.abs(error) < 2.5 * std)


@pytest.mark.parametrize("strength", [1e-4, 1.0, 50.0])
def test_the_answer_and_its_doubt_are_those_of_dense_normal_equations(strength):
    """One belief of three was measured: an observation among others, beside a prior that counts `strength` times."""
    rng = np.random.default_rng(3)
    A, y, w = rng.normal(size=(40, 3)), rng.normal(size=40), 4.0
    mean, std = np.array([1.0, -2.0, 0.5]), np.array([0.5, 2.0, 0.1])
    D = np.array([[1.0, 0.4, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    prior = Prior(mean, std, D, np.array([False, False, True]))
    statistics = Statistics.empty(3, [np.arange(3)], "gram")
    statistics.add_rows(0, np.asfortranarray(np.column_stack([A, y])))
    solved = PriorLeastSquares(statistics.square_root(np.array([w])), prior, strength)
    P = np.linalg.inv(D @ np.diag(std**2) @ D.T)
    S = np.diag([strength, strength, 1.0])
    H = w * A.T @ A + S @ P
    np.testing.assert_allclose(solved.x, np.linalg.solve(H, w * A.T @ y + S @ P @ D @ mean), rtol=1e-9)
    doubt = np.linalg.inv(H) @ (w * A.T @ A + S @ P @ S) @ np.linalg.inv(H)
    np.testing.assert_allclose(solved.covariance(), doubt, rtol=1e-8)


@pytest.mark.slow
def test_the_doctor_takes_no_offence_at_a_load_that_was_stated(arm, logs):
    heavy = replace(arm.robot, joints=stated(arm.truth, np.ones(3)).joints)
    told = [found.rule for _, found in examine_against_robot(carrying(heavy, "loaded", mass=MASS), [logs["loaded"]])]
    assert told == []


@pytest.mark.slow
def test_intervals_hold_over_arms_makers_and_weighings(make_truth, make_log):
    z = []
    for seed in range(DRAWS):
        truth, rng = make_truth(False, seed=seed), np.random.default_rng([seed, 9])
        robot = stated(truth, rng.uniform(0.7, 1.3, 3))
        held = in_hand(truth, MASS + STD * rng.normal())
        pair = [make_log(each, seed=10 * seed + k, seconds=12.0, noise=1.0) for k, each in enumerate((truth, held))]
        found = identify(carrying(robot, pair[1].name), [Recording(log, False) for log in pair], SETTINGS)
        error, std = gains(truth, found)
        z.append(error / std)
    z = np.array(z)
    assert np.mean(np.abs(z) < 2.0) > 0.87  # of 72; 0.95 ± 0.026 if they were independent
    assert 0.7 < np.sqrt(np.mean(z**2)) < 1.3
    assert np.all(np.abs(z.mean(axis=0)) < 3.0 / np.sqrt(DRAWS))
