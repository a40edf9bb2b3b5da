"""What is believed of every parameter before the data: the maker's values and how far they may be wrong."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.identifying import DECLARED
from exogauge.effects.effect import JointEffect
from exogauge.estimation.prior import Prior
from exogauge.estimation.statistics import Statistics
from exogauge.identification.added_columns import AddedColumn
from exogauge.identification.equations import Equations
from exogauge.identification.preparation import Prepared
from exogauge.robots.description import Joint, Robot
from exogauge.robots.parameters import BaseParameters

Array = NDArray[np.float64]

NOTHING_ADDED = np.zeros(0)


@final
@dataclass(frozen=True)
class Scales:
    """Typical sizes seen on each actuator axis, (A,): what a friction could be at all.

    torque [N·m], velocity [rad/s], acceleration [rad/s²].
    """

    torque: Array
    velocity: Array
    acceleration: Array


def scales(robot: Robot, logs: Sequence[Prepared]) -> Scales:
    """Root mean squares over the fitted logs, with the a-priori k_T where currents are logged."""

    def rms(columns: Sequence[Array]) -> Array:
        return np.asarray(np.sqrt(np.mean(np.vstack(columns) ** 2, axis=0)) + 1e-9)

    k_T = np.array([joint_prior(joint, "k_T") for joint in robot.joints])
    return Scales(
        torque=np.abs(k_T) * rms([log.drive[log.kept] for log in logs]),
        velocity=rms([log.axis_velocity[log.kept] for log in logs]),
        acceleration=rms([log.axis_acceleration[log.kept] for log in logs]),
    )


def joint_prior(joint: Joint, name: str) -> float:
    """A-priori value of one joint parameter; k_T is 1 by definition where torque is logged."""
    if name == "k_T" and joint.actuation != "current":
        return 1.0
    return float(joint.prior.get(name, 0.0))


def per_parameter(
    robot: Robot,
    base: BaseParameters,
    effects: Sequence[JointEffect],
    seen: Scales,
    added: Array = NOTHING_ADDED,
    columns: Sequence[AddedColumn] = (),
) -> Prior:
    """A standard deviation for every parameter: the maker's where given, else a spread that its size suggests.

    added: (E,) standard deviations of added coefficients. columns: what they are; without, nothing was known of them.
    """
    stated = np.array([0.0 if column.measured is None else column.measured[0] for column in columns])
    mean = [robot.tree.phi.ravel(), _joint_means(robot, effects).ravel(), stated if columns else np.zeros(len(added))]
    std = np.concatenate([inertial_std(robot).ravel(), _joint_stds(robot, effects, seen).ravel(), added])
    measured = np.zeros(len(std), dtype=bool)
    measured[len(std) - len(columns) :] = [column.measured is not None for column in columns]
    seen_by = seen_matrix(base, len(robot.joints) * len(effects) + len(added))
    return Prior(np.concatenate(mean), std, seen_by, measured)


def added_std(equations: Equations, logs: Sequence[Prepared], seen: Scales) -> Array:
    """(E,) as large as what was seen in each column's rows could make its coefficient, or as it was measured."""
    if not equations.added:
        return NOTHING_ADDED
    column, kind = np.array(equations.entries, dtype=np.intp).T
    per_unit = np.sqrt(np.mean(np.vstack([log.added[log.kept] for log in logs]) ** 2, axis=0)) + 1e-12
    std = np.full(len(equations.added), np.inf)
    np.minimum.at(std, column, row_sizes(equations, logs, seen)[kind] / per_unit)
    return np.array([s if c.measured is None else c.measured[1] for s, c in zip(std, equations.added, strict=True)])


def row_sizes(equations: Equations, logs: Sequence[Prepared], seen: Scales) -> Array:
    """(kinds,) root mean square of what each kind of row explains [N or N·m]."""

    def rms(wrenches: Sequence[Array]) -> Array:
        return np.asarray(np.sqrt(np.mean(np.concatenate(wrenches) ** 2, axis=0)) + 1e-9)

    outside = rms([log.wrenches[log.kept].sum(axis=1) for log in logs])[equations.layout.base]
    carried = rms([log.carried[log.kept] for log in logs]).ravel()
    return np.concatenate([outside, seen.torque, seen.torque, carried])


def as_printed(equations: Equations, prior: Prior, statistics: Statistics, weights: Array) -> Prior:
    """The uniform weights of [Evaluator] (16)-(17): one for φ, one for each kind of joint parameter.

    Differs from print: Λ_T is what (19) calls Λ_ξ; (18) is Σ (Y_o^T W_o Y_o + Y_j^T W_j Y_j), and what a sensor inside
    the robot says of φ adds to it, but not to N_T σ_max(W_j), which is of joint rows alone. All w are 1 here, the
    common factor is the prior's strength; reflected inertia weighs like viscous friction, by its own Λ. An effect that
    no row sees (no torque was logged) keeps the spread of `per_parameter`.
    """
    G, _, _ = statistics.normal(weights)
    D, inertial, B, K = prior.seen, equations.robot.tree.phi.size, equations.base_size, len(equations.effects)
    regroup = D[:B, :inertial]
    largest = np.linalg.eigvalsh(regroup.T @ G[:B, :B] @ regroup)[-1]
    own = len(equations.robot.joints) * K
    information = np.diag(G)[B : B + own].reshape(-1, K).max(axis=0)  # σ_max of Λ_T, Λ_d, both diagonal
    signs = [k for k, effect in enumerate(equations.effects) if effect.coefficient.name in ("tau_c", "tau_s", "tau_o")]
    joints = equations.layout.axes
    information[signs] = statistics.count[joints].max() * weights[joints].max()  # N_T σ_max(W_j)
    std = np.full(len(prior.mean), 1.0 / np.sqrt(largest))
    uniform = np.tile(1.0 / np.sqrt(np.where(information > 0.0, information, 1.0)), len(equations.robot.joints))
    seen = np.tile(information > 0.0, len(equations.robot.joints))
    std[inertial:] = prior.std[inertial:]
    std[inertial : inertial + own] = np.where(seen, uniform, prior.std[inertial : inertial + own])
    return replace(prior, std=np.where(prior.std == 0.0, 0.0, std))


def seen_matrix(base: BaseParameters, joint_parameters: int) -> Array:
    """D with x = D [φ; ξ]: base parameters of φ, ξ itself."""
    B, standard = base.regroup.shape
    D = np.zeros((B + joint_parameters, standard + joint_parameters))
    D[:B, :standard] = base.regroup
    D[B:, standard:] = np.eye(joint_parameters)
    return D


def inertial_std(robot: Robot) -> Array:
    """(N, 10) standard deviations from a relative spread ρ of mass and of lengths.

    m: ρ m. First moments: the centre of mass wrong by ρ times the radius of gyration g, and the mass's own error.
    Inertia about the origin: 2 ρ of m (g² + c²), as lengths enter squared; half of that off the diagonal.
    """
    phi, rho = robot.tree.phi, relative_std(robot)
    floor = DECLARED.light_share * phi[:, 0].mean()
    m = np.maximum(phi[:, 0], floor)
    c_squared = np.sum((phi[:, 1:4] / m[:, None]) ** 2, axis=1)
    trace = phi[:, 4] + phi[:, 6] + phi[:, 9]
    gyration = np.maximum(np.sqrt(np.maximum(trace / (2.0 * m) - c_squared, 0.0)), DECLARED.gyration_m)
    std = np.empty_like(phi)
    std[:, 0] = rho * m
    std[:, 1:4] = (rho * m * np.sqrt(gyration**2 + c_squared))[:, None]
    std[:, 4:] = (2.0 * rho * m * (gyration**2 + c_squared))[:, None]
    std[:, [5, 7, 8]] *= 0.5
    return std


def relative_std(robot: Robot) -> Array:
    """(N,) of mass and of lengths."""
    return np.array(
        [robot.inertial_std.get(b, robot.inertial_std.get("", DECLARED.inertial)) for b in robot.tree.bodies]
    )


def _joint_means(robot: Robot, effects: Sequence[JointEffect]) -> Array:
    names = [effect.coefficient.name for effect in effects]
    return np.array([[joint_prior(j, name) for name in names] for j in robot.joints])


def _joint_stds(robot: Robot, effects: Sequence[JointEffect], seen: Scales) -> Array:
    """(A, K): the maker's spread, or as large as the torque that was seen could make the coefficient."""
    possible = {
        "k_d": seen.torque / seen.velocity,
        "J_r": seen.torque / seen.acceleration,
    }
    std = np.empty((len(robot.joints), len(effects)))
    for a, joint in enumerate(robot.joints):
        for k, effect in enumerate(effects):
            name = effect.coefficient.name
            if name == "k_T" and joint.actuation != "current":
                std[a, k] = 0.0
            elif name in joint.prior_std:
                std[a, k] = joint.prior_std[name]
            elif name == "k_T":
                std[a, k] = DECLARED.gain * abs(joint_prior(joint, name))
            else:
                std[a, k] = possible.get(name, seen.torque)[a]
    return std
