"""A trunk that bends and leans over two flat feet, slowly, made by pinocchio alone: of its legs the angles are logged,
not what they bear."""

from __future__ import annotations

from functools import cache

import numpy as np
import pinocchio as pin

from exogauge.logs.model import Log
from exogauge.robots.description import Joint, Robot, WrenchSensor
from exogauge.robots.urdf import load_tree

SIDES, LEG = ("left", "right"), {"roll": "1 0 0", "hip": "0 1 0", "knee": "0 1 0", "ankle": "0 1 0"}
JOINTS, FEET = tuple(f"{side}_{joint}" for side in SIDES for joint in LEG), tuple(f"{side}_sole" for side in SIDES)
RATE, SECONDS = 100.0, 40.0


def urdf(turned: tuple[str, ...] = ()) -> bytes:
    """turned: joints whose axis is the reverse of what it is."""

    def link(name: str, mass: float, z: float) -> str:
        size = "".join(f'{axis}="{0.01 * mass if axis[1] == axis[2] else 0.0}" ' for axis in
                       ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"))  # fmt: skip
        return (
            f'<link name="{name}"><inertial><origin xyz="0.02 0 {z}"/><mass value="{mass}"/><inertia {size}/>'
            "</inertial></link>"
        )

    parts = [link("trunk", 20.0, 0.2)]
    for side, y in (("left", 0.1), ("right", -0.1)):
        parent, place = "trunk", f"0 {y} 0"
        for joint, axis in LEG.items():
            name, child = f"{side}_{joint}", f"{side}_{joint}_link"
            signed = " ".join(str(-float(each)) for each in axis.split()) if name in turned else axis
            parts.append(link(child, 2.0, -0.1 if joint in ("hip", "knee") else -0.02))
            parts.append(
                f'<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/>'
                f'<origin xyz="{place}"/><axis xyz="{signed}"/>'
                '<limit lower="-3" upper="3" velocity="10" effort="300"/></joint>'
            )
            parent, place = child, {"roll": "0 0 -0.05", "hip": "0 0 -0.3", "knee": "0 0 -0.3"}.get(joint, "")
        parts.append(
            f'<link name="{side}_sole"/><joint name="{side}_stands" type="fixed"><parent link="{parent}"/>'
            f'<child link="{side}_sole"/><origin xyz="0.03 0 -0.08"/></joint>'
        )
    return f'<robot name="stander">{"".join(parts)}</robot>'.encode()


def standing(turned: tuple[str, ...] = ()) -> Robot:
    tree = load_tree(urdf(turned), joints=list(JOINTS), base_link="trunk", floating=True, cut_frames=FEET)
    sensors = tuple(WrenchSensor(name, name, "contact", 1.0) for name in FEET)
    joints = tuple(Joint(name, "none") for name in JOINTS)
    return Robot("stander", tree, joints, pin.SE3.Identity(), sensors, np.eye(8), inertial_std={"": 0.2})


@cache
def record(seed: int, in_world: bool = False) -> Log:
    """in_world: the accelerometer is told in the world's axes."""
    model = pin.buildModelFromXML(urdf().decode(), pin.JointModelFreeFlyer())
    data, rng = model.createData(), np.random.default_rng(seed)
    t = np.arange(0.0, SECONDS, 1.0 / RATE)

    def wave(size: float) -> np.ndarray:
        return sum(size * rng.uniform(0.4, 1.0) * np.sin(2 * np.pi * rng.uniform(0.03, 0.12) * t + each) / 3.0
                   for each in rng.uniform(0.0, 6.28, 3))  # fmt: skip

    pitch, lean = 0.2 + wave(0.3), wave(0.2)
    bent = [wave(0.3) - 0.3, wave(0.4) + 0.6, wave(0.3) - 0.3, wave(0.4) + 0.6]
    q = np.column_stack([-lean, bent[0], bent[1], -pitch - bent[0] - bent[1],
                         -lean, bent[2], bent[3], -pitch - bent[2] - bent[3]])  # fmt: skip
    rows, soles, weight = (
        [],
        [model.getFrameId(name) for name in FEET],
        9.81 * sum(each.mass for each in model.inertias),
    )
    turning = np.gradient(pitch, t), np.gradient(lean, t)
    for k in range(len(t)):
        R = pin.utils.rotate("y", pitch[k]) @ pin.utils.rotate("x", lean[k])
        pin.framesForwardKinematics(model, data, np.concatenate([np.zeros(3), pin.Quaternion(R).coeffs(), q[k]]))
        c = pin.centerOfMass(model, data, np.concatenate([np.zeros(3), pin.Quaternion(R).coeffs(), q[k]]))
        half = np.array([0.0, 0.0, 0.5 * weight])
        moment = -0.5 * sum(np.cross(data.oMf[each].translation - c, half) for each in soles)
        up = np.array([0.0, 0.0, 9.81])
        gyro = R.T @ np.array([0.0, turning[0][k], 0.0]) + np.array([turning[1][k], 0.0, 0.0])
        read = [data.oMf[each].rotation.T @ part for each in soles for part in (half, moment)]
        rows.append(np.concatenate([q[k], up if in_world else R.T @ up, gyro, *read]))
    table = np.array(rows)
    table += rng.standard_normal(table.shape) * np.repeat([1e-5, 0.02, 0.002, 0.3, 0.03, 0.3, 0.03], [8] + [3] * 6)
    names = [*(f"q.{name}" for name in JOINTS), *(f"acc.{axis}" for axis in "xyz"), *(f"gyro.{axis}" for axis in "xyz"),
             *(f"ft.{foot}.{kind}{axis}" for foot in FEET for kind in "fm" for axis in "xyz")]  # fmt: skip
    return Log(f"log{seed}", t, dict(zip(names, table.T, strict=True)))
