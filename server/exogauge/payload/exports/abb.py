"""RAPID `loaddata` of ABB: [mass, cog, aom, ix, iy, iz].

Definition: ABB, Technical reference manual, RAPID Instructions, Functions and Data types, loaddata: kg; mm; aom is the
orientation of the principal axes as a quaternion [q1, q2, q3, q4], q1 its scalar; moments [kg·m²] about these axes
through the centre of gravity; with zeros the load is a point mass. A tool's load stands in the wrist's frame (tool0), a
gripped load in the tool's.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from exogauge.payload.exports.body import Body, fixed, said


def write(body: Body) -> str:
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
