"""KRL `LOAD_DATA[n]` of KUKA, as it stands in $config.dat.

Definition: KUKA, KR IONTEC assembly instructions V4 (2021), 4.5 "Load center of gravity and mass moment of inertia":
kg; mm in the flange's frame; A, B, C [°] of the principal axes: A about Z, then B about the new Y, then C about the new
X; moments [kg·m²] about these axes through the centre of mass.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from exogauge.payload.exports.body import Body, fixed, said


def write(body: Body, number: int = 1) -> str:
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
