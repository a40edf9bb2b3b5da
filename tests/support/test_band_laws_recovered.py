"""Stiffness of bands with every law that device.yaml knows: pulled along MuJoCo's courses by formulas of our own.

The humanoid of the generator bends and twists in its suit. MuJoCo gives where the via points are and how they move the
joints; what the bands pull is integrated here, in steps of a millisecond. The fit knows the law, not the stiffness.
"""

from __future__ import annotations

from dataclasses import fields
from functools import cache

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from scipy.integrate import cumulative_trapezoid
from scipy.interpolate import CubicSpline
from scipy.signal import butter, lfilter, sosfiltfilt

from exogauge.criteria.criteria import Criteria
from exogauge.devices.device import Band, Device, ViaPoint
from exogauge.devices.routing import Routing
from exogauge.effects.band_laws import all_laws
from exogauge.effects.catalogue import choose
from exogauge.identification.equations import Equations
from exogauge.identification.model import RobotModel
from exogauge.identification.per_log import PerLog
from exogauge.identification.settings import Settings
from exogauge.identification.type_b import TypeB
from exogauge.logs.model import Log
from exogauge.robots.description import Joint, Robot
from exogauge.robots.parameters import find_base_parameters
from exogauge.robots.row_blocks import RowBlocks
from exogauge.robots.urdf import load_tree
from exogauge.support.evidence import Evidence
from exogauge.support.inputs import Inputs
from exogauge.support.settings import WornLog
from exogauge.support.stiffness import identify_bands
from exogauge.synthetic import motion
from exogauge.synthetic.mjcf import mujoco_model
from exogauge.synthetic.robot_facts import BASE, JOINT_NAMES
from exogauge.synthetic.suit import fitted_suit
from exogauge.synthetic.true_robot import a_priori_robot
from exogauge.synthetic.urdf import robot_urdf

pytestmark = pytest.mark.slow

STEP, EVERY, CUTOFF = 0.001, 5, 8.0  # [s], steps per logged sample, [Hz] of the low-pass
NOISE = 0.08  # [N·m], lasting 0.1 s
ACTED = ("torso_pitch", "torso_yaw", "l_hip_pitch", "r_hip_pitch")
VALUES = {
    "linear": {},
    "hardening": {"hardening": 900.0, "hardening_power": 2.0},
    "softening": {"softening": 300.0, "softening_stretch": 0.12},
    "smooth_slack": {"transition": 0.006, "gradual": 0.8},
    "kelvin_voigt": {"damping": 40.0, "damping_power": 0.8},
    "maxwell": {"branch_stiffness": 80.0, "relaxation_time": 0.6, "slow_branch_stiffness": 40.0},
    "hysteresis": {"hysteresis": 0.15, "thread_way": 0.002, "thread_n": 1.0},
    "via_friction": {"friction": 0.15, "way": 0.001, "n": 1.0},
}


def test_every_law_is_tried():
    assert set(VALUES) == set(all_laws())


@cache
def moved(kind):
    """time (S,), q (S, J), lengths of all segments by band, and how they move the joints, by MuJoCo."""
    planner = mujoco_model(a_priori_robot())
    suit = fitted_suit("normal", planner, np.random.default_rng(3))
    model = mujoco_model(a_priori_robot(), suit)
    plan = {"bend": motion.bend, "twist": motion.twist}[kind](np.random.default_rng(8), 20.0, planner)
    knots = np.arange(len(plan.angles)) / motion.KNOT_RATE_HZ
    t = np.arange(0.0, knots[-1], STEP)
    q = CubicSpline(knots, plan.angles)(t)
    data, segments, slopes = mujoco.MjData(model), [], []
    for k, angles in enumerate(q):
        data.qpos[:3], data.qpos[3:7], data.qpos[7:] = plan.base[0], [1.0, 0.0, 0.0, 0.0], angles
        mujoco.mj_kinematics(model, data)
        points = [[data.site(f"{b.facts.name}_{p}").xpos.copy() for p in range(len(b.facts.via_points))]
                  for b in suit.bands]  # fmt: skip
        segments.append([np.diff(each, axis=0) for each in points])
        if k % EVERY == 0:
            mujoco.mj_comPos(model, data)
            slopes.append([_slopes(model, data, b.facts.name, along)
                           for b, along in zip(suit.bands, segments[-1], strict=True)])  # fmt: skip
    lengths = [np.array([np.linalg.norm(each[b], axis=1) for each in segments]) for b in range(len(suit.bands))]
    along = [np.array([each[b] for each in segments]) for b in range(len(suit.bands))]
    return suit, t, q, lengths, along, [np.array([each[b] for each in slopes]) for b in range(len(suit.bands))]


def _slopes(model, data, name, along):
    J = np.zeros((len(along) + 1, 3, model.nv))
    for k in range(len(J)):
        mujoco.mj_jacSite(model, data, J[k], None, model.site(f"{name}_{k}").id)
    unit = along / np.linalg.norm(along, axis=1)[:, None]
    return np.einsum("si,siv->sv", unit, np.diff(J, axis=0))[:, 6:]


def tension(law, size, k, l_0, t, segments, along):
    """(T, S) [N]"""
    length = segments.sum(axis=1)
    u, rate = length - l_0, np.gradient(length, t)
    x = np.maximum(u, 0.0)
    pull = k * x
    if law == "hardening":
        pull = pull + size["hardening"] * 0.01 * (10.0 * x) ** size["hardening_power"]
    if law == "softening":
        way = np.linspace(0.0, max(float(x.max()), 0.1), 5001)
        lost = cumulative_trapezoid(
            cumulative_trapezoid((1.0 + way / size["softening_stretch"]) ** -2, way, initial=0.0), way, initial=0.0
        )
        pull = pull - size["softening"] * 0.01 * np.interp(x, way, lost) / np.interp(0.1, way, lost)
    if law == "smooth_slack":
        soft = k * size["transition"] * np.logaddexp(0.0, u / size["transition"])
        pull = pull + size["gradual"] * (soft - pull)
    if law == "kelvin_voigt":
        pull = pull + (x > 0) * 0.1 * size["damping"] * np.sign(rate) * np.abs(10.0 * rate) ** size["damping_power"]
    if law == "maxwell":
        fast, slow = size["relaxation_time"], 5.0 * size["relaxation_time"]
        for stiffness, tau in ((size["branch_stiffness"], fast), (size["slow_branch_stiffness"], slow)):
            held = lfilter([stiffness], [1.0, -(1.0 - STEP / tau)], np.diff(x, prepend=x[:1]))
            pull = pull + (x > 0) * held
    if law == "hysteresis":
        leaning = np.zeros_like(pull)
        for n, step in enumerate(np.diff(length)):  # by small explicit steps
            leaning[n + 1] = leaning[n] + (step - leaning[n] * abs(step)) / size["thread_way"]
        pull = pull * (1.0 + size["hysteresis"] * leaning)
    pull = np.maximum(pull, 0.0)[:, None] * np.ones(segments.shape[1])
    return pull * _uneven(size, l_0, segments, along, x) if law == "via_friction" else pull


def _uneven(size, l_0, segments, along, x):
    """(T, S) of the mean along the band: each bristle leans towards where the band slides, and bends back."""
    length = segments.sum(axis=1)
    unit = along / segments[:, :, None]
    turn = np.arccos(np.clip(np.sum(unit[:, 1:] * unit[:, :-1], axis=2), -1.0, 1.0))
    place = l_0 * np.cumsum(segments, axis=1)[:, :-1] / length[:, None]
    lean, c = np.zeros_like(turn), np.zeros(turn.shape[1])
    for k in range(1, len(place)):
        step = (place[k] - place[k - 1]) / 4.0
        for _ in range(4):
            c = c + (1.0 - c * np.sign(step)) * step / size["way"]
        lean[k] = c
    ratio = np.exp(-size["friction"] * np.cumsum(lean * turn * (x > 0)[:, None], axis=1))
    ratio = np.column_stack([np.ones(len(ratio)), ratio])
    return ratio * length[:, None] / np.sum(ratio * segments, axis=1, keepdims=True)


@cache
def known_robot():
    tree = load_tree(robot_urdf().encode(), joints=JOINT_NAMES, base_link=BASE, floating=True)
    robot = Robot("hrp4_like", tree, tuple(Joint(name, "torque") for name in JOINT_NAMES), pin.SE3.Identity(), (),
                  np.eye(len(JOINT_NAMES)))  # fmt: skip
    base = find_base_parameters(tree)
    equations = Equations(robot, RowBlocks(tree, base, np.eye(3)), base, choose(Settings().effects))
    never_asked_for = {each.name: None for each in fields(RobotModel)} | {"inputs": TypeB(), "criteria": Criteria()}
    sure = np.zeros((equations.size, equations.size))
    return RobotModel(
        **(never_asked_for | {"equations": equations, "covariance": sure, "cutoff_hz": CUTOFF, "prepared": PerLog()})
    )


def device(suit, law):
    """As stated: the law and its values, of the springs nothing."""
    return Device("suit", tuple(
        Band(b.facts.name, b.facts.group, tuple(ViaPoint(p.link, p.xyz) for p in b.facts.via_points),
             law=law, law_values=VALUES[law])
        for b in suit.bands
    ))  # fmt: skip


def seen(law, stated, kind, seed):
    suit, t, q, segments, along, slopes = moved(kind)
    model, low_pass = known_robot(), butter(4, CUTOFF, fs=1.0 / (STEP * EVERY), output="sos")
    columns = np.array([JOINT_NAMES.index(name) for name in ACTED])
    torque = np.zeros((len(t[::EVERY]), len(ACTED)))
    for b, band in enumerate(suit.bands):
        T = tension(law, VALUES[law], band.stiffness, band.natural_length, t, segments[b], along[b])[::EVERY]
        torque -= np.einsum("ts,tsd->td", T, slopes[b][:, :, columns])
    rho = np.exp(-STEP * EVERY / 0.1)
    noise = np.random.default_rng(seed).normal(size=torque.shape)
    noise = lfilter([NOISE * np.sqrt(1 - rho**2)], [1.0, -rho], noise, axis=0)
    q, time = q[::EVERY], t[::EVERY]
    torque = sosfiltfilt(low_pass, torque, axis=0) + noise
    worn, always = device(suit, stated), np.ones(torque.shape, dtype=bool)
    kept = np.arange(200, len(time) - 200, 5)
    moves = always & (np.abs(np.gradient(q[:, columns], time, axis=0)).max(axis=1) > 0.02)[:, None]
    slope = np.zeros((len(kept[::20]), torque.shape[1], model.equations.size), dtype=np.float32)
    log = Log(f"{kind}_{seed}", time, {})
    known = dict.fromkeys((each.name for each in fields(Evidence)), None) | {
        "worn": WornLog(log, kind, worn), "time": time, "q": q[:, columns], "posture": q, "a": torque, "b": torque,
        "compared": moves, "steady": moves, "rest": ~moves, "kept": kept, "sloped": kept[::20],
        "inputs_a": Inputs(slope), "inputs_b": Inputs(slope),
        "length": Routing(model.robot.tree, worn.bands).geometry(q).length,
    }  # fmt: skip
    return Evidence(**known)


@cache
def identified(law, stated):
    evidences = [seen(law, stated, kind, seed) for seed, kind in enumerate(("bend", "twist", "bend", "twist"))]
    found = identify_bands(
        known_robot(), evidences[0].worn.device, "A", evidences, np.full(len(ACTED), NOISE), [], ACTED
    )
    return moved("bend")[0], found


@pytest.mark.parametrize("law", VALUES)
def test_the_stiffness_lies_in_its_95_percent_interval_whatever_the_law(law):
    suit, found = identified(law, law)
    for band, told in zip(suit.bands, found.bands, strict=True):
        low, high = told.stiffness_interval
        assert low <= band.stiffness <= high, (law, band.facts.name, told.stiffness)
        low, high = told.natural_length_interval
        assert low <= band.natural_length <= high, (law, band.facts.name, told.natural_length)
        assert told.stiffness.std < 0.03 * band.stiffness
        assert told.identifiable


@pytest.mark.parametrize("law", ["hardening", "smooth_slack", "maxwell", "via_friction"])  # a damper takes as it gives
def test_fitted_as_a_straight_spring_it_is_not(law):
    """What the table told before it knew the laws: the truth outside the interval of one band at least."""
    suit, found = identified(law, "linear")
    assert any(
        not told.stiffness_interval[0] <= band.stiffness <= told.stiffness_interval[1]
        or not told.natural_length_interval[0] <= band.natural_length <= told.natural_length_interval[1]
        for band, told in zip(suit.bands, found.bands, strict=True)
    )
