"""SDFormat 1.9: a model of one link with `<inertial>`.

Definition: sdformat.org/spec, link/inertial. Inertia about the centre of mass, axes of `<pose>`, here the link's own.
"""

from __future__ import annotations

from exogauge.payload.exports.body import Body, numbers, said


def write(body: Body) -> str:
    I = body.solid("SDF")  # noqa: E741
    pairs = ("xx", "xy", "xz", "yy", "yz", "zz")
    inertia = "\n".join(
        f"          <i{ab}>{float(I['xyz'.index(ab[0]), 'xyz'.index(ab[1])])!r}</i{ab}>" for ab in pairs
    )
    return f"""<?xml version="1.0"?>
<!--
{said(body, "kg, m, kg·m²; inertia about the centre of mass, axes of the frame")}
-->
<sdf version="1.9">
  <model name="payload">
    <link name="payload">
      <inertial>
        <pose>{numbers(body.centre)} 0 0 0</pose>
        <mass>{body.mass!r}</mass>
        <inertia>
{inertia}
        </inertia>
      </inertial>
    </link>
  </model>
</sdf>
"""
