"""Constant torques that are a log's own: integrated out as if they were columns, and no stiffness."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
import scipy
from tests.band_problem import Motion, Way
from tests.draws import drawn, met_in

from exogauge.support.band_doubt import SCATTER, TORQUE_ZERO, contributions
from exogauge.support.band_fit import best_start, starts
from exogauge.support.band_model import Belief, Fitted, Setting, at, fit, shared
from exogauge.support.band_nuisances import Between
from exogauge.support.band_rows import WearLog, WearLogs, between

NAMES = ["bend", "twist", "knee"]
STIFFNESS, LENGTH, SIGMA, STD, LOGS, SAMPLES = 400.0, 0.55, 0.3, 1.5, 4, 300


class Course:
    """What stands for a declared band."""

    name, group = "back", "back"


def recorded(rng: np.random.Generator, offset: np.ndarray, zero_std: np.ndarray, noise: float = SIGMA) -> Setting:
    """One band over three joints in several logs. offset: (L, D) [N·m] in each."""
    logs = []
    for number, own in enumerate(offset):
        t = np.arange(SAMPLES) * 0.04
        bend = 0.4 + 0.1 * number + 0.35 * np.sin(1.3 * t + number)
        angles = np.stack([bend, 0.2 * np.sin(0.9 * t), 0.1 * np.cos(t)], axis=1)
        motion = Motion(angles, 1)
        torque = -motion.jacobian[:, 0] * (STIFFNESS * np.maximum(motion.length - LENGTH, 0.0))
        torque = torque + own + noise * rng.normal(size=torque.shape)
        used = np.ones(torque.shape, dtype=bool)
        used[: 20 * number] = False
        logs.append(WearLog(f"log{number}", "any", t, angles, np.arange(SAMPLES), torque, used,
                            np.zeros(0, dtype=int), None, zero_std=zero_std))  # fmt: skip
    together = WearLogs(logs, np.arange(3), NAMES)
    weight = together.used / SIGMA**2
    return Setting(together, (together.wire(Way(0)),), weight, float(together.used.sum()),
                   Belief(np.zeros(2), np.zeros((2, 2))))  # fmt: skip


def fitted(setting: Setting) -> Fitted:
    return fit(setting, best_start(setting, starts(shared([Course()]), setting.wires, ())))


def std_of_stiffness(setting: Setting, found: Fitted) -> float:
    doubt = sum(contributions(setting, found, {}).values())
    return float(np.sqrt(doubt[0, 0]))


def without(setting: Setting) -> Setting:
    logs = [replace(each, zero_std=None) for each in setting.logs.logs]
    together = WearLogs(logs, setting.logs.joints, setting.logs.names)
    return replace(setting, logs=together, wires=(together.wire(Way(0)),), added=None)


@pytest.mark.parametrize(("places", "n"), [([0, 3, 4], 7), ([2], 5)])
def test_columns_between_samples_run_along_straight_lines(places, n):
    """And stay beyond the last one. Of a log without a sample there are none."""
    values, X = (np.random.default_rng(0).normal(size=size) for size in ((len(places), 2, 3), (n, 2)))
    columns = Between(values, between(np.array(places, dtype=int), n))
    whole = columns.times(np.eye(3))
    drawn = np.zeros((n, 2, 3))
    for joint, each in itertools.product(range(2), range(3)):
        drawn[:, joint, each] = np.interp(np.arange(n), places, values[:, joint, each])
    np.testing.assert_allclose(whole, drawn, atol=1e-12)
    np.testing.assert_allclose(columns.against(X), np.einsum("ndm,nd->m", drawn, X), atol=1e-12)
    assert between(np.zeros(0, dtype=int), 0).shape == (0, 0)


@pytest.mark.parametrize("more", [0, 3])
def test_integrated_out_is_a_column_of_ones_per_log_and_joint_with_a_row_of_its_prior(more):
    """And of each further unknown, its own column."""
    rng = np.random.default_rng(1)
    std = np.array([0.2, 1.5, 0.0])
    setting = recorded(rng, rng.normal(size=(LOGS, 3)), std)
    V = rng.normal(size=(*setting.weight.shape, more))
    setting = replace(setting, added=Between(V, scipy.sparse.eye_array(len(V), format="csr")) if more else None)
    found = fitted(setting)
    e = at(without(setting), found.wear).e  # with no offset taken off
    columns, prior = [], []
    for log in range(LOGS):
        for joint in (0, 1):
            one = np.zeros(e.shape)
            one[setting.logs.log == log, joint] = 1.0
            columns.append(one.ravel())
            prior.append(std[joint] ** -2)
    columns += [V[:, :, each].ravel() for each in range(more)]
    prior += [1.0] * more
    root, P = np.sqrt(setting.weight).ravel(), found.A.shape[2]
    J = np.column_stack([found.A.reshape(-1, P), *columns]) * root[:, None]
    H = J.T @ J
    H[range(P, len(H)), range(P, len(H))] += prior
    inner = H[:P, :P] - H[:P, P:] @ np.linalg.solve(H[P:, P:], H[P:, :P])
    size = np.sqrt(np.diag(inner))
    np.testing.assert_allclose(found.hessian / np.outer(size, size), inner / np.outer(size, size), atol=1e-12)
    g = J.T @ (e.ravel() * root)
    score = g[:P] - H[:P, P:] @ np.linalg.solve(H[P:, P:], g[P:])
    ours = np.einsum("ndp,nd,nd->p", found.A, setting.weight, found.e)
    scale = np.sqrt(np.diag(H)[:P] * np.sum(setting.weight * e**2))
    np.testing.assert_allclose(ours / scale, score / scale, atol=1e-12)
    o = np.linalg.solve(H[P:, P:], g[P:])
    _, v, offsets = setting.nuisances.apart(e)
    np.testing.assert_allclose(v, o[len(o) - more :], rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(offsets[:, :2].ravel(), o[: len(o) - more], rtol=1e-9)
    cost = np.sum((e.ravel() * root - J[:, P:] @ o) ** 2) + np.sum(np.array(prior) * o**2)
    assert found.cost == pytest.approx(cost, rel=1e-12)
    assert not offsets[:, 2].any()


def test_zero_std_changes_no_bit():
    rng = np.random.default_rng(2)
    setting = recorded(rng, rng.normal(size=(LOGS, 3)), np.zeros(3))
    plain = without(setting)
    one, other = fitted(setting), fitted(plain)
    for name in ("e", "A", "hessian"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    assert one.cost == other.cost
    ours, theirs = contributions(setting, one, {}), contributions(plain, other, {})
    assert ours.keys() == theirs.keys() == {SCATTER}
    np.testing.assert_array_equal(ours[SCATTER], theirs[SCATTER])


def test_a_joint_whose_zero_is_known_is_as_without_offsets():
    """The limit of s: next to none is none; a large one leaves what differs from the mean alone."""
    rng = np.random.default_rng(3)
    offset = rng.normal(size=(LOGS, 3))
    tiny, none = (fitted(recorded(np.random.default_rng(4), offset, np.full(3, s))) for s in (1e-9, 0.0))
    np.testing.assert_allclose(tiny.wear.springs, none.wear.springs, rtol=1e-9)
    wide = recorded(np.random.default_rng(4), offset, np.full(3, 1e6))
    found = fitted(wide)
    for log in range(LOGS):
        own = (wide.logs.log == log)[:, None] & wide.logs.used
        np.testing.assert_allclose(np.sum(np.where(own, found.e, 0.0), axis=0), 0.0, atol=1e-6)


def test_a_constant_on_one_joint_of_one_log_moves_the_stiffness_by_less_than_its_doubt():
    offset = np.zeros((LOGS, 3))
    shifted = offset.copy()
    shifted[1, 0] = STD
    before, after = (recorded(np.random.default_rng(5), each, np.full(3, STD)) for each in (offset, shifted))
    one, other = fitted(before), fitted(after)
    std = std_of_stiffness(before, one)
    assert abs(other.wear.springs[0] - one.wear.springs[0]) < 0.5 * std
    blind = [fitted(without(each)).wear.springs[0] for each in (before, after)]
    assert abs(blind[1] - blind[0]) > 1.5 * std
    assert TORQUE_ZERO in contributions(after, other, {})


@pytest.mark.slow
@drawn(100, 400)
def test_intervals_hold_the_truth_where_a_log_has_a_zero_of_its_own(draws):
    """Of one log: too few without offsets."""
    with_offsets, plain = deviations(draws, 1)
    held, before = (np.mean(np.abs(each[0]) < 1.96) for each in (with_offsets, plain))
    least, most = met_in(0.95, draws)
    assert least <= held <= most, held
    assert before < least, before


@pytest.mark.slow
@drawn(50, 200)
def test_of_several_logs_offsets_leave_a_third_of_the_doubt_and_hold_the_truth(draws):
    """Without them the differing zeros are seen as scatter: an honest doubt of a poor estimate."""
    with_offsets, plain = deviations(draws, LOGS)
    least, most = met_in(0.95, draws)
    assert least <= np.mean(np.abs(with_offsets[0]) < 1.96) <= most
    assert np.mean(with_offsets[1]) < np.mean(plain[1]) / 3.0


def deviations(draws: int, logs: int) -> list[np.ndarray]:
    """(2, draws) each, with offsets and without: error of the stiffness over its std, and that std."""
    rng, found = np.random.default_rng(6), ([], [])
    for _ in range(draws):
        setting = recorded(rng, STD * rng.normal(size=(logs, 3)), np.full(3, STD))
        for kept, each in zip(found, (setting, without(setting)), strict=True):
            by = fitted(each)
            std = std_of_stiffness(each, by)
            kept.append(((by.wear.springs[0] - STIFFNESS) / std, std))
    return [np.array(each).T for each in found]
