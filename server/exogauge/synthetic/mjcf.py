"""A robot as MuJoCo sees it: same table of links, no pinocchio, no URDF in between."""

from __future__ import annotations

import mujoco
import numpy as np
from numpy.typing import NDArray

from exogauge.synthetic.inertia import Mass
from exogauge.synthetic.robot_facts import (
    AXES,
    BASE,
    CONTACT_BALL,
    FEET,
    IMU_FRAME,
    LINKS,
    SOLE_CENTRE,
    SOLE_SIZE,
    Link,
)
from exogauge.synthetic.suit import Suit
from exogauge.synthetic.true_robot import TrueRobot

Array = NDArray[np.float64]

TIME_STEP = 0.001


def mujoco_model(robot: TrueRobot, suit: Suit | None = None) -> mujoco.MjModel:
    """The robot standing on a plane, compiled; a suit's bands are tendons in their own order, without mass or damping.

    Semi-implicit Euler without implicit damping: the accelerations that the sensors see are those that are integrated.
    Positions live at t, velocities at t - h/2; k_d h/2 more rotor inertia makes the damping act on the velocity at t.
    Coulomb friction is a joint constraint, hard enough to hold (creep below 1e-5 rad/s).
    """
    spec = mujoco.MjSpec()
    spec.option.timestep = TIME_STEP
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_EULER
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_EULERDAMP
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = 10.0
    spec.option.tolerance = 1e-12
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[5.0, 5.0, 0.1], friction=[1.0, 0.005, 0.0001])
    bodies: dict[str, mujoco.MjsBody] = {}
    for link in LINKS:
        if link.mass == 0.0:
            continue  # sensor frames become sites of the bodies around them
        parent, offset = _parent(link)
        body = (bodies[parent] if parent else spec.worldbody).add_body(name=link.name, pos=offset)
        bodies[link.name] = body
        _set_mass(body, robot.masses[link.name])
        if parent is None:
            body.add_freejoint(name="base")
        elif link.joint:
            drive = robot.joints[link.joint.name]
            joint = body.add_joint(name=link.joint.name, type=mujoco.mjtJoint.mjJNT_HINGE, axis=AXES[link.joint.axis])
            joint.damping = np.array([drive.k_d, 0.0, 0.0])
            joint.armature = drive.J_r + drive.k_d * TIME_STEP / 2
            joint.frictionloss = drive.tau_c
            joint.solref_friction = [4 * TIME_STEP, 1.0]
            joint.solimp_friction = [0.9999, 0.9999, 0.001, 0.5, 2.0]
    _add_soles(spec)
    _add_imu(spec)
    if suit is not None:
        _add_bands(spec, suit)
    return spec.compile()


def _parent(link: Link) -> tuple[str | None, Array]:
    """The nearest link with mass above, and the link's origin in it."""
    by_name = {other.name: other for other in LINKS}
    offset, parent = np.array(link.origin, dtype=np.float64), link.parent
    while parent is not None and by_name[parent].mass == 0.0:
        offset, parent = offset + by_name[parent].origin, by_name[parent].parent
    return parent, offset


def _set_mass(body: mujoco.MjsBody, mass: Mass) -> None:
    I = mass.inertia  # noqa: E741
    body.explicitinertial = True
    body.mass = mass.mass
    body.ipos = mass.centre
    body.fullinertia = [I[0, 0], I[1, 1], I[2, 2], I[0, 1], I[0, 2], I[1, 2]]


def _add_soles(spec: mujoco.MjSpec) -> None:
    """Balls at the corners of each sole, and the six-axis sensor between foot and sole."""
    half = np.array(SOLE_SIZE) / 2 - [CONTACT_BALL, CONTACT_BALL, 0.0]
    for foot in FEET:
        sole = spec.body(foot.replace("_foot", "_sole"))
        for x in (-1, 1):
            for y in (-1, 1):
                corner = np.array(SOLE_CENTRE) + half * [x, y, -1] + [0, 0, CONTACT_BALL]
                sole.add_geom(
                    type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[CONTACT_BALL, 0, 0], pos=corner, condim=3,
                    friction=[1.0, 0.005, 0.0001], solref=[0.02, 1.0], solimp=[0.95, 0.99, 0.002, 0.5, 2.0],
                )  # fmt: skip
        sole.add_site(name=f"{foot}_sensor")
        for kind in (mujoco.mjtSensor.mjSENS_FORCE, mujoco.mjtSensor.mjSENS_TORQUE):
            spec.add_sensor(type=kind, objtype=mujoco.mjtObj.mjOBJ_SITE, objname=f"{foot}_sensor")


def _add_imu(spec: mujoco.MjSpec) -> None:
    frame = next(link for link in LINKS if link.name == IMU_FRAME)
    spec.body(BASE).add_site(name=IMU_FRAME, pos=frame.origin, quat=_quaternion(*frame.rpy))
    for kind in (mujoco.mjtSensor.mjSENS_ACCELEROMETER, mujoco.mjtSensor.mjSENS_GYRO):
        spec.add_sensor(type=kind, objtype=mujoco.mjtObj.mjOBJ_SITE, objname=IMU_FRAME)


def _add_bands(spec: mujoco.MjSpec, suit: Suit) -> None:
    """Springs that pull and never push, straight from one via point to the next."""
    for band in suit.bands:
        tendon = spec.add_tendon(name=band.facts.name)
        tendon.stiffness = np.array([band.stiffness, 0.0, 0.0])
        tendon.springlength = np.array([0.0, band.natural_length])
        for k, point in enumerate(band.facts.via_points):
            site = f"{band.facts.name}_{k}"
            spec.body(point.link).add_site(name=site, pos=point.xyz)
            tendon.wrap_site(site)


def _quaternion(roll: float, pitch: float, yaw: float) -> Array:
    """wxyz of Rz(yaw) Ry(pitch) Rx(roll), the angles of a URDF."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(np.array([roll, pitch, yaw]) / 2), np.sin(np.array([roll, pitch, yaw]) / 2)
    return np.array(
        [
            cr * cp * cy + sr * sp * sy,
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
        ]
    )
