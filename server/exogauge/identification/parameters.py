"""Every identified number under its name, with its doubt, and whether the data or the prior decided it."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from exogauge.estimation.prior import Prior
from exogauge.identification.equations import Equations
from exogauge.identification.result import Parameter
from exogauge.identification.solution import Solution
from exogauge.identification.type_b import ROBOT
from exogauge.robots.description import Robot
from exogauge.robots.parameters import parameter_names, parameter_units, unit_at

Array = NDArray[np.float64]


def describe(
    equations: Equations,
    solution: Solution,
    standard: Array,
    covariance: Array,
    but_for_scale: Array,
    hardly_sliding: Collection[str],
) -> tuple[Parameter, ...]:
    """Standard, joint and base parameters. standard: (S,) [φ; ξ]; covariance: (S, S) about the truth.

    but_for_scale: (S, S) the same where the common factor is known, which decides what is identifiable. Static friction
    has its std from what sticks, and is not identifiable where it is only a lower bound. hardly_sliding: joints whose
    friction is that of a gear that gives way, so that nothing of theirs is identifiable.
    """
    robot, effects, prior, sticking = equations.robot, equations.effects, solution.prior, solution.sticking
    names = list(parameter_names(robot.tree))
    units = list(parameter_units(robot.tree))
    for joint in robot.joints:
        names += [f"{effect.coefficient.name}[{joint.name}]" for effect in effects]
        units += [coefficient_unit(effect.coefficient.unit, joint.name, robot) for effect in effects]
    for column in equations.added:
        names.append(f"{column.name}[{column.place}]")
        units.append(column.coefficient.unit)
    known_otherwise = np.array([sticking.std.get(name, np.inf) for name in names])
    std, asked = (np.minimum(np.sqrt(np.maximum(np.diag(each), 0.0)), known_otherwise)
                  for each in (covariance, but_for_scale))  # fmt: skip
    decided = equations.criteria.identifying.decided
    doubtful = {f"tau_s[{joint}]" for joint in sticking.lower_bounds}
    open_joints = {*hardly_sliding, *(joint.name for joint in robot.joints if joint.actuation == "none")}
    open_ends = {f"[{joint}]" for joint in open_joints}
    single = [
        Parameter(
            name=name,
            value=float(standard[i]),
            std=float(std[i]),
            unit=units[i],
            prior=float(prior.mean[i]),
            prior_std=float(prior.std[i]),
            identifiable=bool(
                prior.std[i] > 0.0
                and asked[i] <= decided * prior.std[i]
                and name not in doubtful
                and not (i >= robot.tree.phi.size and any(name.endswith(end) for end in open_ends))
            ),
        )
        for i, name in enumerate(names)
    ]
    return (*single, *_base_parameters(equations, prior, standard, (covariance, but_for_scale), names, units))


def with_parts(parameters: Sequence[Parameter], declared: Mapping[str, Array]) -> tuple[Parameter, ...]:
    """With what their doubt is made of: what is declared, and what the logs leave open beside it. declared: source ->
    (S,) variance of each of the first S of them, the standard ones; none of what is known otherwise (static friction).
    """

    def parts(place: int, std: float) -> dict[str, float]:
        of_this = {source: float(variance[place]) for source, variance in declared.items()}
        left = {ROBOT: std**2 - sum(of_this.values()), **of_this}
        known_otherwise = left[ROBOT] < -1e-9 * std**2
        return {} if known_otherwise else {source: float(np.sqrt(each)) for source, each in left.items() if each > 0.0}

    standard = len(next(iter(declared.values()), np.zeros(0)))
    found = [replace(each, parts=parts(place, each.std)) for place, each in enumerate(parameters[:standard])]
    return (*found, *parameters[standard:])


def given_the_scale(covariance: Array, gains: NDArray[np.intp], standard: Array) -> Array:
    """(S, S) what is left of the covariance once the common factor of all torque constants is known.

    gains: places of these constants in standard, (S,).
    """
    if not len(gains):
        return covariance
    mean = np.zeros(len(standard))
    mean[gains] = 1.0 / (len(gains) * standard[gains])
    along = covariance @ mean
    return np.asarray(covariance - np.outer(along, along) / max(float(mean @ along), 1e-300))


def coefficient_unit(unit: str, joint: str, robot: Robot) -> str:
    """k_T of a joint whose torque is logged is a pure number; a joint that slides has forces and lengths."""
    (actuation,) = (each.actuation for each in robot.joints if each.name == joint)
    if unit == "N·m/A" and actuation != "current":
        return "1"
    return unit_at(robot.tree, joint, unit)


def _base_parameters(
    equations: Equations,
    prior: Prior,
    standard: Array,
    covariances: tuple[Array, Array],
    names: list[str],
    units: list[str],
) -> list[Parameter]:
    """The combinations of inertial parameters that the equations see, named after their leading one. covariances: as
    they are, and but for the scale."""
    base, size = equations.base, equations.robot.tree.phi.size
    result, decided = list[Parameter](), equations.criteria.identifying.decided
    for row, leading in zip(base.regroup, base.columns, strict=True):
        used = np.flatnonzero(row)
        std, asked = (float(np.sqrt(max(float(row[used] @ each[np.ix_(used, used)] @ row[used]), 0.0)))
                      for each in covariances)  # fmt: skip
        prior_std = float(np.sqrt(np.sum((row[used] * prior.std[used]) ** 2)))
        result.append(
            Parameter(
                name=f"base[{names[leading]}]",
                value=float(row @ standard[:size]),
                std=std,
                unit=units[leading],
                prior=float(row @ prior.mean[:size]),
                prior_std=prior_std,
                identifiable=asked <= decided * prior_std,
                combination={names[j]: float(row[j]) for j in used},
            )
        )
    return result
