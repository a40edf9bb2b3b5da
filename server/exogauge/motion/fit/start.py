"""A first posture for single frames, far from any guess: damped least squares on the nominal body."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from exogauge.criteria.motion_fit import MotionFit
from exogauge.motion.fit.body import HumanBody
from exogauge.motion.fit.kinematics import places, pose, slopes
from exogauge.motion.fit.observed import Observed, continuous

Array = NDArray[np.float64]
TRIPLES = ("pelvis_yaw", "trunk_flexion", "head_flexion", "l_shoulder_flexion", "r_shoulder_flexion", "l_hip_flexion",
           "r_hip_flexion")  # fmt: skip


def postures(body: HumanBody, observed: Observed, scale: Array, criteria: MotionFit) -> Array:
    """(T, K) of every frame by itself. scale: (S,). Levenberg (1944), Marquardt (1963), each frame with its damping."""
    q = _lain(body, observed, scale)
    mean, weight = _leaning(body, observed, criteria)
    seen = np.isfinite(observed.position) & observed.known[:, None]
    target = np.where(seen, observed.position, 0.0)
    w = 1.0 / (criteria.start_noise**2 + observed.offset_sd**2)
    still = np.zeros_like(observed.points.nominal)

    def judged(q: Array) -> tuple[Array, Array, Array]:
        at = pose(body, q, scale)
        place = places(at, observed.points, scale, still)
        r = np.where(seen, target - place, 0.0)
        cost = np.einsum("tma,tma,m->t", r, r, w) + np.sum(weight * (q - mean) ** 2, axis=1)
        return cost, r, slopes(body, at, observed.points, place)

    cost, r, J = judged(q)
    damping = np.full(len(q), 1e-2)
    eye = np.eye(q.shape[1])
    rows = np.repeat(seen[..., 0] * w, 3, axis=1)
    for _ in range(criteria.start_steps):
        J_w = J * rows[..., None]
        A = np.swapaxes(J, 1, 2) @ J_w + weight[:, :, None] * eye
        g = np.einsum("tnk,tn->tk", J_w, r.reshape(len(q), -1)) + weight * (mean - q)
        size = np.einsum("tkk->tk", A)
        step = np.linalg.solve(A + (damping[:, None] * size)[..., None] * eye, g[..., None])[..., 0]
        tried = q + step
        cost_tried, r_tried, J_tried = judged(tried)
        better = cost_tried <= cost
        q[better], r[better], J[better], gain = tried[better], r_tried[better], J_tried[better], cost - cost_tried
        cost = np.where(better, cost_tried, cost)
        damping = np.clip(damping * np.where(better, 0.2, 5.0), 1e-9, 1e6)
        if better.all() and (gain <= 1e-6 * (1.0 + cost)).all():
            break
    return without_jumps(body, q)


def without_jumps(body: HumanBody, q: Array) -> Array:
    """The same postures (T, K), each angle near the frame before."""
    q = q.copy()
    for first in TRIPLES:
        k = body.index(first)
        q[:, k : k + 3] = continuous(q[:, k : k + 3])
    rest = [k for k, moves in enumerate(body.prismatic) if not moves]
    q[:, rest] = np.unwrap(q[:, rest], axis=0)
    turns = 2 * np.pi * np.round(q[0, rest] / (2 * np.pi))
    q[:, rest] -= turns
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


def _leaning(body: HumanBody, observed: Observed, criteria: MotionFit) -> tuple[Array, Array]:
    """Where a posture is sought: what is stated, else joints within their reach, knees and elbows bent."""
    mean, weight = observed.mean.copy(), observed.weight.copy()
    for k, name in enumerate(body.coordinates):
        if k < 6:
            continue
        hinge = name.endswith(("knee_flexion", "elbow_flexion"))
        free = weight[:, k] == 0.0
        mean[free, k] = criteria.bent if hinge else 0.0
        weight[free, k] = (criteria.bent_sd if hinge else criteria.start_sd) ** -2
    return mean, weight
