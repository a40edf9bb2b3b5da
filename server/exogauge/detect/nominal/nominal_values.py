"""The maker's numbers that can be wrong without a residual: what links weigh, what motors give per ampere.

How much more likely the data become when a number of the maker is let go, over all that the stated doubts allow.

A free parameter absorbs a number that is wrong, so no residual shows it. What shows it is how far the data lie from the
prior: the ratio of the marginal likelihoods with and without a broad belief in place of the stated one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal, final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.detecting import Contradicting
from exogauge.estimation.least_squares import PriorLeastSquares
from exogauge.estimation.prior import Prior
from exogauge.identification.equations import Equations
from exogauge.identification.model import RobotModel
from exogauge.identification.prior import relative_std
from exogauge.identification.solution import Solution
from exogauge.robots.parameters import inertia_by_first_moment
from exogauge.search.ambiguity import Number, Undecided

Array = NDArray[np.float64]
Sort = Literal["load", "scaled", "centre", "gain", "gains", "feet"]


@final
@dataclass(frozen=True)
class Stated:
    """sort: `load` ten parameters, mass [kg] first, on top of body `index`; `scaled` that body denser by a share;
    `centre` its centre of mass elsewhere, all of its inertia with it, in radii of gyration as its doubt is stated;
    `gain` the motor of axis `index` gives more by a share; `gains` all of them alike; `feet` all contact sensors read
    too much by a share, or all bodies are heavier and all motors give more by it. columns: among `LettingGo`'s. broad:
    (k,) std of each change before the data."""

    sort: Sort
    index: int
    columns: IntArray
    broad: Array


def stated_numbers(model: RobotModel, bodies: Sequence[int], memory: Array) -> tuple[list[Stated], LettingGo]:
    """bodies: links in question. memory: (rows,) samples of each kind of row that count as one.

    Gains only where something fixes the scale of all torques: else a common factor would fall on one of them.
    """
    rows, phi, criteria = _Rows(model, memory), model.robot.tree.phi, model.criteria.nominal
    broad_load, broad_share, broad_gain = _broad(criteria), criteria.broad_share, criteria.broad_gain
    numbers: list[Stated] = []

    def add(sort: Sort, index: int, broad: Array) -> None:
        first = rows.width - len(broad)
        numbers.append(Stated(sort, index, np.arange(first, rows.width), broad))

    seen, stated, relative = model.solution.prior.seen, as_stated(model), relative_std(model.robot)
    for body in bodies:
        rows.moved(seen[:, 10 * body : 10 * body + 10] * broad_load)
        add("load", body, broad_load)
        if phi[body, 0] > 0.0:
            rows.moved(broad_share * (seen[:, 10 * body : 10 * body + 10] @ phi[body])[:, None])
            add("scaled", body, np.array([broad_share]))
        if phi[body, 0] > 0.0 and relative[body] > 0.0:
            first = slice(10 * body + 1, 10 * body + 4)
            rows.moved(stated.seen[:, first] * (broad_share * stated.std[first] / relative[body]))
            add("centre", body, np.full(3, broad_share))
    driven = [a for a, joint in enumerate(model.robot.joints) if joint.actuation != "none"]
    places = gain_columns(model.equations)
    if not driven or not places or not model.known_scale:
        return numbers, rows.letting_go()
    logged, broad_gain = list[tuple[int, float]](), criteria.broad_gain
    for axis in driven:
        if model.robot.joints[axis].actuation == "torque":
            rows.torque_logged(axis, places[axis], broad_gain)
            logged.append((rows.width - 1, criteria.torque_doubt / broad_gain))
        else:
            unit = np.zeros((model.equations.size, 1))
            unit[places[axis]] = broad_gain * model.solution.prior.seen_mean[places[axis]]
            rows.moved(unit)
        add("gain", axis, np.array([broad_gain]))
    if _feet_scale_all(model):
        rows.moved(broad_gain * model.solution.prior.seen_mean[:, None])  # what was identified deviates by chance
        add("feet", -1, np.array([broad_gain]))
        logged += [(rows.width - 1, common / broad_gain)] if (common := model.robot.declared.ft_gain_common) else []
    doubted = _doubted(rows.letting_go(), logged)
    gains = np.concatenate([each.columns for each in numbers if each.sort == "gain"])
    return [*numbers, Stated("gains", -1, np.array([len(doubted.g)]), np.array([broad_gain]))], _alike(doubted, gains)


def undecided_between(model: RobotModel, numbers: Sequence[Number], memory: Array) -> Undecided:
    """Numbers of which the data leave it open which one is off, the one that is named first, as planning needs them.

    The model's rows count as many samples as they are worth, and its links are doubted as `as_stated` has it: what is
    left of a number beside all that the maker may be off in is what speaks for it. memory: as of `stated_numbers`.
    """
    rows, solution = _Rows(model, memory), model.solution
    for each in numbers:
        if each.moves is None:
            rows.torque_logged(each.logged, gain_columns(model.equations)[each.logged], 1.0)
        else:
            rows.moved(each.moves)
    B, S = rows.sums()
    weighed = replace(solution, weights=rows.weights, prior=as_stated(model), strength=1.0)
    kind = numbers[0].kinds(model.equations)[0]
    return Undecided(replace(model, solution=weighed), tuple(numbers), B, S, kind, noise=1.0, memory=1.0)


def _feet_scale_all(model: RobotModel) -> bool:
    """Whether contact sensors alone say how large all torques are: then with their gain all parameters grow."""
    robot = model.robot
    currents = all(joint.actuation in ("current", "none") for joint in robot.joints)
    return bool(robot.contacts) and robot.floating and currents and not robot.cuts and not robot.loads


def _broad(criteria: Contradicting) -> Array:
    """(10,) std of a broad belief in what may hang on a link."""
    mass, reach = criteria.mass_kg, criteria.reach_m
    return np.array([mass, *([mass * reach] * 3), *([mass * reach**2] * 6)])


def as_stated(model: RobotModel) -> Prior:
    """The model's prior with what a maker means by a doubted link: one that is heavier is so in all its moments, and
    where its centre lies elsewhere all of its inertia lies there.

    Ten independent doubts of the same sizes leave moments free that no link can have. Beside the mass, doubted by the
    share rho, what is in doubt is the centre by rho g and by rho the inertia about it, g the radius of gyration.
    """
    prior = model.solution.prior
    mean, std, seen = prior.mean.copy(), prior.std.copy(), prior.seen.copy()
    for body, phi in enumerate(model.robot.tree.phi):
        mass, first, second = 10 * body, slice(10 * body + 1, 10 * body + 4), slice(10 * body + 4, 10 * body + 10)
        if phi[0] <= 0.0 or std[mass] <= 0.0:
            continue
        centre, share = phi[1:4] / phi[0], np.where(std[mass + 1 : mass + 10] > 0.0, phi[1:] / phi[0], 0.0)
        shift = np.where(std[second, None] > 0.0, inertia_by_first_moment(centre), 0.0)
        seen[:, mass] += prior.seen[:, mass + 1 : mass + 10] @ share
        seen[:, first] += prior.seen[:, second] @ shift
        mean[first] -= share[:3] * mean[mass]
        mean[second] -= share[3:] * mean[mass] + shift @ mean[first]
        spread = (std[first] / std[mass]) ** 2  # g² + c²
        of_lengths = 1.0 - np.mean(centre @ centre / np.maximum(spread, 1e-300))  # g² of it
        least = model.criteria.nominal.centre**2
        std[first] *= np.sqrt(max(of_lengths, least))
        std[second] *= max(of_lengths, least) / model.criteria.nominal.second_moments
    return replace(prior, mean=mean, std=std, seen=seen)


def _doubted(data: LettingGo, doubts: Sequence[tuple[int, float]]) -> LettingGo:
    """doubts: columns, and the share of their broad belief that nobody would be surprised at."""
    if not doubts:
        return data
    return data.without(np.array([column for column, _ in doubts]), np.array([share for _, share in doubts]))


def gain_columns(equations: Equations) -> list[int]:
    """Index in x of every axis' motor gain; none where no effect of the model has one."""
    for k, effect in enumerate(equations.effects):
        if effect.name == "motor_gain":
            return [int(equations.effect_columns(axis)[k]) for axis in range(len(equations.robot.joints))]
    return []


def _alike(each: LettingGo, columns: IntArray) -> LettingGo:
    """With one more column: all of these together."""
    S = np.block([[each.S, each.S[:, columns].sum(axis=1)[:, None]], [np.zeros((1, len(each.g) + 1))]])
    S[-1, :-1], S[-1, -1] = S[:-1, -1], S[columns, -1].sum()
    return LettingGo(S, np.append(each.g, each.g[columns].sum()))


@final
class _Rows:
    """Collects columns u as their products with A, with each other and with what is left of y, in weighted rows."""

    def __init__(self, model: RobotModel, memory: Array) -> None:
        solution: Solution = model.solution
        self.equations, self.statistics = model.equations, solution.statistics
        self.weights = solution.weights / memory
        self.data = PriorLeastSquares(self.statistics.square_root(self.weights), as_stated(model), 1.0)
        self.G, g, _ = self.statistics.normal(self.weights)
        self.slope = g - self.G @ self.data.x
        self.A_u, self.own, self.left = list[Array](), list[Array](), list[float]()
        self.moves = list[Array | None]()

    @property
    def width(self) -> int:
        return len(self.left)

    def moved(self, p: Array) -> None:
        """u = A p, (P, k): what is changed moves parameters of the model."""
        for column in p.T:
            self._take(self.G @ column, float(column @ self.G @ column), float(column @ self.slope), column)

    def torque_logged(self, axis: int, place: int, share: float) -> None:
        """u: `share` of the torque that the model calls for on an axis whose torque is logged.

        The logged one holds the noise that the residual holds, which a free gain would shrink away.
        """
        A_u, own, left = np.zeros(self.equations.size), 0.0, 0.0
        for kind in (self.equations.layout.axis(axis), self.equations.layout.resting(axis)):
            w, columns = self.weights[kind], self.statistics.columns[kind]
            if w <= 0.0:
                continue
            k = int(np.flatnonzero(columns == place)[0])
            squares, slope, G = self.statistics.around(kind, self.data.x)
            A_u[columns] += w * (G[:, k] + slope)
            own += w * (G[k, k] + 2.0 * slope[k] + squares)
            left += w * (slope[k] + squares)
        self._take(share * A_u, share**2 * own, share * left, None)

    def _take(self, A_u: Array, own: float, left: float, move: Array | None) -> None:
        """The product of two columns is p^T A^T u where one of them moves parameters; logged torques of two axes share
        no row."""
        products = [
            float(move @ other) if move is not None else float(p @ A_u) if p is not None else 0.0
            for other, p in zip(self.A_u, self.moves, strict=True)
        ]
        self.own.append(np.array([*products, own]))
        self.A_u.append(A_u)
        self.moves.append(move)
        self.left.append(left)

    def sums(self) -> tuple[Array, Array]:
        """(P, K), (K, K) products of the columns with A, and with each other."""
        K = self.width
        B, Q = np.array(self.A_u).reshape(K, self.equations.size).T, np.zeros((K, K))
        for k, products in enumerate(self.own):
            Q[k, : k + 1] = Q[: k + 1, k] = products
        return B, Q

    def letting_go(self) -> LettingGo:
        B, Q = self.sums()
        S = Q - B.T @ self.data.divided(B)
        return LettingGo(0.5 * (S + S.T), np.array(self.left))


IntArray = NDArray[np.intp]


@final
@dataclass(frozen=True)
class Let:
    """evidence: twice the log ratio. change, std: (k,) of what was let go, in broad beliefs."""

    evidence: float
    change: Array
    std: Array


@final
@dataclass(frozen=True)
class LettingGo:
    """K columns u that changes of the maker's numbers add to the rows y, each as large as a broad belief has it.

    With the rows' marginal covariance C = N + A P A^T: S = u^T C^{-1} u (K, K), g = u^T C^{-1} (y - A mean) (K,).
    """

    S: Array
    g: Array

    def let(self, which: IntArray) -> Let:
        """which: (k,) columns that are let go together, and nothing else."""
        own, V = np.linalg.eigh(self.S[np.ix_(which, which)])
        told = own > 0.0  # the others are rounding: of logs that stand still nothing is left but that
        own, g = np.where(told, own, 0.0), np.where(told, V.T @ self.g[which], 0.0)
        evidence = float(np.sum(g**2 / (1.0 + own)) - np.sum(np.log1p(own)))
        return Let(evidence, V @ (g / (1.0 + own)), np.sqrt(V**2 @ (1.0 / (1.0 + own))))

    def without(self, which: IntArray, share: float | Array = 1.0) -> LettingGo:
        """The same where these columns are free already. share: of the broad belief that they get, at most (k,)."""
        scale = np.broadcast_to(share, len(which))
        S = self.S[:, which] * scale
        inner = np.eye(len(which)) + scale[:, None] * S[which]
        K = np.linalg.solve(inner, S.T)
        return LettingGo(self.S - S @ K, self.g - K.T @ (self.g[which] * scale))
