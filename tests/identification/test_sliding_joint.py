"""A gantry with a joint that slides: what is named in N and m comes back in N and m."""

from __future__ import annotations

import numpy as np
import pytest

from exogauge.detect.pipeline import find_missing_effects
from exogauge.effects.torque_ripple import TorqueRipple
from exogauge.identification.identify import identify
from exogauge.identification.result import Identification
from exogauge.identification.settings import Recording, Settings
from exogauge.identification.steady import remarks_on_creeping
from exogauge.logs.model import Log
from exogauge.robots.description import Joint, Robot
from exogauge.robots.urdf import load_tree
from exogauge.studies.results.document import summaries
from exogauge.studies.words.notices import notice

URDF = b"""<robot name="gantry"><link name="rail"/>
<link name="car"><inertial><origin xyz="0 0 0"/><mass value="4"/>
<inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"/></inertial></link>
<link name="arm"><inertial><origin xyz="0 0 -0.3"/><mass value="2"/>
<inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.01"/></inertial></link>
<joint name="lift" type="prismatic"><parent link="rail"/><child link="car"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" effort="500" velocity="2"/></joint>
<joint name="swing" type="revolute"><parent link="car"/><child link="arm"/><axis xyz="0 1 0"/>
<limit lower="-2" upper="2" effort="50" velocity="5"/></joint></robot>"""
RATE, GRAVITY, PITCH = 200.0, 9.81, 25.0
CAR, ARM, COM, IYY = 4.0, 2.0, 0.3, 0.02
VISCOUS, COULOMB = (30.0, 0.5), (12.0, 0.8)  # N·s/m and N of the lift; N·m·s/rad and N·m of the swing


def recorded(seed: int, ripple: float = 0.0) -> Log:
    """Lagrange by hand: z the lift, a the arm's angle from hanging straight down. ripple: [N], PITCH times a metre."""
    rng = np.random.default_rng(seed)
    t = np.arange(round(40.0 * RATE)) / RATE

    def wave(size: float) -> tuple[np.ndarray, ...]:
        w, p = 2 * np.pi * np.array([0.11, 0.23, 0.41]), rng.uniform(0, 2 * np.pi, 3)
        s, c = np.sin(np.outer(t, w) + p), np.cos(np.outer(t, w) + p)
        return size * s.sum(axis=1), size * (c * w).sum(axis=1), -size * (s * w**2).sum(axis=1)

    (z, dz, ddz), (a, da, dda) = wave(0.15), wave(0.35)
    force = (CAR + ARM) * (ddz + GRAVITY) + ARM * COM * (np.sin(a) * dda + np.cos(a) * da**2)
    torque = (ARM * COM**2 + IYY) * dda + ARM * COM * np.sin(a) * (ddz + GRAVITY)
    force += ripple * np.sin(2 * np.pi * PITCH * z)
    force += VISCOUS[0] * dz + COULOMB[0] * np.sign(dz)
    torque += VISCOUS[1] * da + COULOMB[1] * np.sign(da)
    noisy = {
        "q.lift": z + 1e-5 * rng.standard_normal(t.size),
        "q.swing": a + 2e-5 * rng.standard_normal(t.size),
        "tau.lift": force + 0.5 * rng.standard_normal(t.size),
        "tau.swing": torque + 0.05 * rng.standard_normal(t.size),
    }
    return Log(f"log_{seed}", t, noisy)


def identified(ripple: float = 0.0) -> tuple[Identification, list[Recording]]:
    tree = load_tree(URDF, joints=("lift", "swing"), base_link="rail", floating=False)
    joints = tuple(Joint(name, "torque", None, {}, {}) for name in tree.joints)
    robot = Robot("gantry", tree, joints, None, (), np.eye(2))
    logs = [Recording(recorded(seed, ripple), seed == 3) for seed in (1, 2, 3)]
    return identify(robot, logs, Settings(cutoff_hz=8.0)), logs


@pytest.fixture(scope="module")
def found() -> Identification:
    return identified()[0]


def test_friction_of_a_sliding_joint_comes_back(found: Identification) -> None:
    named = {each.name: each for each in found.parameters}
    for k, joint in enumerate(("lift", "swing")):
        for kind, true in (("k_d", VISCOUS[k]), ("tau_c", COULOMB[k])):
            one = named[f"{kind}[{joint}]"]
            assert abs(one.value - true) < max(4.0 * one.std, 0.02 * true), one


def test_its_parameters_and_channels_are_in_newtons_metres_and_kilograms(found: Identification) -> None:
    units = {each.name: each.unit for each in found.parameters}
    assert [units[f"{kind}[lift]"] for kind in ("k_d", "tau_c", "tau_s", "J_r")] == ["N·s/m", "N", "N", "kg"]
    assert [units[f"{kind}[swing]"] for kind in ("k_d", "tau_c", "J_r")] == ["N·m·s/rad", "N·m", "kg·m²"]
    assert {each.channel: each.unit for each in found.validation} == {"tau.lift": "N", "tau.swing": "N·m"}
    assert found.predictions[0].units == {"tau.lift": "N", "tau.swing": "N·m"}


def test_forces_and_torques_are_not_pooled_into_one_error(found: Identification) -> None:
    pooled = {each.kind: (each.channels, each.unit) for each in summaries(found, ("lift", "swing"))}
    assert pooled["joint_torque"] == (("tau.swing",), "N·m")
    assert pooled["joint_force"] == (("tau.lift",), "N")


@pytest.mark.slow
def test_a_leadscrews_ripple_is_told_per_metre_of_its_way() -> None:
    """It was told in cycles per revolution, 6.3 times as many, "at a position of 0.1 rad"."""
    before, logs = identified(ripple=4.0)
    told = find_missing_effects(before, logs, [TorqueRipple()], Settings(cutoff_hz=8.0)).discrepancy
    (finding,) = told.findings
    assert finding.parameters["cycles"].unit == "1/m"
    assert finding.parameters["cycles"].value == pytest.approx(PITCH, abs=0.1)
    assert finding.evidence.unit == "m"


def test_the_speed_below_which_it_creeps_is_in_metres_per_second() -> None:
    (remark,) = remarks_on_creeping({"lift": 0.01, "swing": 0.02}, {"lift"})
    assert "lift (below 0.01 m/s), swing (below 0.02 rad/s)" in notice(remark).sentence
