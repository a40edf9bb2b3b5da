"""Whether a wrench is written in other axes than those of the sensor's frame: turned, exchanged or reversed; or its
moments alone."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import permutations, product
from typing import final

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from exogauge.criteria.payload_static import USUAL, Standing
from exogauge.payload.dynamics import Rows
from exogauge.payload.statics import Holds, force_columns, moment_columns

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class OtherAxes:
    """Q: (3, 3) what is read of a force in the frame's axes: f_read = Q f; a rotation, or one with a mirror. angle:
    [rad] of the turn; None with a mirror. aligned: whether Q exchanges and reverses axes and does nothing else."""

    Q: Array
    angle: float | None
    aligned: bool

    @property
    def rpy(self) -> Array:
        """(3,) of the frame, seen from the one that was named, in whose axes the wrench is written: [rad], as in a
        URDF."""
        return np.asarray(pin.rpy.matrixToRpy(self.Q.T))


def other_axes(holds: Holds, gravity: Array, sign: int | None, criteria: Standing = USUAL) -> OtherAxes | None:
    """What explains the forces of the postures clearly better than the frame's own axes, gravity's direction (3,) in
    {B} taken as stated; None where nothing does, or too few directions of gravity are among them.

    f = -s m g Q d + f_0, d the direction of gravity in {S}. sign: s, where it is stated; else Q is a rotation.
    """
    f, R = holds.wrench[:, :3], holds.rotation
    d = np.einsum("kji,j->ki", R, gravity / np.linalg.norm(gravity))
    columns = np.column_stack([d, np.ones(len(d))])
    singular = np.linalg.svd(columns, compute_uv=False)
    if len(d) < 6 or singular[-1] < criteria.seen_axes * singular[0]:
        return None
    A = force_columns(R)
    stated = A @ np.linalg.lstsq(A, f.ravel())[0] - f.ravel()
    M = np.linalg.lstsq(columns, f)[0][:3].T  # f = M d + f_0
    U, size, Vt = np.linalg.svd(M)
    turn = np.asarray(U @ Vt)
    s = sign if sign is not None else (1 if np.linalg.det(turn) < 0.0 else -1)
    Q = -s * turn
    left = f - float(np.mean(size)) * d @ turn.T
    left = left - left.mean(axis=0)
    if criteria.clearly * float(np.sqrt(np.mean(left**2))) > float(np.sqrt(np.mean(stated**2))):
        return None
    nearest = np.round(Q)
    aligned = bool(np.abs(Q - nearest).max() < criteria.aligned and np.any(nearest != np.eye(3)))
    mirrored = np.linalg.det(Q) < 0.0
    angle = None if mirrored else float(np.arccos(np.clip((np.trace(Q) - 1.0) / 2.0, -1.0, 1.0)))
    return OtherAxes(np.asarray(nearest if aligned else Q), angle, aligned)


def exchanged_moments(holds: Holds, criteria: Standing = USUAL) -> Array | None:
    """(3, 3) what is read of a moment in the axes of the forces, where other columns or signs of the moments alone fit
    the forces of the postures clearly better than those stated; None where none do. Up to the sign of all three, which
    postures do not tell: the one that leaves most columns as they are.

    Implements [Payload] (15) for moments Q τ, Q one of the 48 that exchange and reverse axes: τ = c x f + ι.
    """
    B, tau = moment_columns(holds.wrench[:, :3]), holds.wrench[:, 3:]
    if np.linalg.cond(B / np.linalg.norm(B, axis=0)) > 1.0 / criteria.rank:
        return None
    root = np.linalg.qr(B)[0]

    def left(Q: Array) -> float:
        y = (tau @ Q).ravel()  # as it would be in the forces' axes
        return float(np.sqrt(np.mean((y - root @ (root.T @ y)) ** 2)))

    others = _exchanges()
    stated, best = left(np.eye(3)), min(left(Q) for Q in others)
    weight = float(np.abs(tau - tau.mean(axis=0)).max())
    if stated < max(criteria.clearly * float(holds.std[3:].max()), criteria.unexplained * weight):
        return None
    if criteria.clearly * best > stated:
        return None
    alike = [Q for Q in others if left(Q) < criteria.clearly * max(best, float(holds.std[3:].max()))]
    if len(alike) > 2:  # and their mirror images
        return None
    return np.asarray(max(alike, key=lambda Q: float(np.trace(Q))))


def axes_in_motion(rows: Rows, criteria: Standing = USUAL) -> tuple[OtherAxes, bool] | None:
    """What of 48 ways to exchange and reverse axes, of the wrench, of its forces or of its moments alone, explains
    motion clearly better than what is stated, by a payload that has a mass; and whether it is of the moments alone.
    None where none does, or several do. Where no posture is there to tell."""
    every = 4  # samples: enough for a body
    z = rows.z[::every]
    A = z[:, :, :-1].reshape(-1, rows.size)
    scale = np.maximum(np.linalg.norm(A, axis=0), 1e-12)
    root, R = np.linalg.qr(A / scale)
    parts, b = root.reshape(len(z), 2, 3, -1), z[:, :, -1].reshape(len(z), 2, 3)
    across = np.einsum("tpik,tpj->pijk", parts, b, optimize=True)
    whole, same = float(np.sum(b**2)), np.eye(3)

    def left(of_force: Array, of_moment: Array) -> tuple[float, float]:
        """Square of what a body leaves of Qᵀ b, as it would be in the frame's axes; and its mass."""
        c = np.tensordot(of_force.T, across[0]) + np.tensordot(of_moment.T, across[1])
        return whole - float(c @ c), float((np.linalg.solve(R, c) / scale)[0])

    stated = left(same, same)[0]
    found = sorted(
        ((*left(*pair), pair) for Q in _exchanges() for pair in ((Q, Q), (Q, same), (same, Q))),
        key=lambda each: each[0],
    )
    heavy = [(square, pair) for square, mass, pair in found if mass > 0.0]
    if not heavy or criteria.clearly**2 * heavy[0][0] > stated:
        return None
    alike = [pair for square, pair in heavy if square < criteria.clearly * heavy[0][0]]
    kinds = {(np.array_equal(F, same), np.array_equal(M, same)) for F, M in alike}
    if len(kinds) > 1 or len(alike) > 2:
        return None
    F, M = max(alike, key=lambda pair: float(np.trace(pair[0]) + np.trace(pair[1])))  # and its mirror image
    alone = np.array_equal(F, same)
    Q = M if alone else F
    angle = None if np.linalg.det(Q) < 0.0 else float(np.arccos(np.clip((np.trace(Q) - 1.0) / 2.0, -1.0, 1.0)))
    return OtherAxes(Q, angle, aligned=True), alone


def _exchanges() -> list[Array]:
    """The 48 that exchange and reverse axes."""
    return [
        np.eye(3)[list(order)] * np.array(signs)[:, None]
        for order in permutations(range(3))
        for signs in product((1.0, -1.0), repeat=3)
    ]


def said_of_moments(Q: Array, columns: tuple[str, ...]) -> tuple[str, str]:
    """What was found of the last three columns, and advice."""
    reads = _reads(Q, columns[3:])
    detail = f"the moments are written in other axes than the forces: {', '.join(reads)}"
    return detail, "Check the order and the signs of the last three of `sensor.wrench`; the forces fit as they are."


def _reads(Q: Array, columns: tuple[str, ...]) -> list[str]:
    """What each column reads, of those that read something else."""
    out = []
    for k, (name, row) in enumerate(zip(columns, Q, strict=True)):
        of = int(np.argmax(np.abs(row)))
        if (of, row[of]) != (k, 1.0):
            out.append(f"{name!r} reads what {'-' if row[of] < 0 else '+'}{'xyz'[of]} should")
    return out


def said(found: OtherAxes, columns: tuple[str, ...], frame: str) -> tuple[str, str]:
    """What was found of the first three columns, and advice."""
    of = f"`{frame}`" if frame else "the sensor"
    if found.aligned:
        reads = []
        for name, row in zip(columns[:3], found.Q, strict=True):
            k = int(np.argmax(np.abs(row)))
            if (name, row[k]) != (columns[k], 1.0):
                reads.append(f"{name!r} reads what {'-' if row[k] < 0 else '+'}{'xyz'[k]} of {of} should")
        detail = f"the wrench is written in other axes than those of {of}: {', '.join(reads)}"
    elif found.angle is None:
        detail = f"the wrench is written in axes that are mirrored against those of {of}"
    else:
        detail = f"the wrench's axes stand {np.degrees(found.angle):.3g}° off those of {of}"
    if found.angle is None:
        return (
            detail,
            "Check the order and the signs of `sensor.wrench`, force and moment alike, and those of the joints.",
        )
    rpy = " ".join(f"{each:.4f}" for each in found.rpy + 0.0)
    return detail, f"Name the frame whose axes they are: in the URDF, one fixed to {of} with rpy={rpy!r}."
