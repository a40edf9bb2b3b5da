"""What standard deviations are made of: blocks that are long against the residual's memory, and noise in the motion."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from exogauge.identification.identify import identify
from exogauge.identification.settings import Recording, Settings
from exogauge.identification.solution import solve
from exogauge.identification.uncertainty import block_length, score_covariance


def test_blocks_grow_with_the_memory_of_the_residual():
    rng = np.random.default_rng(0)
    white = rng.normal(size=(40_000, 6))
    lengths = [block_length(lfilter([1.0], [1.0, -a], white, axis=0), 10.0)[0] for a in (0.0, 0.8, 0.95, 0.98)]
    assert lengths == sorted(lengths)
    for a, length in zip((0.8, 0.95, 0.98), lengths[1:], strict=True):
        assert length == pytest.approx(8.0 * (1 + a) / (1 - a), rel=0.25)  # 8 integral correlation times


def test_blocks_are_half_a_second_at_least_and_twelve_at_least():
    rng = np.random.default_rng(0)
    assert block_length(rng.normal(size=(10_000, 3)), 200.0)[0] == 100
    assert block_length(np.cumsum(rng.normal(size=(1200, 3)), axis=0), 10.0)[0] <= 100


FRICTION = ("k_d", "tau_c", "tau_o")


def deviations(found, truth):
    """Of friction and offset of every joint from the truth, in their own standard deviations."""
    joints = [joint.name for joint in truth.robot.joints]
    known = {f"{kind}[{name}]": truth.xi[kind][j] for kind in FRICTION for j, name in enumerate(joints)}
    return [(p.value - known[p.name]) / p.std for p in found.parameters if p.name in known]


@pytest.mark.slow
def test_standard_deviations_are_of_the_errors_size_where_errors_last(make_truth, make_log):
    """A torque sensor whose error lasts 0.15 s says as much as one independent reading every 0.3 s, not as 200 a
    second: taken for white, standard deviations are some four times too small."""
    truth, z = make_truth(False, joints=2, actuation="torque"), []
    log, a = make_log(truth, 1, seconds=60.0, noise=0.1), np.exp(-1.0 / (0.15 * 200.0))
    for seed in range(6):
        white = np.random.default_rng(seed).normal(size=(log.samples, 2))
        error = 0.3 * lfilter([np.sqrt(1.0 - a**2)], [1.0, -a], white, axis=0)
        torques = {f"tau.j{j + 1}": log.channels[f"tau.j{j + 1}"] + error[:, j] for j in range(2)}
        noisy = replace(log, channels={**log.channels, **torques})
        z += deviations(identify(truth.robot, [Recording(noisy, False)], Settings(cutoff_hz=8.0)), truth)
    assert len(z) == 6 * 6
    assert 0.5 < np.sqrt(np.mean(np.square(z))) < 1.6


@pytest.mark.slow
def test_standard_deviations_hold_where_few_stretches_are_long_against_the_error(make_truth, make_log):
    """The fit bends to each of them, so that what it leaves there is less than the error: errors were 1.27 times what
    was stated."""
    truth, z = make_truth(False, joints=4, actuation="torque"), []
    logs, a = [make_log(truth, seed, seconds=20.0, noise=0.1) for seed in (1, 2)], np.exp(-1.0 / (0.25 * 200.0))
    for seed in range(24):
        recordings = []
        for number, log in enumerate(logs):
            white = np.random.default_rng([seed, number]).normal(size=(log.samples, 4))
            error = 0.3 * lfilter([np.sqrt(1.0 - a**2)], [1.0, -a], white, axis=0)
            torques = {f"tau.j{j + 1}": log.channels[f"tau.j{j + 1}"] + error[:, j] for j in range(4)}
            recordings.append(Recording(replace(log, channels={**log.channels, **torques}), False))
        z += deviations(identify(truth.robot, recordings, Settings(cutoff_hz=8.0)), truth)
    assert len(z) == 24 * 12
    assert 0.85 < np.sqrt(np.mean(np.square(z))) < 1.15


@pytest.mark.slow
def test_what_noise_of_the_encoders_adds_is_taken_off(make_truth, make_log):
    """Noise of accelerations makes a rotor look lighter, the more so the less the joint accelerates; drawn six times
    over, the mean error says how much of that is left."""
    truth, errors = make_truth(False, joints=2, actuation="torque"), []
    log = make_log(truth, 1, seconds=30.0, noise=0.1)
    for seed in range(6):
        noise = 1e-3 * np.random.default_rng(seed).normal(size=(log.samples, 2))
        q = {f"q.j{j + 1}": log.channels[f"q.j{j + 1}"] + noise[:, j] for j in range(2)}
        recordings = [Recording(replace(log, channels={**log.channels, **q}), False)]
        found = identify(truth.robot, recordings, Settings(cutoff_hz=8.0, prior_strength=1e-3))
        equations, solution = found.model.equations, found.model.solution
        place = equations.effect_columns(1)[[effect.name for effect in equations.effects].index("rotor_inertia")]
        errors.append(np.array([solution.unbounded.x[place], solution.solved.x[place]]) - truth.xi["J_r"][1])
    before, after = np.mean(errors, axis=0)
    assert before < -0.05 * truth.xi["J_r"][1]
    assert abs(after) < 0.4 * abs(before)


@pytest.mark.parametrize("passes", [1, 4])
def test_what_currents_leave_open_is_known_as_it_was_stated_however_far_the_passes_came(make_truth, make_log, passes):
    """One factor of all torques: no row tells it, whichever iteration's rows they are."""
    truth = make_truth(False, joints=3, actuation="current")
    logs = [make_log(truth, seed, seconds=20.0, noise=1e-3) for seed in (1, 2)]
    joints = tuple(replace(joint, prior_std={"k_T": 0.06 * joint.prior["k_T"]}) for joint in truth.robot.joints)
    recordings, settings = [Recording(each, False) for each in logs], Settings(cutoff_hz=8.0)
    model = identify(replace(truth.robot, joints=joints), recordings, settings).model
    prepared = [model.prepare(each) for each in logs]
    solution = solve(model.equations, prepared, model.solution.prior, settings, passes=passes)
    covariance = solution.unbounded.covariance(score_covariance(model.equations, prepared, solution))
    stated = solution.prior.seen_covariance
    for column in solution.gains.columns:
        assert covariance[column, column] < 1.1**2 * stated[column, column]
