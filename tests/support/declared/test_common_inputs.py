"""What all logs have alike moves parameters and supporting torque as far as logs that are spoilt by it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pinocchio as pin
import pytest
import scipy
from tests.support.conftest import BODIES, JOINTS, ORDER, urdf
from tests.support.declared.conftest import EVERY, FORCES, astray, changed, identified

from exogauge.identification.disturbances import common_columns
from exogauge.logs.model import Log
from exogauge.robots.urdf import load_tree
from exogauge.support.balance import balance, slopes

Spoil = Callable[[Log], Log]


@pytest.fixture(scope="module")
def spoilt(biped, robot, logs):
    """(name of an input, its size) -> how logs are spoilt by it, and the model that these make."""

    @cache  # what parameters and supporting torque are asked of is the same
    def made(name, size):
        spoil = CASES[name](biped, size)
        return spoil, identified(robot, [spoil(log) for log in logs])

    return made


def more_force(sensors, share) -> Spoil:
    def spoil(log):
        names = [f"ft.{sensor}.{each}" for sensor in sensors for each in FORCES]
        return changed(log, {name: (1.0 + share) * log.channels[name] for name in names})

    return spoil


def askew(sensor, axis, angle) -> Spoil:
    """A foot's sensor stands turned by the angle, so that it reads w + δ × w of what acts on it."""

    def spoil(log):
        channels = {}
        for kind in "fm":
            acts = log.stack([f"ft.{sensor}.{kind}{each}" for each in "xyz"])
            reads = acts + np.cross(angle * np.eye(3)["xyz".index(axis)], acts)
            channels |= {f"ft.{sensor}.{kind}{each}": reads[:, k] for k, each in enumerate("xyz")}
        return changed(log, channels)

    return spoil


def tilted(biped, axis, angle) -> Spoil:
    """The IMU stands turned by the angle, so that f = read + δ × read in the base."""

    def spoil(log):
        R, channels = biped.robot.T_base_imu.rotation, {}
        back = R.T @ (np.eye(3) - pin.skew(angle * np.eye(3)[axis])) @ R
        for kind in ("acc", "gyro"):
            read = log.stack([f"{kind}.{each}" for each in "xyz"]) @ back.T
            channels |= {f"{kind}.{each}": read[:, k] for k, each in enumerate("xyz")}
        return changed(log, channels)

    return spoil


def beside(sensor, axis, size) -> Spoil:
    """A foot's sensor sits beside its frame, so that its moments are about another place."""

    def spoil(log):
        force = log.stack([f"ft.{sensor}.f{each}" for each in "xyz"])
        more = np.cross(force, size * np.eye(3)["xyz".index(axis)])
        return changed(log, {f"ft.{sensor}.m{each}": log.channels[f"ft.{sensor}.m{each}"] + more[:, k]
                             for k, each in enumerate("xyz")})  # fmt: skip

    return spoil


def late(channels, seconds) -> Spoil:
    """Channels that are told so much later than they were measured."""

    def spoil(log):
        t = log.time - log.time[0]
        spoilt = {name: scipy.interpolate.CubicSpline(t, log.channels[name]) for name in channels}
        return changed(log, {name: each(t - seconds) for name, each in spoilt.items()})

    return spoil


def zeroed_elsewhere(joint, angle) -> Spoil:
    """An encoder that reads so much less than the angle is."""
    return lambda log: changed(log, {f"q.{joint}": log.channels[f"q.{joint}"] - angle})


BASE = [f"{kind}.{axis}" for kind in ("acc", "gyro") for axis in "xyz"]
CASES = {
    "ft_gain_common": lambda biped, size: more_force([each.name for each in biped.robot.contacts], size),
    "ft_gain.l_foot": lambda biped, size: more_force(["l_foot"], size),
    "ft_gain.r_foot": lambda biped, size: more_force(["r_foot"], size),
    **{
        f"ft_tilt.{sensor}.{axis}": lambda biped, size, sensor=sensor, axis=axis: askew(sensor, axis, size)
        for sensor in ("l_foot", "r_foot")
        for axis in "xyz"
    },
    **{
        f"ft_place.{sensor}.{axis}": lambda biped, size, sensor=sensor, axis=axis: beside(sensor, axis, size)
        for sensor in ("l_foot", "r_foot")
        for axis in "xyz"
    },
    **{
        f"clock.{sensor}": lambda biped, size, sensor=sensor: late([f"ft.{sensor}.{each}" for each in FORCES], size)
        for sensor in ("l_foot", "r_foot")
    },
    "clock.imu": lambda biped, size: late(BASE, size),
    **{f"encoder_zero.{joint}": lambda biped, size, joint=joint: zeroed_elsewhere(joint, size) for joint in ORDER},
    "imu_tilt.x": lambda biped, size: tilted(biped, 0, size),
    "imu_tilt.y": lambda biped, size: tilted(biped, 1, size),
}


FIRST_OF_KIND = {
    "ft_gain_common", "ft_gain.l_foot", "ft_tilt.l_foot.x", "ft_place.l_foot.y", "clock.l_foot", "clock.imu",
    "imu_tilt.x", "encoder_zero.l_hip", "encoder_zero.torso_pitch",
}  # fmt: skip
EACH = [pytest.param(name, marks=() if name in FIRST_OF_KIND else pytest.mark.thorough) for name in CASES]


def test_every_common_input_is_tried(model):
    assert set(model.inputs.names) == set(CASES)


@pytest.mark.slow
@pytest.mark.parametrize("name", EACH)
def test_an_input_moves_the_parameters_as_far_as_logs_that_are_spoilt_by_it(model, spoilt, name):
    step = 1e-4  # more would be seen in the residuals, and rows be weighed anew
    up, down = (spoilt(name, size)[1] for size in (step, -step))
    moved = (up.solution.unbounded.x - down.solution.unbounded.x) / (2.0 * step)
    assert astray(model, moved, model.inputs.moved[:, model.inputs.names.index(name)]) < 0.1


@pytest.mark.slow
@pytest.mark.parametrize("name", EACH)
def test_an_input_moves_the_supporting_torque_as_far_as_logs_that_are_spoilt_by_it(
    biped, model, spoilt, suit, wander, name
):
    worn, samples = biped.record(wander(5), "worn", bands=suit.bands).log, np.arange(100, 700, 20)
    step = 1e-3 if name == "clock.imu" else 1e-4  # a tenth of a millisecond drowns in the noise of accelerations
    found = []
    for size in (step, -step):
        spoil, again = spoilt(name, size)
        found.append(balance(again, again.prepare(spoil(worn)), EVERY).torque[samples])
    prepared, change = model.prepare(worn), (found[0] - found[1]) / (2.0 * step)
    column = model.equations.size + model.inputs.names.index(name)
    expected = np.stack([slope[:, column] for _, slope in slopes(model, prepared, samples, EVERY)], axis=1)
    steady = balance(model, prepared, EVERY).steady[samples]
    # The zero of a joint beyond which none follows is what its link weighs elsewhere: all but a hundredth of it goes.
    equations, phi = model.equations, model.solution.solved.x[: model.equations.base_size]
    taken_off = common_columns(equations, prepared, samples, model.cutoff_hz, phi)[:, model.inputs.names.index(name)]
    directly = np.abs(taken_off[:, equations.layout.told.axes]).max()
    assert np.abs(change - expected)[steady].max() < max(0.1 * np.abs(expected).max(), 0.01 * directly)


@pytest.mark.slow
@pytest.mark.parametrize("joint", [name for name in ORDER if name.startswith("torso")])
def test_where_a_urdf_puts_a_joint_is_taken_up_by_what_its_links_weigh(biped, robot, logs, suit, wander, joint):
    """So that no place of a joint has to be declared: of the moment that its weight has on that way, little is left."""
    parent, child, xyz, axis = JOINTS[joint]
    moved = {**JOINTS, joint: (parent, child, tuple(each + 0.001 for each in xyz), axis)}
    elsewhere = replace(robot, tree=load_tree(urdf(moved), joints=ORDER, base_link="pelvis", floating=True))
    worn, samples = biped.record(wander(5), "worn", bands=suit.bands).log, np.arange(100, 700, 20)
    models = [identified(each, logs) for each in (robot, elsewhere)]
    torques = [balance(each, each.prepare(worn), EVERY) for each in models]
    steady, change = torques[0].steady[samples], (torques[1].torque - torques[0].torque)[samples]
    weight = 9.81 * sum(BODIES[link][0] for link in ("waist", "chest") if link in (child, "chest"))
    assert np.abs(change)[steady].max() < 0.07 * 0.001 * weight
