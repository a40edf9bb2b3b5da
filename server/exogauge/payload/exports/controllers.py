"""A payload as controllers of robots take it. Each function cites its maker's definition."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from exogauge.errors import BadInput, Fault
from exogauge.payload.exports.body import Body, fixed, said

MOST = 133.0  # kg·m² of each component that Universal Robots take
PLACES = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


def set_target_payload(body: Body) -> str:
    """URScript `set_target_payload(m, cog, inertia)` of Universal Robots.

    Definition: Universal Robots, Script Manual SW 10.6 (and 5.x since 5.10), set_target_payload: kg; m from the
    tool mount; kg·m², [Ixx, Iyy, Izz, Ixy, Ixz, Iyz] about the centre of gravity, axes of the tool flange; without
    it, zeros are used.
    """
    cog = ", ".join(fixed(x, 9) for x in body.centre)
    units = "kg, m, kg·m²; inertia about the centre of gravity, [Ixx, Iyy, Izz, Ixy, Ixz, Iyz]"
    note, given = "# written for the tool flange", ""
    if not body.frame.startswith("flange"):
        note = "# the frame must be that of the tool flange: give the sensor's pose in it"
    if body.inertia is None:
        note += "\n# the data decide no inertia: the controller takes zeros"
    else:
        if float(np.abs(body.solid("set_target_payload")).max()) > MOST:
            advice = f"Universal Robots take at most {MOST:g} kg·m² in each component."
            worst = f"{float(np.abs(body.inertia).max()):.4g}"
            raise BadInput(Fault("the inertia is too large for this controller", "too_large", advice, value=worst))
        given = f", [{', '.join(fixed(body.inertia[place], 9) for place in PLACES)}]"
    return f"{said(body, units, '# ')}\n{note}\nset_target_payload({fixed(body.mass, 9)}, [{cog}]{given})\n"


def load_data(body: Body, number: int = 1) -> str:
    """KRL `LOAD_DATA[n]` of KUKA, as it stands in $config.dat.

    Definition: KUKA, KR IONTEC assembly instructions V4 (2021), 4.5 "Load center of gravity and mass moment of
    inertia": kg; mm in the flange's frame; A, B, C [°] of the principal axes: A about Z, then B about the new Y,
    then C about the new X; moments [kg·m²] about these axes through the centre of mass.
    """
    moments, axes = body.principal("LOAD_DATA")
    C, B, A = np.degrees(pin.rpy.matrixToRpy(axes))
    x, y, z = (fixed(1e3 * value, 6) for value in body.centre)
    a, b, c = (fixed(float(value), 6) for value in (A, B, C))
    centre = f"CM {{X {x},Y {y},Z {z},A {a},B {b},C {c}}}"
    inertia = ",".join(f"{axis} {fixed(float(value), 9)}" for axis, value in zip("XYZ", moments, strict=True))
    units = "kg; mm and degrees; kg·m² about the principal axes"
    note = "; the frame must be that of the flange; write it into LOAD_DATA of the tool's number"
    return (
        f"{said(body, units, '; ')}\n{note}\nLOAD_DATA[{number}]={{M {fixed(body.mass, 9)},{centre},J {{{inertia}}}}}\n"
    )


def loaddata(body: Body) -> str:
    """RAPID `loaddata` of ABB: [mass, cog, aom, ix, iy, iz].

    Definition: ABB, Technical reference manual, RAPID Instructions, Functions and Data types, loaddata: kg; mm; aom
    is the orientation of the principal axes as a quaternion [q1, q2, q3, q4], q1 its scalar; moments [kg·m²] about
    these axes through the centre of gravity; with zeros the load is a point mass. A tool's load stands in the
    wrist's frame (tool0), a gripped load in the tool's.
    """
    moments, axes = np.zeros(3), np.eye(3)
    note = "! the frame must be that of the wrist (tool0) in tooldata, of the tool in GripLoad"
    if body.inertia is None:
        note += "\n! the data decide no inertia: a point mass"
    else:
        moments, axes = body.principal("loaddata")
    x, y, z, w = pin.Quaternion(axes).coeffs()
    sense = 1.0 if w >= 0.0 else -1.0
    cog = ", ".join(fixed(1e3 * value, 6) for value in body.centre)
    aom = ", ".join(fixed(float(sense * value), 9) for value in (w, x, y, z))
    given = ", ".join(fixed(float(value), 9) for value in moments)
    units = "kg; mm; quaternion, scalar first; kg·m² about the principal axes"
    value = f"[{fixed(body.mass, 9)}, [{cog}], [{aom}], {given}]"
    return f"{said(body, units, '! ')}\n{note}\nPERS loaddata payload1 := {value};\n"
