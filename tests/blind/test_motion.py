from __future__ import annotations

import numpy as np

from exogauge.blind.generator.motion import FASTEST, QUICKEST, RATE_HZ


def test_velocities_and_accelerations_are_derivatives_of_positions(arm6) -> None:
    motion, step = arm6.motion, 1.0 / RATE_HZ
    velocity = (motion.q[:, 2:] - motion.q[:, :-2]) / (2 * step)
    acceleration = (motion.dq[:, 2:] - motion.dq[:, :-2]) / (2 * step)
    np.testing.assert_allclose(velocity, motion.dq[:, 1:-1], atol=2e-3)
    np.testing.assert_allclose(acceleration, motion.ddq[:, 1:-1], atol=0.1)


def test_a_joint_that_stops_stands_exactly_still(arm6) -> None:
    motion = arm6.motion
    resting = motion.dq == 0.0
    assert np.all(resting[:, 0] & resting[:, -1]), "logs begin and end at rest"
    both = resting[:, 1:] & resting[:, :-1]
    assert np.abs(np.diff(motion.q, axis=1)[both]).max() < 1e-12
    assert np.all(motion.ddq[:, 1:-1][both[:, 1:] & both[:, :-1]] == 0.0)


def test_every_joint_rests_creeps_and_runs_in_every_log(arm6) -> None:
    speed = np.abs(arm6.motion.dq)
    for low, high, share in ((-1.0, 1e-12, 0.07), (1e-3, 0.1, 0.03), (0.4, FASTEST, 0.03)):
        inside = ((speed > low) & (speed <= high)).mean(axis=1)
        assert inside.min() > share, (low, high, inside.min())


def test_joints_stay_within_their_limits(arm6) -> None:
    joints = [link.joint for link in arm6.links if link.joint is not None]
    motion = arm6.motion
    assert np.all(motion.q > [joint.lower - 1e-9 for joint in joints])
    assert np.all(motion.q < [joint.upper + 1e-9 for joint in joints])
    assert np.abs(motion.dq).max() <= FASTEST
    assert np.abs(motion.ddq).max() <= QUICKEST * (1.0 + 1e-12)
