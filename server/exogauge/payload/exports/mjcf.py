"""MJCF of MuJoCo: a free body with `<inertial>`, to be copied into the body that carries the payload.

Definition: mujoco.readthedocs.io, XML reference, body/inertial: `fullinertia` is M(1,1), M(2,2), M(3,3), M(1,2),
M(1,3), M(2,3) about `pos`, axes of the body.
"""

from __future__ import annotations

from exogauge.payload.exports.body import Body, numbers, said


def write(body: Body) -> str:
    I = body.solid("MJCF")  # noqa: E741
    full = numbers(I[place] for place in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)))
    return f"""<!--
{said(body, "kg, m, kg·m²; inertia about the centre of mass, axes of the frame")}
-->
<mujoco model="payload">
  <worldbody>
    <body name="payload">
      <freejoint/>
      <inertial pos="{numbers(body.centre)}" mass="{body.mass!r}" fullinertia="{full}"/>
    </body>
  </worldbody>
</mujoco>
"""
