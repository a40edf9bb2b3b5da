"""The identified payload as a rigid body, with the doubt of every number, in the sensor's or the flange's frame;
and what every export says of itself.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from exogauge.errors import BadInput, Fault
from exogauge.payload.schema import PayloadResults

Array = NDArray[np.float64]

PLACES = ((0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2))  # of Ixx, Ixy, Iyy, Ixz, Iyz, Izz
TENSOR = ("Ixx", "Ixy", "Iyy", "Ixz", "Iyz", "Izz")
LONGEST_ARM_M = 10.0  # of a pose in the flange: farther, it is in mm


@final
@dataclass(frozen=True)
class Body:
    """mass [kg]; centre (3,) [m]; inertia (3, 3) [kg·m²] about the centre of mass, axes of `frame`, None where the data
    do not decide it. covariance: (10, 10) of [m, c, I_c as TENSOR], (4, 4) without inertia. possible: whether the
    estimate was no possible body, so that these are the values of the likeliest one that is. lacking: what a rigid body
    lacks that was found beside it, and is not in these values."""

    name: str
    frame: str
    mass: float
    centre: Array
    inertia: Array | None
    covariance: Array
    possible: bool = False
    lacking: str = ""

    @property
    def std(self) -> Array:
        """(10,) of mass, centre, inertia; (4,) without inertia."""
        return np.sqrt(np.diag(self.covariance))

    def solid(self, used_by: str) -> Array:
        """The inertia (3, 3). BadInput where there is none, or where no body has it."""
        solid = 1e-12  # of the largest principal moment: below, the triangle inequality holds but for rounding
        if self.inertia is None:
            advice = "Record an excitation in which the wrist turns about all three axes, or export to ur or abb."
            raise BadInput(Fault(f"{used_by} needs an inertia, and the data decide none", "no_inertia", advice))
        principal = np.linalg.eigvalsh(self.inertia)
        if principal[0] <= 0.0 or principal[2] - principal[1] - principal[0] > solid * principal[2]:
            advice = "Record an excitation in which the wrist turns about all three axes."
            detail = f"no body has the principal moments {', '.join(f'{x:.4g}' for x in principal)} kg·m²"
            raise BadInput(Fault(detail, "impossible_body", advice))
        return self.inertia

    def principal(self, used_by: str) -> tuple[Array, Array]:
        """(3,) moments [kg·m²] and R (3, 3), whose columns are the principal axes: I = R diag R ᵀ, det R = 1.

        Of the rotations that differ by the order and the sense of axes it is the one that turns least.
        """
        moments, axes = np.linalg.eigh(self.solid(used_by))
        best = np.eye(3), -np.inf, moments
        for order in ((0, 1, 2), (0, 2, 1), (1, 0, 2), (1, 2, 0), (2, 0, 1), (2, 1, 0)):
            for signs in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
                R = axes[:, order].copy()
                R[:, 0] *= signs[0]
                R[:, 1] *= signs[1]
                R[:, 2] = np.cross(R[:, 0], R[:, 1])
                if np.trace(R) > best[1]:
                    best = R, float(np.trace(R)), moments[list(order)]
        return best[2], best[0]


def body_of(found: PayloadResults) -> Body:
    """About the centre of mass, in the sensor's axes, from the sensor's origin."""
    if found.dynamic is not None:
        values, C = {v.name: v for v in found.dynamic.values}, np.array(found.dynamic.covariance)[:10, :10]
        x = found.dynamic.possible or {name: v.value for name, v in values.items()}
        m, h = x["m"], np.array([x["mx"], x["my"], x["mz"]])
        decided = all(values[name].identified for name in TENSOR)
        inertia, J = _about_centre(m, h, np.array([x[name] for name in TENSOR]))
        if not decided:
            J = J[:4]
        covariance = J @ C @ J.T
        moved = found.dynamic.possible is not None
        missing = found.missing
        lacking = missing.said if missing.verdict in ("effects", "unexplained") else ""
        return Body(found.name, found.frame, m, h / m, inertia if decided else None, covariance, moved, lacking)
    if found.static is None:
        raise BadInput(Fault("these results hold no payload", "no_payload", "Run the identification again."))
    x = {v.name: v.value for v in found.static.values}
    covariance = np.array(found.static.covariance)[:4, :4]
    return Body(found.name, found.frame, x["m"], np.array([x["cx"], x["cy"], x["cz"]]), None, covariance)


def in_flange(body: Body, pose: Sequence[float]) -> Body:
    """The same in the flange's frame. pose: of the sensor in the flange, x, y, z [m] and roll, pitch, yaw [°] about the
    flange's fixed x, y, z."""
    wrong = len(pose) != 6 or not np.isfinite(pose).all() or float(np.abs(pose[:3]).max()) > LONGEST_ARM_M
    if wrong:
        advice = "Give x y z in m, then roll pitch yaw in degrees."
        said = " ".join(f"{x:g}" for x in pose)
        raise BadInput(
            Fault("this is no pose of a sensor in a flange", "bad_pose", advice, column="flange", value=said)
        )
    R, p = pin.rpy.rpyToMatrix(*np.radians(pose[3:])), np.array(pose[:3])
    turned = np.zeros((10, 10))
    turned[0, 0], turned[1:4, 1:4] = 1.0, R
    for k in range(6):
        turned[4:, 4 + k] = _listed(R @ _tensor(np.eye(6)[k]) @ R.T)
    J = turned[: len(body.covariance), : len(body.covariance)]
    frame = f"flange; the sensor stands in it at {' '.join(f'{x:g}' for x in pose)} (m, deg)"
    inertia = None if body.inertia is None else R @ body.inertia @ R.T
    return replace(body, frame=frame, centre=R @ body.centre + p, inertia=inertia, covariance=J @ body.covariance @ J.T)


def _about_centre(m: float, h: Array, about_origin: Array) -> tuple[Array, Array]:
    """(3, 3) I_c = I - (|h|² 1 - h hᵀ)/m, and (10, 10) the slopes of [m, c, I_c] by [m, h, I]. h = m c [kg·m]."""
    steiner = h @ h * np.eye(3) - np.outer(h, h)
    J = np.eye(10)
    J[1:4, 0], J[1:4, 1:4] = -h / m**2, np.eye(3) / m
    J[4:, 0] = _listed(steiner) / m**2
    for k, e in enumerate(np.eye(3)):
        J[4:, 1 + k] = -_listed(2 * h[k] * np.eye(3) - np.outer(e, h) - np.outer(h, e)) / m
    return _tensor(about_origin) - steiner / m, J


def _tensor(six: Array) -> Array:
    I = np.zeros((3, 3))  # noqa: E741
    for (i, j), value in zip(PLACES, six, strict=True):
        I[i, j] = I[j, i] = value
    return I


def _listed(I: Array) -> Array:  # noqa: E741
    return np.array([I[place] for place in PLACES])


def said(body: Body, units: str, before: str = "") -> str:
    """Lines of a comment, each after `before`, which programs of controllers have: these are ASCII. Nothing in them
    ends a comment of any of the formats."""
    doubts = zip(("m", "cx", "cy", "cz", *TENSOR), body.std, strict=False)
    lines = [
        f"exogauge: {body.name}",
        f"frame: {body.frame}",
        "of: what hangs on the sensor; the sensor's own body is not in it",
        f"units: {units}",
        f"standard deviations (kg, m, kg·m²): {', '.join(f'{name} {std:.2g}' for name, std in doubts)}",
    ]
    if body.possible:
        lines.append("the estimate was no possible body; these are the values of the likeliest one that is")
    if body.lacking:
        lines.append(f"look into the results first. {body.lacking}")
    text = "\n".join(before + plain(line) for line in lines)
    return text.replace("·", " ").replace("²", "^2").encode("ascii", "replace").decode() if before else text


def plain(text: str) -> str:
    """Names come from uploads: one line, and no end of a comment in it."""
    return " ".join(text.replace("--", "- -").replace("\0", " ").split())


def numbers(values: Iterable[float]) -> str:
    """With every digit."""
    return " ".join(repr(float(value)) for value in values)


def fixed(value: float, digits: int) -> str:
    """Without an exponent, which not every controller reads; zero has no sign."""
    return f"{value + 0.0:.{digits}f}" if round(value, digits) else f"{0:.{digits}f}"
