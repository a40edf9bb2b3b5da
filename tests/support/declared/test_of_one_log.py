"""What one log has by itself, or drifts through a session: motors, friction, zeros of feet."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.support.declared.conftest import DECLARED, EVERY, FORCES, STARTED, astray, changed, identified

from exogauge.criteria.identifying import DECLARED as DEFAULT_DOUBTS
from exogauge.support.balance import balance, of_this_log


@pytest.mark.slow
def test_zeros_and_motors_of_one_log_move_the_parameters_as_far_as_is_said(biped, robot, logs):
    """Friction drifts by the same rule, and is held by the torque that it makes (below)."""
    log, squares = logs[0], {"ft_zero": 0.0, "kt_drift": 0.0}
    model = identified(robot, [log])
    for sensor in biped.robot.contacts:
        for each in FORCES:
            std, name = (
                DECLARED.ft_zero_force if each[0] == "f" else DECLARED.ft_zero_moment,
                f"ft.{sensor.name}.{each}",
            )
            again = identified(robot, [changed(log, {name: log.channels[name] + 0.02 * std})])
            squares["ft_zero"] += ((again.solution.unbounded.x - model.solution.unbounded.x) / 0.02) ** 2
    for joint in biped.robot.joints:
        name, step = f"i.{joint.name}", 0.1
        again = identified(robot, [changed(log, {name: log.channels[name] / (1.0 + step * DECLARED.kt_drift)})])
        squares["kt_drift"] += ((again.solution.unbounded.x - model.solution.unbounded.x) / step) ** 2
    for name, square in squares.items():
        assert astray(model, np.sqrt(square), np.sqrt(np.diag(model.inputs.by_log[name]))) < 0.15


def moved(robot, model, spoilt, step):
    """(P,) of x per unit of what spoils the logs that `model` is of."""
    return (identified(robot, spoilt).solution.unbounded.x - model.solution.unbounded.x) / step


def gone(log):
    """(R,) how far the courses have gone by the middle of a log, as 0013 and 0026 have it."""
    now, end = STARTED[log.name] + float(log.time.mean()), STARTED["later"]
    warming, first = np.array(DEFAULT_DOUBTS.warming_s), STARTED["log1"]
    return np.expm1(-(now - first) / warming) / np.expm1(-(end - first) / warming)


@pytest.mark.slow
def test_through_a_known_session_motors_drift_by_its_courses(biped, robot, logs, model):
    """One share less in the first log and as much more in the second, of each motor: k_T is what it was between."""
    assert logs[0].time[-1] == logs[1].time[-1]
    square, step = 0.0, 0.05
    for joint in biped.robot.joints:
        name = f"i.{joint.name}"
        spoilt = [
            changed(log, {name: log.channels[name] / (1.0 + sign * step * DECLARED.kt_drift)})
            for sign, log in zip((-1.0, 1.0), logs, strict=True)
        ]
        square = square + moved(robot, model, spoilt, step) ** 2
    half = 0.5 * (gone(logs[1]) - gone(logs[0]))
    expected = np.sqrt(square * np.mean(half**2))
    known = identified(robot, logs, STARTED)
    assert astray(known, expected, np.sqrt(np.diag(known.inputs.by_log["kt_drift"]))) < 0.1


@pytest.mark.parametrize("name", ["kt_drift", "viscous_drift", "coulomb_drift"])
def test_what_one_fitted_log_of_a_known_session_was_recorded_with_is_what_drifts_are_counted_from(robot, logs, name):
    alone = identified(robot, logs[:1], {"log1": 0.0, "later": 900.0})
    assert name not in alone.inputs.by_log
    assert name in identified(robot, logs[:1]).inputs.by_log


@pytest.mark.slow
def test_zeros_that_were_taken_once_are_none_as_the_session_begins(biped, robot, logs, model):
    taken = replace(robot, declared=replace(DECLARED, zeros_taken="session"))
    square, step, courses = 0.0, 0.02, [gone(log) for log in logs]
    for sensor in biped.robot.contacts:
        for each in FORCES:
            size = DECLARED.ft_zero_force if each[0] == "f" else DECLARED.ft_zero_moment
            name, by_log = f"ft.{sensor.name}.{each}", list[np.ndarray]()
            for k, log in enumerate(logs):
                spoilt = [*logs]
                spoilt[k] = changed(log, {name: log.channels[name] + step * size})
                by_log.append(moved(robot, model, spoilt, step))
            square = square + np.mean(np.tensordot(courses, by_log, (0, 0)) ** 2, axis=0)
    known = identified(taken, logs, STARTED)
    assert astray(known, np.sqrt(square), np.sqrt(np.diag(known.inputs.by_log["ft_zero"]))) < 0.15


@pytest.mark.slow
@pytest.mark.parametrize(("friction", "declared"), [("k_d", "viscous_drift"), ("tau_c", "coulomb_drift")])
def test_a_motor_that_rubs_more_in_the_log_with_the_device_takes_from_the_support(
    biped, model, suit, wander, friction, declared
):
    more = getattr(DECLARED, declared)
    rubs = replace(biped, xi=biped.xi | {friction: biped.xi[friction] * (1.0 + more)})
    usual, other = (each.record(wander(5), "worn", bands=suit.bands).log for each in (biped, rubs))
    known = replace(model, identified=replace(model.identified, xi=biped.known().identified.xi))
    prepared, samples = known.prepare(usual), np.arange(100, 700, 20)
    before, after = (balance(known, known.prepare(log), EVERY) for log in (usual, other))
    expected = of_this_log(known, prepared, samples, EVERY)[declared]
    for joint in biped.torso:
        steady = before.steady[samples, joint]
        change = (after.torque - before.torque)[samples, joint][steady]
        assert np.abs(change).max() > 0.02
        np.testing.assert_allclose(change, expected[steady, joint, joint], rtol=0.05, atol=0.01)


def test_a_motor_that_drifts_in_the_log_with_the_device_is_taken_for_support(biped, model, suit, wander):
    worn = biped.record(wander(5), "worn", bands=suit.bands).log
    joint = biped.robot.joints[biped.torso[0]].name
    spoilt = changed(worn, {f"i.{joint}": worn.channels[f"i.{joint}"] / (1.0 + DECLARED.kt_drift)})
    prepared, samples = model.prepare(worn), np.arange(100, 700, 20)
    change = balance(model, model.prepare(spoilt), EVERY).torque - balance(model, prepared, EVERY).torque
    expected = of_this_log(model, prepared, samples, EVERY)["kt_drift"][:, biped.torso[0], biped.torso[0]]
    np.testing.assert_allclose(change[samples, biped.torso[0]], expected, rtol=0.02, atol=1e-3)


def test_a_zero_in_the_log_with_the_device_is_taken_for_support_of_the_leg_above(biped, model, suit, wander):
    worn, samples = biped.record(wander(5), "worn", bands=suit.bands).log, np.arange(100, 700, 20)
    name = "ft.r_foot.fx"
    spoilt = changed(worn, {name: worn.channels[name] + DECLARED.ft_zero_force})
    prepared = model.prepare(worn)
    change = balance(model, model.prepare(spoilt), EVERY).torque - balance(model, prepared, EVERY).torque
    place = [sensor.name for sensor in biped.robot.contacts].index("r_foot")
    expected = of_this_log(model, prepared, samples, EVERY)["ft_zero"][:, :, 6 * place]
    assert np.abs(expected).max() > 0.1
    np.testing.assert_allclose(change[samples], expected, atol=1e-6)


def test_parameters_are_doubted_by_what_is_declared_beside_what_the_logs_scatter(biped, robot, logs, model):
    alone = identified(biped.robot, logs)
    more = model.inputs.alike + sum(model.inputs.by_log.values())
    np.testing.assert_allclose(model.covariance, alone.covariance + more, rtol=1e-6, atol=1e-12)


def test_a_gain_of_all_sensors_moves_everything_in_proportion(biped, robot, logs, model):
    """Linearity: what forces read too much of, masses and k_T are too large by, as far as the logs decide them."""
    moved = model.inputs.moved[:, model.inputs.names.index("ft_gain_common")]
    gains = model.solution.gains.columns
    np.testing.assert_allclose(moved[gains], model.solution.unbounded.x[gains], rtol=0.02)
