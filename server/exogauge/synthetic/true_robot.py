"""The robot that makes the logs: the a-priori one with every number drawn anew, and the parameters to be found."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.synthetic.hidden import Hidden
from exogauge.synthetic.inertia import PHI_NAMES, Mass, joined, of_shape
from exogauge.synthetic.robot_facts import BY_NAME, FEET, JOINTS, LINKS, Drive, Link

Array = NDArray[np.float64]

INERTIAL_STD = 0.15  # relative: of mass; of the centre, per axis and in radii of gyration; of each extent, half of it
K_T_STD = 0.10  # relative
FRICTION_STD = 0.30  # relative, of k_d, tau_c and tau_s
OFFSET_STD = 0.10  # of tau_o, relative to tau_c
ROTOR_STD = 0.25  # relative
STATIC_OVER_COULOMB = 1.05  # the a-priori tau_s / tau_c
CUT = 2.5  # deviations beyond this many standard deviations are drawn again


@final
@dataclass(frozen=True)
class JointTruth:
    """One joint's drive, joint side: k_T i + tau_o drives; k_d θ̇ + friction, J_r θ̈ and the body resist.

    Friction is tau_c sgn θ̇ while moving, anything within ±tau_s at rest. tau_b, v_s: a Stribeck peak on top.
    """

    k_T: float
    k_d: float
    tau_c: float
    tau_s: float
    tau_o: float
    J_r: float
    tau_b: float = 0.0
    v_s: float = 0.05

    def parameters(self) -> dict[str, float]:
        """The six numbers an identification reports."""
        return {name: getattr(self, name) for name in ("k_T", "k_d", "tau_c", "tau_s", "tau_o", "J_r")}


@final
@dataclass(frozen=True)
class TrueRobot:
    """masses: every link that has one, by its name; joints: by joint name."""

    masses: Mapping[str, Mass]
    joints: Mapping[str, JointTruth]


def a_priori_joint(drive: Drive) -> JointTruth:
    """What the maker's table says of a drive."""
    tau_s = STATIC_OVER_COULOMB * drive.tau_c
    return JointTruth(drive.k_T, drive.k_d, drive.tau_c, tau_s, 0.0, drive.J_r)


def a_priori_joint_std(drive: Drive) -> dict[str, float]:
    """Standard deviation of the truth about `a_priori_joint`; for tau_s including that it is never below tau_c."""
    return {
        "k_T": K_T_STD * drive.k_T,
        "k_d": FRICTION_STD * drive.k_d,
        "tau_c": FRICTION_STD * drive.tau_c,
        "tau_s": FRICTION_STD * STATIC_OVER_COULOMB * drive.tau_c,
        "tau_o": OFFSET_STD * drive.tau_c,
        "J_r": ROTOR_STD * drive.J_r,
    }


def a_priori_robot() -> TrueRobot:
    """The robot as its maker describes it."""
    masses = {link.name: of_shape(link) for link in LINKS if link.mass > 0.0}
    return TrueRobot(masses, {joint.name: a_priori_joint(joint.drive) for joint in JOINTS})


def draw_robot(rng: np.random.Generator, hidden: Sequence[Hidden] = ()) -> TrueRobot:
    """A robot of the population that the a-priori values and their standard deviations describe."""
    masses = {link.name: _drawn_mass(rng, link) for link in LINKS if link.mass > 0.0}
    joints = {joint.name: _drawn_joint(rng, joint.drive) for joint in JOINTS}
    for effect in hidden:
        values = effect.parameters
        if effect.effect == "stribeck":
            joints[effect.place] = replace(joints[effect.place], tau_b=values["tau_b"], v_s=values["v_s"])
        elif effect.effect == "payload":
            centre = np.array([values["x"], values["y"], values["z"]])
            load = Mass(values["mass"], centre, np.eye(3) * values["radius"] ** 2 / 5.0)
            masses[effect.place] = joined([masses[effect.place], load])
    return TrueRobot(masses, joints)


def moving_bodies(masses: Mapping[str, Mass]) -> dict[str, Mass]:
    """Bodies by the link their joint moves (the base first), fixed children merged in, without the soles."""
    parts: dict[str, list[Mass]] = {}
    for link in LINKS:
        root, offset = _carrier(link)
        if link.name in masses and (root is link or root.name not in FEET):
            parts.setdefault(root.name, []).append(masses[link.name].moved(offset))
    return {name: joined(bodies) for name, bodies in parts.items()}


def truth_record(robot: TrueRobot, hidden: Sequence[Hidden]) -> dict[str, object]:
    """truth.json: names as in results.json, `m[chest]`, `k_T[torso_pitch]` …"""
    parameters: dict[str, float] = {}
    for body, mass in moving_bodies(robot.masses).items():
        parameters |= {f"{name}[{body}]": float(value) for name, value in zip(PHI_NAMES, mass.phi(), strict=True)}
    joints = {name: truth.parameters() for name, truth in robot.joints.items()}
    for name, values in joints.items():
        parameters |= {f"{key}[{name}]": value for key, value in values.items()}
    effects = [{"effect": h.effect, "where": h.where, "parameters": dict(h.parameters)} for h in hidden]
    return {"synthetic": True, "parameters": parameters, "joints": joints, "bands": {}, "effects": effects}


def _carrier(link: Link) -> tuple[Link, Array]:
    """The link whose joint moves this one, and this link's origin in that link's frame (parallel to its own)."""
    offset = np.zeros(3)
    while link.joint is None and link.parent is not None:
        offset += link.origin
        link = BY_NAME[link.parent]
    return link, offset


def _deviation(rng: np.random.Generator, size: int) -> Array:
    """Standard normal numbers, none beyond `CUT`."""
    drawn = rng.standard_normal(size)
    while np.any(beyond := np.abs(drawn) > CUT):
        drawn[beyond] = rng.standard_normal(int(beyond.sum()))
    return drawn


def _drawn_mass(rng: np.random.Generator, link: Link) -> Mass:
    """Another density, extents, centre and a slight tilt of the principal axes: possible by construction."""
    even = of_shape(link)
    mass = even.mass * (1.0 + INERTIAL_STD * _deviation(rng, 1)[0])
    centre = even.centre + INERTIAL_STD * even.gyration * _deviation(rng, 3)
    extents = 1.0 + 0.5 * INERTIAL_STD * _deviation(rng, 3)
    tilt = _rotation(INERTIAL_STD * _deviation(rng, 3))
    return Mass(float(mass), centre, tilt @ (even.spread * np.outer(extents, extents)) @ tilt.T)


def _drawn_joint(rng: np.random.Generator, drive: Drive) -> JointTruth:
    e = _deviation(rng, 5)
    tau_c = drive.tau_c * (1.0 + FRICTION_STD * e[2])
    return JointTruth(
        k_T=float(drive.k_T * (1.0 + K_T_STD * e[0])),
        k_d=float(drive.k_d * (1.0 + FRICTION_STD * e[1])),
        tau_c=float(tau_c),
        tau_s=float(tau_c * rng.uniform(1.0, 2.0 * STATIC_OVER_COULOMB - 1.0)),
        tau_o=float(OFFSET_STD * drive.tau_c * e[3]),
        J_r=float(drive.J_r * (1.0 + ROTOR_STD * e[4])),
    )


def _rotation(angles: Array) -> Array:
    """(3, 3) rotation by the vector `angles` [rad] (Rodrigues)."""
    angle = float(np.linalg.norm(angles))
    x, y, z = angles / max(angle, 1e-12)
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + np.sin(angle) * K + (1.0 - np.cos(angle)) * K @ K)
