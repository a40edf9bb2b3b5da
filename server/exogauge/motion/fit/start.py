"""A first posture for single frames, far from any guess: damped least squares on the nominal body."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from exogauge.criteria.motion_fit import MotionFit
from exogauge.motion.fit.body import PELVIS, HumanBody
from exogauge.motion.fit.kinematics import beyond, normal, places, pose
from exogauge.motion.fit.observed import Observed, at_frames, continuous

Array = NDArray[np.float64]
LIMBS = (("l_shoulder", "l_elbow", "l_pronation", "l_wrist"), ("r_shoulder", "r_elbow", "r_pronation", "r_wrist"),
         ("l_hip", "l_knee", "l_ankle"), ("r_hip", "r_knee", "r_ankle"))  # fmt: skip
JOINTS = ("shoulder_flexion", "shoulder_abduction", "shoulder_rotation", "elbow_flexion", "pronation", "wrist_flexion",
          "wrist_deviation", "hip_flexion", "hip_abduction", "hip_rotation", "knee_flexion", "ankle_dorsiflexion",
          "ankle_inversion")  # fmt: skip
HINGES = ("knee_flexion", "elbow_flexion")
TURNS = ("pronation", "wrist_flexion", "wrist_deviation", "ankle_inversion")  # too far from the trunk to draw it aside
TRIPLES = ("pelvis_yaw", "trunk_flexion", "head_flexion", "l_shoulder_flexion", "r_shoulder_flexion", "l_hip_flexion",
           "r_hip_flexion")  # fmt: skip


def postures(body: HumanBody, observed: Observed, scale: Array, criteria: MotionFit) -> Array:
    """(T, K) of every frame by itself, of points at their nominal places. scale: (S,)."""
    return settled(body, observed, _lain(body, observed, scale), scale, np.zeros_like(observed.points.nominal),
                   criteria.start_noise**2 + observed.offset_sd**2, criteria)  # fmt: skip


def settled(
    body: HumanBody, observed: Observed, q: Array, scale: Array, offset: Array, variance: Array, criteria: MotionFit
) -> Array:  # fmt: skip
    """(T, K) of every frame by itself, from q (T, K). offset: (M, 3) [m]; variance: (M,) [m²] of a point's place.

    A limb that ends beyond any joint's reach, or whose points miss, is tried once more from where it leans.
    """
    leant = leaning(body, observed, criteria)
    q, cost, miss = _descended(body, observed, leant, q, scale, offset, variance, criteria)
    odd = (np.abs(q - leant.mean) > criteria.far_rad) | (beyond(body, q, criteria.reach_sd)[1] > 0.0)
    limbs = np.array([[name.startswith(limb) for name in body.coordinates] for limb in LIMBS])
    on = np.array([[own[joint] for joint in observed.points.joint] for own in limbs])
    bent = np.stack([odd[:, own].any(axis=1) | (miss[:, at].max(axis=1, initial=0.0) > 3.0)
                     for own, at in zip(limbs, on, strict=True)], axis=1)  # fmt: skip
    frame, limb = np.nonzero(bent)
    several = np.flatnonzero(bent.sum(axis=1) > 1)
    anew = np.concatenate([limbs[limb], bent[several] @ limbs])
    frame = np.concatenate([frame, several])
    if len(frame):
        some, there = at_frames(observed, frame), at_frames(leant, frame)
        other, then, _ = _descended(body, some, there, np.where(anew, there.mean, q[frame]), scale, offset, variance,
                                    criteria)  # fmt: skip
        for k, t in enumerate(frame):
            if then[k] < cost[t]:
                q[t], cost[t] = other[k], then[k]
    return without_jumps(body, q)


def _descended(
    body: HumanBody, observed: Observed, leant: Observed, q: Array, scale: Array, offset: Array, variance: Array,
    criteria: MotionFit,
) -> tuple[Array, Array, Array]:  # fmt: skip
    """Postures (T, K), what is left of each, (T,), and of their points, (T, M), in deviations. Levenberg (1944),
    Marquardt (1963), each frame with its damping."""
    seen = np.isfinite(observed.position[..., 0]) & observed.known
    w = seen / variance
    going, q, eye = np.arange(len(q)), q.copy(), np.eye(q.shape[1])  # frames that have not settled

    def judged(q: Array) -> tuple[Array, Array, Array]:
        at = pose(body, q, scale)
        place = places(at, observed.points, scale, offset)
        r = np.where(seen[going, :, None], observed.position[going] - place, 0.0)
        off, weight = leant.mean[going] - q, leant.weight[going]
        out, stiff = beyond(body, q, criteria.reach_sd)
        miss = np.sum(r**2, axis=2) * w[going]
        cost = miss.sum(axis=1) + np.sum(weight * off**2 + out**2 * criteria.reach_sd**2, axis=1)
        A, g = normal(body, at, observed.points, place, r, w[going])
        left[going] = np.sqrt(miss)
        return cost, A + (weight + stiff)[:, :, None] * eye, g + weight * off - out

    left = np.zeros(seen.shape)
    cost, A, g = judged(q)
    damping, final = np.full(len(q), 1e-2), cost.copy()
    for _ in range(criteria.start_steps):
        size = np.einsum("tkk->tk", A)
        step = np.linalg.solve(A + (damping[:, None] * size)[..., None] * eye, g[..., None])[..., 0]
        tried = q[going] + step
        cost_tried, A_tried, g_tried = judged(tried)
        better = cost_tried <= cost
        done = better & (cost - cost_tried <= criteria.start_settled * (1.0 + cost))
        q[going[better]], final[going[better]] = tried[better], cost_tried[better]
        cost[better], A[better], g[better] = cost_tried[better], A_tried[better], g_tried[better]
        damping = np.clip(damping * np.where(better, 0.2, 5.0), 1e-9, 1e6)
        going, cost, damping = going[~done], cost[~done], damping[~done]
        A, g = A[~done], g[~done]
        if not len(going):
            break
    return q, final, left


def without_jumps(body: HumanBody, q: Array) -> Array:
    """The same postures (T, K), each angle near the frame before."""
    q = q.copy()
    for first in TRIPLES:
        k = body.index(first)
        q[:, k : k + 3] = continuous(q[:, k : k + 3])
    rest = ~body.prismatic & np.isinf(body.reach[1])
    q[:, rest] = np.unwrap(q[:, rest], axis=0)
    q[:, rest] -= 2 * np.pi * np.round(np.median(q[:, rest], axis=0) / (2 * np.pi))
    return q


def _lain(body: HumanBody, observed: Observed, scale: Array) -> Array:
    """The pelvis as its own points and those of the thorax lie, all joints at zero."""
    q = observed.mean.copy()
    straight = places(pose(body, np.zeros((1, q.shape[1])), scale), observed.points, scale,
                      np.zeros_like(observed.points.nominal))[0]  # fmt: skip
    on = {part: np.array([each == part for each in observed.segment]) & observed.known for part in ("pelvis", "thorax")}
    yaw = body.index("pelvis_yaw")
    stated = observed.weight[:, yaw] > 0.0
    for t, place in enumerate(observed.position):
        seen = np.isfinite(place[:, 0])
        for chosen in (on["pelvis"] & seen, (on["pelvis"] | on["thorax"]) & seen):
            if chosen.sum() >= 3:
                break
        if not chosen.any():
            continue
        a, b = straight[chosen].mean(axis=0), place[chosen].mean(axis=0)
        if not stated[t] and chosen.sum() >= 3:
            turn = Rotation.align_vectors(place[chosen] - b, straight[chosen] - a)[0]
            q[t, yaw : yaw + 3] = turn.as_euler("ZXY")
        turn = Rotation.from_euler("ZXY", q[t, yaw : yaw + 3])
        q[t, :3] = b - turn.apply(a)
    return q


def leaning(body: HumanBody, observed: Observed, criteria: MotionFit, joints: tuple[str, ...] = ("",)) -> Observed:
    """Where a posture is sought: what is stated, else joints about zero, knees and elbows bent; of coordinates whose
    names end so, the pelvis aside."""
    mean, weight = observed.mean.copy(), observed.weight.copy()
    for k, name in enumerate(body.coordinates):
        if name in PELVIS or not name.endswith(joints):
            continue
        free = weight[:, k] == 0.0
        mean[free, k] = criteria.bent if name.endswith(HINGES) else 0.0
        weight[free, k] = (criteria.bent_sd if name.endswith(HINGES) else criteria.start_sd) ** -2
    return replace(observed, mean=mean, weight=weight)
