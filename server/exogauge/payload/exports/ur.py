"""URScript `set_target_payload(m, cog, inertia)` of Universal Robots.

Definition: Universal Robots, Script Manual SW 10.6 (and 5.x since 5.10), set_target_payload: kg; m from the tool mount;
kg·m², [Ixx, Iyy, Izz, Ixy, Ixz, Iyz] about the centre of gravity, axes of the tool flange; without it, zeros are used.
"""

from __future__ import annotations

import numpy as np

from exogauge.errors import BadInput, Fault
from exogauge.payload.exports.body import Body, fixed, said

MOST = 133.0  # kg·m² of each component, by the same page
PLACES = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


def write(body: Body) -> str:
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
