"""What a motion would tell of the robot's own parameters, and how that changes with the motion.

The rows are the identification's own, by its regressor, in its base parameters: nothing is modelled twice.
"""

from __future__ import annotations

from functools import cached_property
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.estimation.prior import Prior
from exogauge.identification.equations import Equations
from exogauge.identification.predict import split
from exogauge.robots.kinematics import Kinematics
from exogauge.robots.motion import Motion
from exogauge.robots.row_slopes import MotionSlopes, WeightedRow, row_slopes
from exogauge.robots.rows import RowType

Array = NDArray[np.float64]
IntArray = NDArray[np.intp]

TOLD = {"motor_gain", "viscous", "coulomb", "static_friction", "motor_offset", "rotor_inertia"}


@final
class Information:
    """Of base parameters and joint parameters, from rows of the base's wrench and of every axis in steady motion.

    Rows of sensors that carry bodies are left out. prior: what is known before. known: (P, P) the same where earlier
    logs hold more. weights: (rows,) 1/variance of a sample of each base and axis row. per_s: samples that a log has
    per second. turn_s: so near to a turn an axis counts half. slow: (A,) [rad/s] so slow it does, too.
    """

    def __init__(
        self, equations: Equations, prior: Prior, weights: Array, per_s: float, turn_s: float, slow: Array,
        known: Array | None = None,
    ) -> None:  # fmt: skip
        unknown = {effect.name for effect in equations.effects} - TOLD
        if unknown:
            raise ValueError(f"nothing is known of how these change with a motion: {', '.join(sorted(unknown))}")
        self.equations, self.prior, self.weights = equations, prior, weights
        self.per_s, self.turn_s, self.slow = per_s, turn_s, slow
        self.kinematics = Kinematics(equations.robot.tree)
        self.free: IntArray = prior.free.astype(np.intp)
        self.before: Array = prior.information(1.0) if known is None else known[np.ix_(self.free, self.free)]
        self.names = [effect.name for effect in equations.effects]
        self.at = split(equations, prior.mean)

    @property
    def base_rows(self) -> int:
        """6 or 0."""
        return len(self.equations.layout.numbers(RowType.BASE))

    @cached_property
    def phi(self) -> Array:
        """(B,) a-priori base parameters."""
        return np.asarray(self.equations.base.regroup @ self.at.phi.ravel())

    @cached_property
    def beyond(self) -> list[IntArray]:
        """Bodies that each axis carries."""
        tree = self.equations.robot.tree
        carried = tree.subtree
        return [np.flatnonzero(carried[int(np.flatnonzero(tree.dof == j)[0])]) for j in range(len(tree.joints))]

    def loads(self, motion: Motion) -> Array:
        """(T, base rows + A) what the a-priori robot asks for."""
        whole = self.equations.of_bodies(motion, self.phi)
        return np.ascontiguousarray(whole[:, : self.base_rows + len(self.equations.robot.joints)])

    def of(self, motion: Motion, seconds: float, outside: Array | None = None) -> Told:
        """motion: samples that stand evenly for `seconds`. outside: (T, A) [N·m] what the contacts bear of the axes'
        loads, taken as it is."""
        return Told(self, motion, seconds, np.zeros((1, 1)) if outside is None else outside)


@final
class Told:
    """What one motion tells. loads: (T, base rows + A) what the a-priori robot asks for."""

    def __init__(self, information: Information, motion: Motion, seconds: float, outside: Array) -> None:
        self.information, self.motion = information, motion
        equations, base = information.equations, information.base_rows
        effects, axes = len(equations.effects), len(equations.robot.joints)
        blocks = equations.blocks.fill(motion, effects)
        columns = equations.blocks.columns
        self.loads = np.column_stack(
            [block[:, : len(own)] @ information.phi[own] for block, own in zip(blocks, columns, strict=True)]
        )
        C = equations.robot.axes_from_joints
        self.v, self.a = motion.dq @ C.T, motion.ddq @ C.T
        xi = {name: information.at.xi[:, k] for k, name in enumerate(information.names)}
        xi = {name: xi.get(name, np.zeros(axes)) for name in TOLD}
        direction = np.sign(self.v)
        motor = (self.loads[:, base:] - outside + xi["viscous"] * self.v + xi["coulomb"] * direction
                 - xi["motor_offset"] + xi["rotor_inertia"] * self.a)  # fmt: skip
        self.motor, self.xi = motor, xi
        current = np.array([joint.actuation == "current" for joint in equations.robot.joints])
        self.gain = np.where(current, xi["motor_gain"], 1.0)
        given = {
            "motor_gain": -motor / self.gain, "viscous": self.v, "coulomb": direction, "rotor_inertia": self.a,
            "motor_offset": -np.ones_like(self.v), "static_friction": np.zeros_like(self.v),
        }  # fmt: skip
        slow2 = (information.turn_s * self.a) ** 2 + information.slow**2
        self.steady = self.v**2 / (self.v**2 + slow2)
        each = information.per_s * seconds / motion.samples
        self.rows: list[Array] = []
        self.columns: list[IntArray] = []
        self.counts: list[Array] = []
        size = equations.size
        H = np.zeros((size, size))
        for r, (block, own) in enumerate(zip(blocks, columns, strict=True)):
            A = block[:, : len(own)]
            count = np.full(motion.samples, each * information.weights[r])
            if r >= base:
                A = np.concatenate([A, *(given[name][:, r - base, None] for name in information.names)], axis=1)
                own = np.concatenate([own, equations.effect_columns(r - base)])
                count = count * self.steady[:, r - base]
            weighted = A * np.sqrt(count)[:, None]
            H[own[:, None], own] += weighted.T @ weighted
            self.rows.append(np.ascontiguousarray(A))
            self.columns.append(own)
            self.counts.append(count)
        self.seen: Array = H
        free = information.free
        whole = H[np.ix_(free, free)] + information.before
        self.scale = 1.0 / np.sqrt(np.diag(whole))
        self.root = np.linalg.cholesky(whole * np.outer(self.scale, self.scale))

    @property
    def cost(self) -> float:
        """Mean of ln of the standard deviations along the principal axes: -½ log det of the information, by number."""
        log = np.log(np.diag(self.root)).sum() - np.log(self.scale).sum()
        return float(-log / len(self.scale))

    @cached_property
    def covariance(self) -> Array:
        """(P, P), zero of what is known exactly."""
        inverse = np.linalg.inv(self.root) * self.scale
        out = np.zeros(self.seen.shape)
        free = self.information.free
        out[np.ix_(free, free)] = inverse.T @ inverse
        return out

    def slopes(self, cost: float = 1.0, loads: Array | None = None) -> MotionSlopes:
        """Of cost · `cost` + Σ loads · `self.loads`. loads: (T, base rows + A)."""
        information, motion = self.information, self.motion
        equations, tree = information.equations, information.equations.robot.tree
        base, names = information.base_rows, information.names
        T, A = self.v.shape
        C, share = self.covariance, -cost / len(self.scale)
        asks = np.zeros_like(self.loads) if loads is None else loads.copy()
        by_v, by_a = np.zeros((T, A)), np.zeros((T, A))
        phi = [np.zeros((len(tree.bodies), T, 10)) for _ in range(len(self.rows))]
        of_joints = equations.robot.axes_from_joints
        mixed = np.linalg.inv(of_joints).T  # axis torque = mixed @ joint torque
        weighted = []
        for r, (rows, own, count) in enumerate(zip(self.rows, self.columns, self.counts, strict=True)):
            towards = rows @ C[np.ix_(own, own)]
            G = share * count[:, None] * towards
            k = len(equations.blocks.columns[r])
            if r >= base:
                axis = r - base
                on = dict(zip(names, G[:, k:].T, strict=True))
                through = -on["motor_gain"] / self.gain[axis] if "motor_gain" in on else np.zeros(T)
                asks[:, r] += through
                by_v[:, axis] += on.get("viscous", 0.0) + through * self.xi["viscous"][axis]
                by_a[:, axis] += on.get("rotor_inertia", 0.0) + through * self.xi["rotor_inertia"][axis]
                leverage = 0.5 * share * np.einsum("tk,tk->t", rows, towards)
                by_steady = leverage * count / np.maximum(self.steady[:, axis], 1e-300)
                v, a, turn = self.v[:, axis], self.a[:, axis], information.turn_s
                beside = (turn * a) ** 2 + information.slow[axis] ** 2
                whole = (v**2 + beside) ** 2
                by_v[:, axis] += by_steady * 2.0 * v * beside / whole
                by_a[:, axis] -= by_steady * v**2 * 2.0 * turn**2 * a / whole
            body, kind = np.divmod(equations.base.columns[own[:k]], 10)
            phi[r][body, :, kind] = (G[:, :k] + asks[:, r, None] * information.phi[own[:k]]).T
        for r in range(base):
            along = np.zeros((T, 6))
            along[:, r] = 1.0
            weighted.append(WeightedRow(along, -1, np.arange(len(tree.bodies)), phi[r]))
        sweep = information.kinematics.sweep(motion)
        for j in range(A):
            total = np.sum([mixed[a, j] * phi[base + a] for a in range(A) if mixed[a, j]], axis=0)
            link = int(np.flatnonzero(tree.dof == j)[0])
            carried = information.beyond[j]
            weighted.append(WeightedRow(sweep.S[link].T, link, carried, total[carried]))
        found = row_slopes(information.kinematics, motion, sweep, weighted)
        return MotionSlopes(found.q, found.dq + by_v @ of_joints, found.ddq + by_a @ of_joints, found.acc, found.gyro,
                            found.gyro_dot)  # fmt: skip
