"""Turns, rests and loads of logs that were low-passed before they were stored; loads are pinocchio's."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import butter, sosfilt, sosfiltfilt
from tests.sensor_arm import describe, record, true_phi, wrist

from exogauge.effects.catalogue import choose
from exogauge.identification.added_columns import zero_columns
from exogauge.identification.equations import Equations
from exogauge.identification.predict import Parameters, predictions
from exogauge.identification.preparation import prepare
from exogauge.identification.settings import Settings
from exogauge.identification.turns import RestDetection, TurnsOf
from exogauge.logs.filtering import StoredPass
from exogauge.logs.model import Log
from exogauge.robots.cuts import CutRows
from exogauge.robots.parameters import find_base_parameters
from exogauge.robots.row_blocks import RowBlocks

RATE = 200.0
SHAPES = [StoredPass(2.0, 1, True), StoredPass(4.0, 3, True), StoredPass(3.0, 2, False)]
INSIDE = slice(200, -200)
NAMES = ("j1", "j2")
REST = RestDetection(40.0, np.full(2, 2e-3), np.zeros(2))


def waves(t):
    """(T, 2) positions, velocities, accelerations."""
    w, shift = (
        2 * np.pi * np.array([[0.11, 0.17], [0.43, 0.31], [0.9, 1.2]]),
        np.array([[0.0, 1.0], [2.0, 0.4], [1.0, 3.0]]),
    )
    size, angle = np.array([[0.6, 0.5], [0.3, 0.4], [0.08, 0.05]]), t[:, None, None] * w + shift
    return (
        np.sum(size * np.sin(angle), axis=1),
        np.sum(size * w * np.cos(angle), axis=1),
        -np.sum(size * w**2 * np.sin(angle), axis=1),
    )


def passed(stored, values):
    sections = butter(stored.order, stored.hz, fs=RATE, output="sos")
    return (sosfilt if stored.late else sosfiltfilt)(sections, values - values[0], axis=0) + values[0]


def low_passed(q, stored):
    channels = {f"q.{name}": q[:, j] for j, name in enumerate(NAMES)} | {f"tau.{name}": 0.0 * q[:, 0] for name in NAMES}
    return Log("log", np.arange(len(q)) / RATE, {name: passed(stored, x) for name, x in channels.items()})


@pytest.fixture
def arm(make_truth):
    return make_truth(False, joints=2, actuation="torque")


@pytest.mark.parametrize("stored", SHAPES)
def test_friction_turns_round_when_the_joint_did_not_when_what_is_left_of_it_did(arm, stored):
    q, v, _ = waves(np.arange(6000) / RATE)
    turns = TurnsOf(arm.robot, low_passed(q, stored), REST)
    true = passed(stored, np.sign(v))
    unaware = stored.apply(turns.behind(None).direction, RATE)
    left, left_unaware = (
        np.sqrt(np.mean((each - true)[INSIDE] ** 2)) for each in (turns.behind(stored).stored_direction, unaware)
    )
    assert left < 0.006
    assert left < 0.5 * left_unaware


@pytest.mark.parametrize("stored", SHAPES)
def test_a_turn_at_a_sample_is_taken_for_the_mean_of_before_and_after(arm, stored):
    t = np.arange(4000) / RATE
    q = np.column_stack([np.cos(0.8 * (t - 10.0)), np.cos(0.5 * (t - 10.0))])
    found = TurnsOf(arm.robot, low_passed(q, stored), REST).behind(stored).stored_direction
    earlier, later = (passed(stored, np.where(t < 10.0 + at / RATE, 1.0, -1.0)) for at in (-0.5, 0.5))
    near = slice(1900, 2100)
    for each in found[near].T:
        np.testing.assert_allclose(each, 0.5 * (earlier + later)[near], atol=1e-3)


@pytest.mark.parametrize("stored", SHAPES)
def test_a_rest_is_seen_and_a_slow_turn_is_none(arm, stored):
    """The first joint stands still for a second; the second one turns so slowly that it is below its threshold for a
    tenth of that."""
    t = np.arange(4000) / RATE
    stop = np.clip(t - 8.0, 0.0, None) - np.clip(t - 9.0, 0.0, None)
    q = np.column_stack([np.sin(0.9 * (t - stop)), 0.02 * (t - 10.0) ** 2])
    turns = TurnsOf(arm.robot, low_passed(q, stored), REST).behind(stored)
    late = round(stored.delay_s(RATE) * RATE)
    resting = np.flatnonzero(turns.direction[INSIDE, 0] == 0.0) + INSIDE.start - late
    assert abs(resting[0] - 8.0 * RATE) < 0.3 * RATE
    assert abs(resting[-1] - 9.0 * RATE) < 0.3 * RATE
    assert np.all(turns.direction[INSIDE, 1] != 0.0)


@pytest.mark.parametrize("stored", SHAPES)
def test_the_load_of_low_passed_motion_is_made_up_to_the_low_passed_load(arm, stated_loads, stored):
    q, v, a = waves(np.arange(6000) / RATE)
    prepared = prepare(arm.robot, replace(low_passed(q, stored), stored=stored), 10.0, REST)
    left = passed(stored, stated_loads(q, v, a)) - stated_loads(*(passed(stored, each) for each in (q, v, a)))
    lacking = (left - prepared.smeared)[INSIDE]
    assert np.all(np.std(lacking, axis=0) < 0.1 * np.std(left[INSIDE], axis=0).max())


def test_a_log_that_nothing_low_passed_lacks_nothing(arm):
    q, _, _ = waves(np.arange(2000) / RATE)
    assert not prepare(arm.robot, low_passed(q, SHAPES[0]), 10.0, REST).smeared.any()


@pytest.mark.parametrize("stored", SHAPES)
def test_a_low_passed_load_is_explained_by_rows_and_by_predictions_with_its_smear(arm, stated_loads, stored):
    """At the true parameters, of the bodies as stated and no friction, nothing is left; without the smear, some is."""
    q, v, a = waves(np.arange(6000) / RATE)
    log = low_passed(q, stored)
    torque = passed(stored, stated_loads(q, v, a))
    channels = {**log.channels, **{f"tau.{name}": torque[:, j] for j, name in enumerate(NAMES)}}
    prepared = prepare(arm.robot, replace(log, channels=channels, stored=stored), 10.0, REST)
    base = find_base_parameters(arm.robot.tree)
    rows = RowBlocks(arm.robot.tree, base, arm.robot.axes_from_joints)
    equations = Equations(arm.robot, rows, base, choose(Settings().effects))
    xi = np.zeros((2, len(equations.effects)))
    xi[:, [effect.name for effect in equations.effects].index("motor_gain")] = 1.0
    x = np.concatenate([base.regroup @ arm.robot.tree.phi.ravel(), xi.ravel()])
    truth = Parameters(arm.robot.tree.phi, xi)

    def left(of):
        used = slice(40, -40)  # of the kept samples, away from what filters do at the ends
        residual = equations.residuals(of, x)[used, :2]
        predicted = predictions(equations, of, [truth])[0]
        apart = np.column_stack([predicted[f"tau.{name}"] for name in NAMES]) - torque
        return np.std(residual[np.abs(residual).max(axis=1) > 0.0]), np.std(apart[INSIDE])

    explained, without = left(prepared), left(replace(prepared, smeared=0.0 * prepared.smeared))
    assert explained[0] < 0.2 * without[0]
    assert explained[1] < 0.2 * without[1]


def test_a_low_passed_reading_of_a_sensor_inside_is_explained_with_its_smear(tmp_path):
    """Bodies are off by a tenth from what is stated, and so is the smear: a good part of it has to go all the same."""
    stored, sensor = StoredPass(2.0, 2, False), wrist()
    robot, log = describe(tmp_path, [sensor]), record(5, [sensor], 20.0, noise=0.0)
    channels = {name: filtered(values, 2.0, log.rate_hz) for name, values in log.channels.items()}
    at_rest = RestDetection(40.0, np.full(len(robot.joints), 2e-3), np.zeros(len(robot.joints)))
    prepared = prepare(robot, replace(log, channels=channels, stored=stored), 6.0, at_rest)
    base = find_base_parameters(robot.tree)
    cuts = [CutRows(robot.tree, base, each.frame) for each in robot.cuts]
    rows = RowBlocks(robot.tree, base, robot.axes_from_joints)
    equations = Equations(robot, rows, base, choose(Settings().effects), tuple(zero_columns(robot)), cuts)
    x = np.zeros(equations.size)
    x[: equations.base_size] = base.regroup @ true_phi(robot.tree.bodies, [sensor.frame]).ravel()
    x[-6:] = sensor.zero

    def left(of):
        return np.std(equations.residuals(of, x)[60:-60, equations.layout.sensors], axis=0)

    explained, without = left(prepared), left(replace(prepared, smeared=0.0 * prepared.smeared))
    assert np.all(explained < 0.5 * without)


def filtered(values, hz, rate_hz):
    sections = butter(2, hz, fs=rate_hz, output="sos")
    return sosfiltfilt(sections, values - values[0]) + values[0]
