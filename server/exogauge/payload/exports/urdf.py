"""URDF: a robot of one link with `<inertial>`, to be copied into the link that carries the payload.

Definition: wiki.ros.org/urdf/XML/link. Inertia about the centre of mass, axes of the link, since `rpy` is zero.
"""

from __future__ import annotations

from exogauge.payload.exports.body import Body, numbers, said


def write(body: Body) -> str:
    I = body.solid("URDF")  # noqa: E741
    pairs = ("xx", "xy", "xz", "yy", "yz", "zz")
    inertia = " ".join(f'i{ab}="{float(I["xyz".index(ab[0]), "xyz".index(ab[1])])!r}"' for ab in pairs)
    return f"""<?xml version="1.0"?>
<!--
{said(body, "kg, m, kg·m²; inertia about the centre of mass, axes of the frame")}
-->
<robot name="payload">
  <link name="payload">
    <inertial>
      <origin xyz="{numbers(body.centre)}" rpy="0 0 0"/>
      <mass value="{body.mass!r}"/>
      <inertia {inertia}/>
    </inertial>
  </link>
</robot>
"""
