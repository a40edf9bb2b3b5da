"""A payload as files of robots take it: XML, to be copied into the link that carries it."""

from __future__ import annotations

from exogauge.payload.exports.body import Body, numbers, said


def urdf(body: Body) -> str:
    """URDF: a robot of one link with `<inertial>`, to be copied into the link that carries the payload.

    Definition: wiki.ros.org/urdf/XML/link. Inertia about the centre of mass, axes of the link, since `rpy` is zero.
    """
    inertia = " ".join(f'{name}="{value!r}"' for name, value in _inertia(body, "URDF").items())
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


def sdf(body: Body) -> str:
    """SDFormat 1.9: a model of one link with `<inertial>`.

    Definition: sdformat.org/spec, link/inertial. Inertia about the centre of mass, axes of `<pose>`, here the
    link's own.
    """
    inertia = "\n".join(f"          <{name}>{value!r}</{name}>" for name, value in _inertia(body, "SDF").items())
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


def mjcf(body: Body) -> str:
    """MJCF of MuJoCo: a free body with `<inertial>`, to be copied into the body that carries the payload.

    Definition: mujoco.readthedocs.io, XML reference, body/inertial: `fullinertia` is M(1,1), M(2,2), M(3,3),
    M(1,2), M(1,3), M(2,3) about `pos`, axes of the body.
    """
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


def _inertia(body: Body, form: str) -> dict[str, float]:
    """ixx … izz [kg·m²], as both formats name them."""
    I = body.solid(form)  # noqa: E741
    places = {"ixx": (0, 0), "ixy": (0, 1), "ixz": (0, 2), "iyy": (1, 1), "iyz": (1, 2), "izz": (2, 2)}
    return {name: float(I[place]) for name, place in places.items()}
