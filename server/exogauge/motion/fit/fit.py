"""The recipe: what is observed, first postures, what all frames share, then every frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.motion_fit import USUAL, MotionFit
from exogauge.errors import BadMotion, Fault
from exogauge.logs.findings import runs
from exogauge.motion.fit.body import SCALES, human_body
from exogauge.motion.fit.kinematics import Points, places, pose
from exogauge.motion.fit.observed import Observed, at_frames, observe, standing, untracked
from exogauge.motion.fit.result import HumanFit
from exogauge.motion.fit.shared import Shared, shared_fit
from exogauge.motion.fit.start import JOINTS, TURNS, leaning, postures, settled, without_jumps
from exogauge.motion.fit.static_trial import refuse_no_static
from exogauge.motion.fit.track import track
from exogauge.motion.human import DOUBTS, HumanMotion
from exogauge.motion.sides import refuse_exchanged

Array = NDArray[np.float64]
ENDS = {"l_hand": (0.0, 0.0, -0.189), "r_hand": (0.0, 0.0, -0.189), "l_foot": (0.21, 0.0, -0.06),
        "r_foot": (0.21, 0.0, -0.06)}  # m, at scales 1: .108 and .152 of the stature (Winter 2009)  # fmt: skip


def fit_human(motion: HumanMotion, static: HumanMotion | None = None, criteria: MotionFit = USUAL) -> HumanFit:
    """The body that fits the motion. Raises BadMotion where none can be known.

    static: the same person standing straight with the same markers; its trunk is the zero of the trunk's angles.
    """
    if len(motion.time) > criteria.most_frames:
        detail, advice = f"no body is fitted to more than {criteria.most_frames} frames", "Cut the motion"
        raise BadMotion(Fault(detail, "too_long", advice, motion.name, value=str(len(motion.time))))
    refuse_exchanged(motion)
    if static is not None:
        refuse_no_static(motion, static, criteria)
    fit, off = _fitted(motion, static, criteria)
    told = {key: motion.told[key] for key in DOUBTS if key in motion.told}
    fit = replace(fit, told=told | dict(fit.told))
    if motion.markers is None:
        return fit
    segments, slips = [motion.markers.segment[label] for label in fit.labels], dict[str, str]()
    for _ in range(criteria.slips):
        slipped = _slipped(off, segments, criteria)
        if not slipped.any():
            break
        for m in np.flatnonzero(slipped.any(axis=0)):
            when = motion.time[slipped[:, m]]
            slips.setdefault(fit.labels[m], f"{fit.labels[m]} at {when[0]:.2f} s, by {100 * off[:, m].max():.0f} cm"
                             + (f", and in {len(when) - 1} frames more" if len(when) > 1 else ""))  # fmt: skip
        motion = _unseen(motion, fit.labels, slipped)
        fit, off = _fitted(motion, static, criteria)
    if fit.rms > criteria.no_body_rms:
        frame, far = np.unravel_index(int(off.argmax()), off.shape)
        detail = (f"no body fits these markers: {100 * fit.rms:.1f} cm rms are left, "
                  f"{100 * off[frame, far]:.0f} cm of this one at {motion.time[frame]:.2f} s")  # fmt: skip
        advice = "See what was there, and to its name; to names, unit and vertical axis of all; give a static trial"
        raise BadMotion(Fault(detail, "no_body", advice, motion.name, column=fit.labels[far]))
    said = "; ".join([*([told["slips"]] if "slips" in told else []), *slips.values()])
    return replace(fit, told=told | dict(fit.told) | ({"slips": said} if said else {}))


def _slipped(off: Array, segment: Sequence[str], criteria: MotionFit) -> NDArray[np.bool_]:
    """(T, M) points that are far from where the body has them, each alone of its segment: else it is the body's fault.
    None of a point that is so for more than a moment."""
    alone = np.zeros(off.shape, dtype=bool)
    for part in set(segment):
        own = np.flatnonzero([each == part for each in segment])
        if len(own) >= criteria.fewest:
            ranked = np.sort(off[:, own], axis=1)
            alone[:, own] = off[:, own] > np.maximum(criteria.slip_m, 2.0 * ranked[:, -2:-1])
    return np.asarray(alone & (alone.mean(axis=0) <= criteria.moment))


def _unseen(motion: HumanMotion, labels: tuple[str, ...], where: NDArray[np.bool_]) -> HumanMotion:
    """The motion with gaps at (T, M) of labelled markers."""
    assert motion.markers is not None
    position = motion.markers.position.copy()
    for m in np.flatnonzero(where.any(axis=0)):
        position[where[:, m], motion.markers.labels.index(labels[m])] = np.nan
    return replace(motion, markers=replace(motion.markers, position=position))


def _fitted(motion: HumanMotion, static: HumanMotion | None, criteria: MotionFit) -> tuple[HumanFit, Array]:
    """And (T, M) [m] by how much each point misses; 0 where it is not seen."""
    body = human_body()
    observed = leaning(body, observe(motion, body, criteria), criteria, TURNS)
    chosen = _spread(observed, criteria.frames, criteria.fewest)
    few = at_frames(observed, chosen)
    if static is not None:
        upright = leaning(body, standing(observe(static, body, criteria), body, criteria), criteria, TURNS)
        few = _joined(few, at_frames(upright, _spread(upright, criteria.static_frames, criteria.fewest)))
    ones, nowhere = np.ones(len(SCALES)), np.zeros((len(few.labels), 3))
    begun = postures(body, few, ones, criteria)
    leant = leaning(body, few, criteria, JOINTS)  # or a limb turns over while sizes are wrong
    first = shared_fit(body, leant, begun, ones, nowhere, criteria.first_to_go, criteria)
    variance = np.full(len(few.labels), criteria.start_noise**2)
    again = settled(body, few, first.q, first.scale, first.offset, variance, criteria)
    shared = shared_fit(body, few, again, first.scale, first.offset, criteria.to_go, criteria)
    kept = [few.labels.index(label) for label in observed.labels]
    offset = shared.offset[kept]
    F = len(chosen)
    knots = without_jumps(body, shared.q[:F])
    T = len(motion.time)
    q, sd = (np.stack([np.interp(np.arange(T), chosen, column) for column in each.T], axis=1)
             for each in (knots, shared.q_sd[:F]))  # fmt: skip
    q, moving = track(body, observed, q, shared.scale, offset, shared.noise, motion.rate, criteria)
    at = pose(body, q, shared.scale)
    miss = observed.position - places(at, observed.points, shared.scale, offset)
    off = np.linalg.norm(miss, axis=2)
    residual = np.sqrt(np.nanmean(off**2, axis=0))
    ends = Points(
        np.array([body.part[part] for part in ENDS], dtype=np.intp), np.array(list(ENDS.values())),  # type: ignore[index]
        np.array([[SCALES.index(part[2:])] * 3 for part in ENDS]),
    )  # fmt: skip
    far = places(at, ends, shared.scale, np.zeros((len(ENDS), 3)))
    deviation = np.sqrt(np.diag(shared.covariance)[: len(SCALES)])
    fit = HumanFit(
        motion.name, body, motion.time, q, sd, _named(shared.scale), _named(deviation),
        {part: at.rotation[:, k] for part, k in body.part.items()},
        {part: at.position[:, k] for part, k in body.part.items()},
        {part: far[:, n] for n, part in enumerate(ENDS)},  # type: ignore[misc]
        observed.labels, offset, residual, shared.noise, observed.lost(),
        _told(observed, shared, moving, offset, residual, motion.rate, criteria),
    )  # fmt: skip
    return fit, np.nan_to_num(off)


def _named(values: Array) -> dict[str, float]:
    return {name: float(value) for name, value in zip(SCALES, values, strict=True)}


def _spread(observed: Observed, count: int, fewest: int) -> NDArray[np.intp]:
    """Frames over all in which pelvis and thorax are seen, of each stretch the one in which most points are."""
    usable = np.flatnonzero(observed.fixed(fewest))
    seen = np.isfinite(observed.position[..., 0]).sum(axis=1)
    parts = np.array_split(usable, min(count, len(usable)))
    return np.array([part[int(seen[part].argmax())] for part in parts], dtype=np.intp)


def _joined(first: Observed, then: Observed) -> Observed:
    """Frames of both, over the points of either."""
    more = [m for m, label in enumerate(then.labels) if label not in first.labels]
    labels = first.labels + tuple(then.labels[m] for m in more)
    position = np.full((len(first.position) + len(then.position), len(labels), 3), np.nan)
    position[: len(first.position), : len(first.labels)] = first.position
    for m, label in enumerate(then.labels):
        position[len(first.position) :, labels.index(label)] = then.position[:, m]
    one, other = first.points, then.points
    points = Points(*(np.concatenate([a, b[more]]) for a, b in (
        (one.joint, other.joint), (one.nominal, other.nominal), (one.stretch, other.stretch))))  # fmt: skip
    return Observed(
        labels, first.segment + tuple(then.segment[m] for m in more), points, position,
        np.concatenate([first.offset_sd, then.offset_sd[more]]), np.concatenate([first.known, then.known[more]]),
        np.concatenate([first.mean, then.mean]), np.concatenate([first.weight, then.weight]),
    )  # fmt: skip


def _told(
    observed: Observed,
    shared: Shared,
    moving: NDArray[np.bool_],
    offset: Array,
    residual: Array,
    rate: float,
    criteria: MotionFit,
) -> dict[str, str]:
    told = {}
    starts, lengths = runs(~observed.fixed(criteria.fewest))
    long = lengths > criteria.guessed_s * rate
    if long.any():
        first, last = starts[long][0], starts[long][0] + lengths[long][0] - 1
        more = f", and {long.sum() - 1} times more" if long.sum() > 1 else ""
        said = f"fewer than {criteria.fewest} markers of pelvis or thorax are seen"
        told["guessed"] = f"{said} {first / rate:.2f} to {last / rate:.2f} s{more}: postures there are guessed"
    bound = [f"{name} {value:.2f}" for name, value in _named(shared.scale).items()
             if name != "lumbar_depth" and not criteria.least_scale < value < criteria.largest_scale]  # fmt: skip
    if bound:
        told["scale_at_bound"] = f"{', '.join(bound)}: unit, labels or a part without markers"
    bad = [m for m in np.argsort(-residual) if residual[m] > criteria.bad_rms]
    if bad:
        told["fits_badly"] = ", ".join(f"{observed.labels[m]} {100 * residual[m]:.1f} cm" for m in bad)
    far = np.linalg.norm(offset, axis=1)
    moved = [m for m in np.argsort(-far) if observed.known[m] and far[m] > 3.0 * observed.offset_sd[m]]
    if moved:
        told["elsewhere"] = ", ".join(
            f"{observed.labels[m]} {100 * far[m]:.0f} cm from where its name says" for m in moved
        )
        if pairs := _as_if_exchanged(observed, moved, shared.scale, offset):
            told["elsewhere"] += f"; as if exchanged: {', '.join(pairs)}"
    lost = untracked(observed)
    if lost:
        told["not_tracked"] = f"no points on {', '.join(lost)}: nothing says their joints' angles"
    few = [f"{part} {observed.segment.count(part)}" for part in dict.fromkeys(observed.segment)
           if observed.segment.count(part) < criteria.fewest]  # fmt: skip
    if few:
        told["few_points"] = ", ".join(few)
    still = [] if shared.settled else [f"scales and places still moved after {criteria.shared_steps} steps"]
    if moving.any():
        still.append(f"postures still moved after {criteria.track_steps} steps in {moving.sum()} frames, the first at "
                     f"{np.flatnonzero(moving)[0] / rate:.2f} s")  # fmt: skip
    if still:
        told["not_settled"] = "; ".join(still)
    return told


def _as_if_exchanged(observed: Observed, moved: Sequence[int], scale: Array, offset: Array) -> list[str]:
    """Pairs of markers on one part, each nearer to where the other's name says than to where its own does."""
    nominal = observed.points.nominal * scale[observed.points.stretch]
    far = np.linalg.norm((nominal + offset)[:, None] - nominal[None], axis=2)
    pairs = [(a, b) for k, a in enumerate(moved) for b in moved[k + 1 :] if observed.segment[a] == observed.segment[b]]
    return [f"{observed.labels[a]} and {observed.labels[b]}" for a, b in pairs
            if far[a, b] < far[a, a] and far[b, a] < far[b, b]]  # fmt: skip
