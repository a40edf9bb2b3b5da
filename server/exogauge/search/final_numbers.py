"""Numbers as the model with all that was named has them: what was named later moves those of what was before. So
does what the same fit decides, such as a joint's k_T: torques are told on its scale, and so is the curve.

What the doubt of a named effect's shape makes of all that is fitted beside it, such as its joint's friction: an
identification takes shapes as given. Where a shape may as well be another one by its own deviation, the parameters
beside it move along: with A their columns, c the change of the effect's torque with its shapes, W the weights and H
the normal matrix with the prior, dx/dshape = -H⁻¹ Aᵀ W c, and the covariance of x gains (dx/dshape) C (dx/dshape)ᵀ,
C that of the shapes with all else free.

What is left and has no name makes all that is fitted beside it doubtful, too: what is missing there is fitted by the
parameters as far as they can, and only the rest of it is seen. Of what they took up nothing is known but that it is of
the rest's kind. So it counts as large as the rest, g² N of N rows, and as likely along each of the p directions that
the row's own parameters span: with Q their orthonormal basis the covariance of x gains
H⁻¹ Aᵀ W Q (g² N / p) Qᵀ W A H⁻¹.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from exogauge.findings.result import Excess, Finding
from exogauge.identification.model import AddedEffect, RobotModel
from exogauge.identification.result import Identification
from exogauge.identification.settings import Recording
from exogauge.identification.type_b import ROBOT, UNEXPLAINED
from exogauge.robots.rows import RowType
from exogauge.search.doubt import inverse_of_rest, shape_slopes
from exogauge.search.locate import all_channels, pooled
from exogauge.search.score import residual_memory
from exogauge.search.site_rows import SiteRows, collect_rows

Array = NDArray[np.float64]


def with_doubt_of_shapes(
    found: Identification, added: Sequence[AddedEffect], recordings: Sequence[Recording]
) -> Identification:
    """added: the named effects, all in the model of `found`."""
    free = [each for each in added if any(not one.choice for one in each.effect.shapes)]
    if not free:
        return found
    model, more = found.model, np.zeros_like(found.model.covariance)
    fitted = [each for each in recordings if not each.held_out]
    rows = collect_rows(model, fitted, [each.site for each in free])
    for each in free:
        more += _of_shapes(model, each, rows[each.site])
    return _doubted(found, more)


def with_doubt_of_what_is_left(found: Identification, left: Sequence[Excess]) -> Identification:
    """left: channels that stand above their noise for a reason that has no name. How far they do where they were fitted
    is what counts: there parameters took it up."""
    model = found.model
    kinds = {channel: kind for kind, channel in all_channels(model.equations).items()}
    more = np.zeros_like(model.covariance)
    for each in left:
        fits = [fit for fit in found.validation if not fit.held_out and fit.channel == each.channel]
        rmse, floor = pooled(fits)
        if rmse > floor:
            more += _of_what_is_left(model, kinds[each.channel], rmse**2 - floor**2)
    return _doubted(found, more, UNEXPLAINED) if more.any() else found


def _of_what_is_left(model: RobotModel, kind: int, square: float) -> Array:
    """(P, P) that a row's unexplained mean square adds to the covariance."""
    statistics, equations, weight = model.solution.statistics, model.equations, model.solution.weights[kind]
    row, columns, gram = equations.layout.rows[kind], equations.columns()[kind], statistics.gram(kind)
    of_axis = set(equations.effect_columns(row.place)) if row.type == RowType.AXIS else set(columns)
    own = np.flatnonzero([column in of_axis for column in columns])
    spanned = gram[np.ix_(own, own)]
    B = np.zeros((equations.size, len(own)))
    B[columns] = weight * gram[:, own]
    x = model.solution.unbounded.divided(B)
    directions = int(np.linalg.matrix_rank(spanned, hermitian=True))
    scale = square * float(statistics.count[kind]) / max(directions, 1)
    return np.asarray(scale * (x @ np.linalg.pinv(spanned, hermitian=True) @ x.T))


def _doubted(found: Identification, more: Array, source: str = "") -> Identification:
    """more: (P, P) added to the covariance of what is fitted. source: by which it is told among a parameter's parts."""
    model = found.model
    lift = model.solution.prior.lift_covariance
    before, after = np.diag(lift(model.covariance)), np.diag(lift(model.covariance + more))
    gained = np.maximum(after - before, 0.0)
    parameters = list(found.parameters)
    for i, grown in enumerate(gained):
        one = parameters[i]
        std = float(np.sqrt(one.std**2 + grown))
        decided = one.identifiable and std <= model.criteria.identifying.decided * one.prior_std
        parts = {**(one.parts or {ROBOT: one.std}), source: float(np.sqrt(grown))} if source else one.parts
        parts = {} if one.combination else parts
        parameters[i] = replace(one, std=std, identifiable=decided, parts=parts)
    return replace(
        found,
        parameters=tuple(parameters),
        unidentifiable=tuple(one.name for one in parameters if not one.identifiable),
        model=replace(model, covariance=model.covariance + more),
    )


def _of_shapes(model: RobotModel, added: AddedEffect, rows: Sequence[SiteRows]) -> Array:
    """(P, P) that one effect's shapes add to the covariance."""
    weights, own = model.solution.weights, model.equations.columns()
    width = sum(not one.choice for one in added.effect.shapes)
    B, S = np.zeros((model.equations.size, width)), np.zeros((width, width))
    square, memories, count = 0.0, list[float](), 0
    for each in rows:
        slopes = shape_slopes(added.effect, added.shape, coefficients(model, added), each)
        for kind, part in each.rows.items():
            if weights[kind] > 0.0 and kind in slopes[0]:
                c = np.hstack([one[kind] for one in slopes])
                B[own[kind]] += weights[kind] * (part.A.T @ c)
                S += weights[kind] * (c.T @ c)
                square, count = square + weights[kind] * float(part.e @ part.e), count + len(part.e)
                memories.append(residual_memory(part.e))
    if not count:
        return np.zeros((len(B), len(B)))
    x = model.solution.unbounded.divided(B)
    scale = float(np.median(memories)) * square / count
    return np.asarray(scale * x @ inverse_of_rest(S, B.T @ x) @ x.T)


def coefficients(model: RobotModel, added: AddedEffect) -> Array:
    """(C,) of one effect of the model, in its own units."""
    return np.asarray(model.identified.added[place_of(model, added)])


def place_of(model: RobotModel, added: AddedEffect) -> slice:
    """Of its coefficients, from the end of all that is fitted."""
    effects = model.extension.effects if model.extension else ()
    widths = [len(each.effect.coefficients) for each in effects]
    which = effects.index(added)
    after = sum(widths[which + 1 :])
    return slice(-after - widths[which], -after or None)


def with_final_numbers(finding: Finding, added: AddedEffect, model: RobotModel) -> Finding:
    """added: which effect of `model` the finding is about. Shapes stay. A standard deviation is no less than that of
    the whole fit, in which a torque is no better known than the scale of all torques. The curve is what the effect
    does with these coefficients; where they moved apart, with the factor that comes nearest."""
    quantities, numbers = added.effect.coefficients, dict(finding.parameters)
    scale = np.array([added.site.in_si(model, quantity.unit, added.shape)[0] for quantity in quantities])
    now, place = coefficients(model, added) * scale, place_of(model, added)
    std = np.sqrt(np.maximum(np.diag(model.covariance)[place], 0.0)) * np.abs(scale)
    was = np.array([numbers[quantity.name].value for quantity in quantities])
    for quantity, value, least in zip(quantities, now, std, strict=True):
        known = numbers[quantity.name]
        numbers[quantity.name] = replace(known, value=float(value), std=float(max(known.std, least)))
    drawn = replace(finding.evidence, model=finding.evidence.model * _factor(was, now))
    return replace(finding, parameters=numbers, evidence=drawn)


def _factor(was: Array, now: Array) -> float:
    square = float(was @ was)
    return float(was @ now) / square if square > 0.0 else 1.0
