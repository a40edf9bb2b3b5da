"""How far fitted bands can be believed: coloured residuals, the robot's parameters, and what is not modelled."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.identifying import DECLARED
from exogauge.identification.type_b import ROBOT
from exogauge.identification.uncertainty import block_length
from exogauge.support.band_inputs import Moves, scores_of_inputs
from exogauge.support.band_model import Fitted, Setting, columns
from exogauge.support.band_rows import WearLogs
from exogauge.support.coloured import by_autocovariance, by_what_is_shared, larger

Array = NDArray[np.float64]
IntArray = NDArray[np.intp]

SCATTER, NULL_TEST, TORQUE_ZERO = "scatter", "null_test", "torque_zero"


def covariance(setting: Setting, fitted: Fitted, robot: Array, null: Setting | None = None) -> Array:
    """(P, P) of theta about the truth: the sum of all `contributions`."""
    found = contributions(setting, fitted, {ROBOT: robot}, null)
    return np.asarray(sum(found.values(), np.zeros_like(fitted.hessian)))


def contributions(
    setting: Setting,
    fitted: Fitted,
    robot: Mapping[str, Array],
    null: Setting | None = None,
    moves: Moves | None = None,
) -> dict[str, Array]:
    """Name of a source -> (P, P) of theta about the truth: H⁻¹ M H⁻¹, with H the curvature, M of what follows; where
    nothing pulls anywhere `scatter` alone, which is none. moves: as of `scores_of_inputs`.

    scatter: S, what errors of this kind make of the score (they last), and what is believed of the springs;
    robot: G C Gᵀ, C: covariance of the robot's parameters and of what all logs share (`RobotModel.doubt`), or its parts
    by name; G: how the score moves with them;
    kt_drift, ft_zero: what each log's motors and sensors alone do to it;
    null_test: n nᵀ, n: the score that the approach finds on logs without the device, `null`, where it ought to be zero,
    beside what is declared and fitted: what the model lacks there it lacks with the device too (A takes off what
    repeats);
    via_points, donning: how the device sits (`band_inputs`);
    torque_zero: what is left of each log's and joint's own offset. What the others do to the score goes through the
    same slopes, w A⊥ (`Nuisances`): of what is fitted beside the bands what the fit has not followed is left.
    """
    fitted = replace(fitted, A=setting.nuisances.without(fitted.A))
    weighted, S = fitted.A * setting.weight[:, :, None], len(setting.belief.mean)
    found = {SCATTER: score_covariance(setting.logs, fitted.e, weighted)}
    found[SCATTER][:S, :S] += setting.belief.precision
    G, of_each_log = _moved(setting.logs, weighted)
    if G is not None:
        found |= {name: G @ C @ G.T for name, C in robot.items()}
    for name, own in of_each_log.items():
        found[name] = found.get(name, np.zeros_like(own)) + own
    if setting.logs.zero_std.any():
        found[TORQUE_ZERO] = setting.nuisances.score_of_offsets(weighted)
    if null is not None:
        n = null_score(null, columns(null.logs, null.wires, fitted.wear))
        found[NULL_TEST] = np.outer(n, n)
    found |= {name: g @ g.T for name, g in scores_of_inputs(setting, fitted, moves).items()}
    inverse = inverted(fitted.hessian)
    live = {name: meat for name, meat in found.items() if meat.any()} or {SCATTER: found[SCATTER]}
    return {name: np.asarray(inverse @ meat @ inverse) for name, meat in live.items()}


def inverted(hessian: Array) -> Array:
    """(P, P) of a curvature in values of any size; nothing in directions of which it holds nothing."""
    size = 1.0 / np.sqrt(np.maximum(np.diag(hessian), 1e-300))
    inverse = np.linalg.pinv(hessian * np.outer(size, size), rcond=1e-12, hermitian=True)
    return np.asarray(inverse * np.outer(size, size))


def score_covariance(logs: WearLogs, e: Array, weighted: Array) -> Array:
    """(P, P) of Σ Aᵀ w e: no less in any direction than either of two estimates. weighted: (N, D, P) w A, A without
    offsets.

    Sums over blocks see that errors are larger in places; but few blocks stretch the bands, and those are the ones that
    the fit bends to, so that their spread is too small: by a fifth in trials with one or two logs, where 95 % intervals
    held the truth in 85 draws of 100. The autocovariance of the residuals takes errors to be alike throughout a log,
    and has no such bias where they are.
    """
    number, each = blocks(logs, e), np.einsum("ndp,nd->np", weighted, e)
    scores = np.zeros((int(number.max(initial=-1)) + 1, each.shape[1]))
    np.add.at(scores, number, each)
    by_blocks = scores.T @ scores * (len(scores) / max(len(scores) - 1.0, 1.0))
    alone = by_autocovariance(logs.spans, logs.used, e, weighted)
    rates = [_rate(logs, own) for own in logs.spans]
    if max(rates) < 1.01 * min(rates):
        alone = larger(alone, by_autocovariance(logs.spans, logs.used, e, weighted, pooled=True))
    shared = by_what_is_shared(_beside_each_other(logs), logs.used, e, weighted)
    return larger(larger(by_blocks, alone), alone + shared)


def blocks(logs: WearLogs, e: Array) -> IntArray:
    """(N,) consecutive samples of a log that are long against the residual's memory share a number; so do those of logs
    from which the same moments of another log were taken off: that one's errors are in all of them."""
    numbers, start = np.zeros(len(logs.log), dtype=np.intp), 0
    for group in logs.partners:
        longest, begins = 0.0, [_begins(logs, k) for k in group]
        for k in group:
            own = logs.spans[k]
            used, rate = logs.used[own], _rate(logs, own)
            left = np.where(used, e[own], 0.0)[:, used.any(axis=0)]
            length = block_length(left, rate)[0] if left.shape[1] else len(left)
            longest = max(longest, length / rate)
        for k in group:
            own = logs.spans[k]
            since = logs.time[own] + logs.logs[k].ahead - min(begins)
            numbers[own] = start + np.floor(since / max(longest, 1e-9) + 1e-6).astype(np.intp)
        start = int(max(numbers[logs.spans[k]].max(initial=start - 1) for k in group)) + 1
    return np.asarray(np.unique(numbers, return_inverse=True)[1], dtype=np.intp)


def _beside_each_other(logs: WearLogs) -> list[list[tuple[slice, int]]]:
    """As `by_what_is_shared` asks: of logs that were kept at one rate."""
    found = list[list[tuple[slice, int]]]()
    for group in logs.partners:
        rates, begins = [_rate(logs, logs.spans[k]) for k in group], [_begins(logs, k) for k in group]
        if len(group) > 1 and max(rates) < 1.01 * min(rates):
            at = [round((begin - min(begins)) * rates[0]) for begin in begins]
            found.append([(logs.spans[k], each) for k, each in zip(group, at, strict=True)])
    return found


def _begins(logs: WearLogs, k: int) -> float:
    """[s] in its partner, where the first kept sample of a log is."""
    return float(logs.time[logs.spans[k]][0]) + logs.logs[k].ahead


def _rate(logs: WearLogs, own: slice) -> float:
    """[Hz] of the kept samples."""
    time = logs.time[own]
    return (len(time) - 1) / max(float(time[-1] - time[0]), 1e-9)


def _moved(logs: WearLogs, weighted: Array) -> tuple[Array | None, dict[str, Array]]:
    """(P, X) change of the score with the robot's parameters, None where a log does not know it; and declared
    uncertainty -> (P, P) of the score, from what motors and sensors do in each log. Through a session motors warm and
    zeros drift: a share of their variance is alike in all of these logs, or all where the session is known."""
    total, known = np.zeros((weighted.shape[2], 0)), True
    of_each_log: dict[str, Array] = {}
    together, session = dict[str, Array](), dict[str, Array]()
    for log, span in zip(logs.logs, logs.spans, strict=True):
        if log.slope is None and not log.inputs:
            known = False
            continue
        g = log.at_slopes(weighted[span])
        for name, own in log.own.items():
            moved, alike = _through(g, own), 0.0 if name in log.anew else DECLARED.alike
            of_each_log[name] = of_each_log.get(name, 0.0) + (1.0 - alike) * moved @ moved.T
            together[name] = together.get(name, 0.0) + np.sqrt(alike) * moved
        for name, inputs in log.session.items():
            session[name] = session.get(name, 0.0) + _through(g, inputs)
        if log.slope is None:
            known = False
        else:
            total = _through(g, log.slope) + (total if total.size else 0.0)
    for name, moved in together.items():
        of_each_log[name] = of_each_log[name] + moved @ moved.T
    for name, moved in session.items():
        of_each_log[name] = of_each_log.get(name, 0.0) + moved @ moved.T
    return total if known else None, of_each_log


def _through(g: NDArray[np.float32], slope: NDArray[np.float32]) -> Array:
    """(P, X) change of the score with X inputs. g: (m D, P) weighted slopes of one log's torque with the bands, slope:
    (m, D, X) with the inputs."""
    return np.asarray((g.T @ slope.reshape(len(g), -1)).astype(np.float64))


def null_score(null: Setting, A: Array) -> Array:
    """(P,) Σ A⊥ᵀ w τ on the logs without the wear, each counted as often as it stands for one with it. A: (N, D, P)
    there."""
    weight = null.logs.share[:, None] * null.weight
    return np.asarray(np.einsum("ndp,nd,nd->p", A, weight, null.nuisances.without(null.logs.torque)))
