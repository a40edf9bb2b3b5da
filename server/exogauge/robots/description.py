"""A robot as its maker describes it: links, joints, sensors, and what is believed of each before any data;
loads that are weighed, and what logs cannot show of themselves: standard uncertainties of type B (GUM 4.3).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal, final

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from exogauge.robots.parameters import inertia_by_first_moment
from exogauge.robots.rows import RowLayout
from exogauge.robots.tree import RigidTree

Array = NDArray[np.float64]

Actuation = Literal["current", "torque", "none"]
JOINT_PARAMETERS = ("k_T", "k_d", "tau_c", "tau_s", "tau_o", "J_r")


@final
@dataclass(frozen=True)
class Joint:
    """One actuated joint. prior, prior_std: by the names in `JOINT_PARAMETERS`, joint-side SI units.

    actuation none: neither current nor torque is logged; the joint moves, and gives no equation of its own.
    A torque-actuated joint has k_T = 1, known. Missing priors are 0 (k_T of a current-actuated joint must be given),
    missing standard deviations are chosen by `identification.prior`.
    sign_checked: somebody has looked that it turns in the logs as it does in the URDF.
    """

    name: str
    actuation: Actuation
    gear_ratio: float | None = None
    prior: Mapping[str, float] = field(default_factory=dict)
    prior_std: Mapping[str, float] = field(default_factory=dict)
    sign_checked: bool = False


@final
@dataclass(frozen=True)
class WrenchSensor:
    """A six-axis force/torque sensor; wrench is force then moment, in the sensor frame.

    role contact: a known outside wrench; the robot ends at the sensor's frame (links beyond it are not modelled).
    sign: +1 when the log holds the wrench of the world on the robot, -1 when it is the reverse.
    role cut: a measurement that the bodies beyond the frame explain (`RigidTree.cuts`). sign: +1 when the log holds
    what they do to the sensor (their weight), -1 when it holds what holds and moves them.
    """

    name: str
    frame: str
    role: Literal["contact", "cut"]
    sign: float


@final
@dataclass(frozen=True)
class Declared:
    """Standard uncertainties, one standard deviation each; 0: known, or left out of the budget.

    ft_gain: share by which one force/torque sensor reads too much, each for itself; ft_gain_common: all of them alike,
    as after one calibration. ft_tilt [rad], ft_place [m]: how one stands beside its frame, about and along each axis.
    encoder_zero [rad]: of each joint that turns. clock [s]: by which a force/torque sensor, or the IMU, is told later
    than what drives and encoders read at the same instant. ft_zero_force [N],
    ft_zero_moment [N·m]: zero of one component, another in each log. kt_drift: share by which a motor gives more than
    k_T i, another in each log and joint; viscous_drift, coulomb_drift: by which it has more of that friction, the same.
    imu_tilt [rad]: of the IMU's mounting, about each axis across.
    zeros_taken: of force/torque sensors. `session`: as it began, and what is declared is how far they drift until its
    end; `log`: anew before each, so that no two logs err alike. torque_zero [N·m, N where it slides]: a constant of a
    joint's torque, another in each log, beside what zeros of force/torque sensors make of it; torque_zero_of: joint ->
    what is stated of it alone.
    defaulted: names of those that nobody stated.
    """

    ft_gain: float = 0.0
    ft_gain_common: float = 0.0
    ft_tilt: float = 0.0
    ft_place: float = 0.0
    ft_zero_force: float = 0.0
    ft_zero_moment: float = 0.0
    kt_drift: float = 0.0
    viscous_drift: float = 0.0
    coulomb_drift: float = 0.0
    imu_tilt: float = 0.0
    encoder_zero: float = 0.0
    clock: float = 0.0
    zeros_taken: Literal["session", "log"] | None = None
    torque_zero: float = 0.0
    torque_zero_of: Mapping[str, float] = field(default_factory=dict)
    defaulted: frozenset[str] = frozenset()


EXACT = Declared()


@final
@dataclass(frozen=True)
class Robot:
    """The described robot; J = number of actuated joints, in the order of the log's columns and of `tree.joints`.

    T_base_imu: IMU pose in the base link (floating base only).
    axes_from_joints: (J, J) matrix C, actuator axis coordinate = C @ joint angle, unit diagonal; identity where
    nothing is coupled. Joint torque = C.T @ axis torque. Friction, k_T and rotor inertia act on the axes.
    noise: std per channel kind (`q`, `i`, `tau`, `acc`, `gyro`, `force`, `moment`) where the maker gives it.
    inertial_std: relative std of the a-priori inertial parameters, by link name, "" = every other link.
    loads: weighed, and fixed to a link in some logs. declared: what its logs cannot show of themselves.
    """

    name: str
    tree: RigidTree
    joints: tuple[Joint, ...]
    T_base_imu: pin.SE3 | None
    sensors: tuple[WrenchSensor, ...]
    axes_from_joints: Array
    noise: Mapping[str, float] = field(default_factory=dict)
    inertial_std: Mapping[str, float] = field(default_factory=dict)
    loads: tuple[KnownLoad, ...] = ()
    declared: Declared = EXACT

    def __post_init__(self) -> None:
        names = tuple(joint.name for joint in self.joints)
        if names != self.tree.joints:
            raise ValueError(f"joints {names} differ from the tree's {self.tree.joints}")
        if self.axes_from_joints.shape != (len(names), len(names)):
            raise ValueError(f"axes_from_joints must be {(len(names),) * 2}, is {self.axes_from_joints.shape}")

    @property
    def floating(self) -> bool:
        return self.tree.floating

    @property
    def contacts(self) -> tuple[WrenchSensor, ...]:
        return tuple(sensor for sensor in self.sensors if sensor.role == "contact")

    @property
    def cuts(self) -> tuple[WrenchSensor, ...]:
        return tuple(sensor for sensor in self.sensors if sensor.role == "cut")

    @cached_property
    def rows(self) -> RowLayout:
        """Of its equations of motion."""
        return RowLayout.of(self.floating, len(self.joints), len(self.cuts))

    @cached_property
    def coupled(self) -> bool:
        """Whether any axis is not its joint."""
        return not np.array_equal(self.axes_from_joints, np.eye(len(self.joints)))

    def on_axes(self, coordinates: Array) -> Array:
        """(..., A) from those of joints, (..., J); the same array where nothing is coupled."""
        return coordinates @ self.axes_from_joints.T if self.coupled else coordinates

    def on_joints(self, torques: Array) -> Array:
        """(..., J) from those on axes, (..., A); the same array where nothing is coupled."""
        return torques @ self.axes_from_joints if self.coupled else torques

    @property
    def torque_zero(self) -> Array:
        """(J,) [N·m, N where it slides] standard uncertainty of a constant torque that is another in each log."""
        declared = self.declared
        return np.array([declared.torque_zero_of.get(joint.name, declared.torque_zero) for joint in self.joints])

    def phi_in(self, recording: str) -> Array:
        """(N, 10) a-priori bodies, with the loads that a recording carries."""
        phi = self.tree.phi
        for load in self.loads:
            if recording in load.logs:
                phi = phi.copy()
                phi[load.body] += load.phi
        return phi


GYRATION_M = 0.1  # radius of gyration that hardly any load on an arm exceeds: a disc of 28 cm has it


@final
@dataclass(frozen=True)
class KnownLoad:
    """name: its link, with a number where that carries several. body: of the tree, what the link is a part of.

    mass, std: [kg]. centre: (3,) [m] of mass, in the body's frame; std_centre: [m], alike in all directions.
    logs: names of the recordings that carry it.
    """

    name: str
    body: int
    mass: float
    std: float
    centre: tuple[float, float, float]
    std_centre: float
    logs: tuple[str, ...]

    @property
    def columns(self) -> Array:
        """(10, 10) inertial parameters of the body (as `RigidTree.phi`) per coefficient.

        A mass at the stated centre; a first moment beside it, which takes its inertia along; inertia about the centre.
        """
        c, apart = np.array(self.centre), inertia_by_first_moment(np.array(self.centre))
        columns = np.eye(10)
        columns[1:4, 0], columns[4:, 0] = c, 0.5 * apart @ c
        columns[4:, 1:4] = apart
        return columns

    @property
    def mean(self) -> Array:
        """(10,) of the coefficients."""
        return np.array([self.mass, *np.zeros(9)])

    @property
    def doubt(self) -> Array:
        """(10,) standard deviations of the coefficients. Inertia was not stated: how wide the load is, and the square
        of how far its centre may be off; half of that off the diagonal."""
        inertia = self.mass * (GYRATION_M**2 + self.std_centre**2)
        return np.array([self.std, *[self.mass * self.std_centre] * 3, *inertia * np.array([1, 0.5, 1, 0.5, 0.5, 1])])

    @property
    def phi(self) -> Array:
        """(10,) as stated, of the body it is fixed to."""
        return np.asarray(self.columns @ self.mean)


def drifts_in_doubt(robot: Robot) -> dict[str, Array]:
    """Each drift that is declared -> (A,) standard deviation of every motor's share; of k_T none where torque is
    logged."""
    declared, driven = robot.declared, np.array([joint.actuation == "current" for joint in robot.joints])
    found = {
        "kt_drift": declared.kt_drift * driven,
        "viscous_drift": np.full(len(driven), declared.viscous_drift),
        "coulomb_drift": np.full(len(driven), declared.coulomb_drift),
    }
    return {name: size for name, size in found.items() if size.any()}
