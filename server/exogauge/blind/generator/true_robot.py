"""The robot that makes the logs: the a-priori one with every number drawn anew, by what robot.yaml says of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.blind.generator.cut import Cut, cut_at
from exogauge.blind.generator.dynamics import Tree, bodies_of, tree_of
from exogauge.synthetic.inertia import Mass, of_shape
from exogauge.synthetic.robot_facts import Drive, Link

Array = NDArray[np.float64]

INERTIAL_STD = 0.12  # relative: of mass, and of the centre in radii of gyration; of each extent, half of it
K_T_STD = {"calibrated": 0.02, "data sheet": 0.07}  # relative
FRICTION_STD = 0.3  # relative, of k_d, tau_c and tau_s
OFFSET_STD = 0.1  # of tau_o, relative to tau_c
ROTOR_STD = 0.2  # relative
STATIC_OVER_COULOMB = 1.08  # the a-priori tau_s / tau_c
FURTHEST = 2.5  # standard deviations: no number is further off


@final
@dataclass(frozen=True)
class TrueDrive:
    """One joint's drive, joint side: k_T i + tau_o = body + J_r ddq + k_d dq + friction. gear: motor turns per turn."""

    k_T: float
    k_d: float
    tau_c: float
    tau_s: float
    tau_o: float
    J_r: float
    gear: float


@final
@dataclass(frozen=True)
class TrueRobot:
    """masses: of links that have one. phi: (J, 10) of the moving bodies. cut: what the force/torque sensor carries."""

    tree: Tree
    masses: Mapping[str, Mass]
    phi: Array
    cut: Cut
    drives: tuple[TrueDrive, ...]


def a_priori(drive: Drive) -> dict[str, float]:
    """What the maker's table says of a drive."""
    tau_s = STATIC_OVER_COULOMB * drive.tau_c
    return {"k_T": drive.k_T, "k_d": drive.k_d, "tau_c": drive.tau_c, "tau_s": tau_s, "tau_o": 0.0, "J_r": drive.J_r}


def a_priori_std(drive: Drive, k_T_std: float) -> dict[str, float]:
    """Standard deviation of the truth about `a_priori`; k_T_std: of `K_T_STD`."""
    return {
        "k_T": k_T_std * drive.k_T,
        "k_d": FRICTION_STD * drive.k_d,
        "tau_c": FRICTION_STD * drive.tau_c,
        "tau_s": FRICTION_STD * STATIC_OVER_COULOMB * drive.tau_c,
        "tau_o": OFFSET_STD * drive.tau_c,
        "J_r": ROTOR_STD * drive.J_r,
    }


def draw_robot(rng: np.random.Generator, links: Sequence[Link], frame: str, k_T_std: float) -> TrueRobot:
    """A robot of the population that the a-priori values and their standard deviations describe.

    frame: the sensor's. k_T_std: of `K_T_STD`.
    """
    masses = {link.name: _drawn_mass(rng, link) for link in links if link.mass > 0.0}
    drives = tuple(_drawn_drive(rng, link.joint.drive, k_T_std) for link in links if link.joint is not None)
    tree = tree_of(links)
    return TrueRobot(tree, masses, bodies_of(links, masses), cut_at(links, frame, tree, masses), drives)


def record(robot: TrueRobot, joints: Sequence[str]) -> Mapping[str, Mapping[str, float]]:
    """The drives' true numbers by joint, for the answers."""
    keys = ("k_T", "k_d", "tau_c", "tau_s", "tau_o", "J_r")
    return {
        joint: {key: getattr(drive, key) for key in keys} for joint, drive in zip(joints, robot.drives, strict=True)
    }


def _drawn_mass(rng: np.random.Generator, link: Link) -> Mass:
    """Another density, other extents, another centre: possible by construction."""
    even = of_shape(link)
    mass = even.mass * (1.0 + INERTIAL_STD * _deviation(rng, 1)[0])
    centre = even.centre + INERTIAL_STD * even.gyration * _deviation(rng, 3)
    extents = 1.0 + 0.5 * INERTIAL_STD * _deviation(rng, 3)
    return Mass(float(mass), centre, even.spread * np.outer(extents, extents))


def _drawn_drive(rng: np.random.Generator, drive: Drive, k_T_std: float) -> TrueDrive:
    e = _deviation(rng, 5)
    tau_c = drive.tau_c * (1.0 + FRICTION_STD * e[2])
    return TrueDrive(
        k_T=float(drive.k_T * (1.0 + k_T_std * e[0])),
        k_d=float(drive.k_d * (1.0 + FRICTION_STD * e[1])),
        tau_c=float(tau_c),
        tau_s=float(tau_c * rng.uniform(1.0, 2.0 * STATIC_OVER_COULOMB - 1.0)),
        tau_o=float(OFFSET_STD * drive.tau_c * e[3]),
        J_r=float(drive.J_r * (1.0 + ROTOR_STD * e[4])),
        gear=drive.gear_ratio,
    )


def _deviation(rng: np.random.Generator, size: int) -> Array:
    return np.clip(rng.standard_normal(size), -FURTHEST, FURTHEST)
