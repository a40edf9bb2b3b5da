"""By how many standard deviations logs contradict what is stated, all other stated numbers in doubt as well."""

from __future__ import annotations

import numpy as np
import pytest
from tests.blind.conftest import plan

from exogauge.blind.generator.cut import cut_wrench
from exogauge.blind.generator.dynamics import inverse_dynamics
from exogauge.blind.generator.hidden.bodies import LinkMass, Payload
from exogauge.blind.generator.motion import RATE_HZ
from exogauge.blind.generator.placed import hide
from exogauge.blind.generator.robot_kind import ARM
from exogauge.blind.generator.scene import Scene
from exogauge.blind.generator.true_robot import TrueRobot, a_priori, a_priori_std, draw_robot


def _on(scene: Scene, joint: int, torque: np.ndarray) -> np.ndarray:
    every = np.zeros(scene.motion.q.shape)
    every[:, :, joint] = torque
    return every


@pytest.mark.slow
def test_what_nobody_doubts_is_told_by_its_size_over_the_noise(arm6: Scene) -> None:
    """A tone that no number makes: its energy below the low-pass, over that of the noise there."""
    tone = 0.02 * np.sin(2 * np.pi * 3.7 * arm6.motion.time)
    steady = arm6.baselines[0].kept[:4].sum()
    times = np.sqrt(0.5 * 0.02**2 * steady / (arm6.floors[0] ** 2 * 2 * 10.0 / RATE_HZ))
    told = arm6.stated.contradicted(_on(arm6, 0, np.broadcast_to(tone, arm6.shape)), None)
    assert told == pytest.approx(times, rel=0.1)


@pytest.mark.parametrize("joint", range(6))
def test_a_number_that_motion_tells_well_is_contradicted_by_as_much_as_it_is_wrong(arm6: Scene, joint: int) -> None:
    run, link = arm6.runs[joint], [link for link in arm6.links if link.joint is not None][joint]
    std = a_priori_std(link.joint.drive, arm6.k_T_std)["k_d"]
    told = arm6.stated.contradicted(_on(arm6, joint, 4.0 * std * run.dq), None)
    assert 3.0 < told < 4.0


def test_a_mass_that_others_hide_is_contradicted_by_less(arm6: Scene) -> None:
    """The link behind a vertical axis never rises: what it weighs no joint tells, and of its inertia little."""
    turning = LinkMass(arm6.robot.tree.names.index("shoulder"), 1.0)
    swinging = LinkMass(arm6.robot.tree.names.index("upper_arm"), 1.0)
    told = {
        each: arm6.stated.contradicted(
            each.change(arm6, 4.0 * each.believed(arm6)).torque - each.change(arm6, 0.0).torque, None
        )
        for each in (turning, swinging)
    }
    assert told[turning] < 0.5
    assert 2.0 < told[swinging] < 4.0


@pytest.mark.slow
def test_robots_of_the_population_are_contradicted_by_as_much_as_chance_does(arm6: Scene) -> None:
    """Of n numbers drawn by what is stated, the logs tell some: the sum of squares is below n, and not far below."""
    draws = [draw_robot(np.random.default_rng(seed), arm6.links, "wrist_ft", 0.02) for seed in range(12)]
    squares = [arm6.stated.contradicted(*_apart(arm6, each)) ** 2 for each in draws]
    assert 0.4 * arm6.stated.numbers < np.mean(squares) < arm6.stated.numbers


def _apart(scene: Scene, robot: TrueRobot) -> tuple[np.ndarray, np.ndarray]:
    """Torques and wrench of a drawn robot beside those of the robot that is stated; k_T apart."""
    stated = draw_robot(_Nothing(), scene.links, scene.kind.sensor.frame, 0.0)
    torque = np.zeros(scene.motion.q.shape)
    wrench = np.zeros((*scene.shape, 6))
    for sign, each in ((1.0, robot), (-1.0, stated)):
        torque += sign * inverse_dynamics(each.tree, each.phi, scene.moving)[0].reshape(torque.shape)
        wrench += sign * cut_wrench(each.tree, each.phi, each.cut, scene.moving).reshape(wrench.shape)
    for joint, (run, drive, link) in enumerate(
        zip(scene.runs, robot.drives, [link for link in scene.links if link.joint is not None], strict=True)
    ):
        prior = a_priori(link.joint.drive)
        torque[:, :, joint] += (drive.k_d - prior["k_d"]) * run.dq + (drive.tau_c - prior["tau_c"]) * run.direction
        torque[:, :, joint] += (drive.J_r - prior["J_r"]) * run.ddq - drive.tau_o
    return torque, wrench


class _Nothing:
    """A random generator for a robot that is what is stated."""

    def standard_normal(self, size: int) -> np.ndarray:
        return np.zeros(size)

    def uniform(self, low: float, high: float) -> float:
        return 0.5 * (low + high)


def test_a_hidden_mass_is_wrong_by_what_the_answer_says_whatever_the_robot_weighs(arm6: Scene) -> None:
    name = "forearm"
    body = arm6.robot.tree.names.index(name)
    stated = sum(link.mass for link in arm6.links if link.name == name)
    change = LinkMass(body, -1.0).change(arm6, 0.3).torque
    alone = np.zeros_like(arm6.robot.phi)
    alone[body] = arm6.robot.phi[body] * ((stated - 0.3) / arm6.robot.phi[body, 0] - 1.0)
    np.testing.assert_allclose(change.reshape(-1, 6), inverse_dynamics(arm6.robot.tree, alone, arm6.moving)[0])


def test_a_payload_from_the_first_log_on_is_all_that_the_hand_weighs_beside_what_is_stated(arm6: Scene) -> None:
    change = Payload("tool", (0.01, 0.02, 0.03), since=0).change(arm6, 0.7)
    resting = np.all(arm6.motion.dq == 0.0, axis=2)
    stated = next(link.mass for link in arm6.links if link.name == "tool")
    weight = np.linalg.norm((arm6.wrench + change.wrench)[resting][:, :3], axis=1)
    np.testing.assert_allclose(weight, (stated + 0.7) * 9.81, rtol=1e-9)


@pytest.mark.parametrize("kind", ["link_mass", "payload"])
def test_a_wrong_number_is_no_more_visible_than_logs_contradict_it(arm6: Scene, kind: str) -> None:
    (placed,) = hide(np.random.default_rng(8), plan(ARM, kind, ratio=3.0), arm6)
    there, stated = placed.effect.change(arm6, placed.size), placed.effect.change(arm6, 0.0)
    if kind == "payload":
        assert placed.effect.since == 0
    wrench = None if there.wrench is None else there.wrench - stated.wrench
    told = arm6.stated.contradicted(there.torque - stated.torque, wrench)
    assert placed.found.ratio <= 1.001 * told
    assert placed.found.ratio <= 1.001 * placed.size / placed.effect.believed(arm6)
