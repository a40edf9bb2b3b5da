"""robot.yaml and its URDF become a `Robot`; a name that the URDF does not hold is refused where it is written."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from exogauge.criteria.identifying import DECLARED
from exogauge.errors import BadRobot
from exogauge.robots.description import EXACT, Declared, Joint, Robot, WrenchSensor
from exogauge.robots.tree import RigidTree
from exogauge.robots.urdf import load_tree
from exogauge.robots.urdf_check import MOVING_TYPES, read_urdf
from exogauge.studies.intake.bundle import Bundle
from exogauge.studies.intake.contract import RobotFile
from exogauge.studies.intake.yaml_file import MAX_BYTES, Pointer, YamlPage, load_yaml, place, suggestion

Array = NDArray[np.float64]

MAX_URDF_BYTES = 20_000_000
SIGN = {"world_on_robot": 1.0, "robot_on_world": -1.0, "payload_on_sensor": 1.0, "sensor_on_payload": -1.0}


def load_robot(folder: Path, robot_yaml: str = "robot.yaml") -> Robot:
    """The robot that `folder / robot_yaml` describes."""
    return read_robot(Bundle(folder, robot_yaml), robot_yaml)[0]


def read_robot(
    bundle: Bundle, name: str, *, named_in: str | None = None, row: int | None = None
) -> tuple[Robot, RobotFile, bytes]:
    """The robot, the file as written, and the URDF's bytes. named_in, row: where `name` is written."""
    data = bundle.read(name, limit=MAX_BYTES, named_in=named_in, column="robot", row=row)
    entry = load_yaml(data, RobotFile, file=name, error=BadRobot)
    page = YamlPage(name, data)
    _refuse_repeated(entry, page)
    urdf = bundle.read(entry.urdf, limit=MAX_URDF_BYTES, named_in=name, column="urdf", row=place(data, ("urdf",)))
    base_link, urdf_name = _check_names(entry, urdf, page)
    tree = load_tree(
        urdf,
        joints=tuple(joint.name for joint in entry.joints),
        base_link=base_link,
        floating=entry.base == "floating",
        cut_frames=tuple(sensor.frame for sensor in entry.ft_sensors if sensor.role == "contact"),
        carrying=tuple(sensor.frame for sensor in entry.ft_sensors if sensor.role == "cut"),
        file=entry.urdf,
    )
    robot = describe(entry, tree, page, name=entry.name or urdf_name or entry.urdf.rsplit("/", 1)[-1])
    return robot, entry, urdf


def _check_names(entry: RobotFile, urdf: bytes, page: YamlPage) -> tuple[str, str]:
    """(base link, robot's name in the URDF). The base link of a fixed base is the URDF's root where none is named.

    Names are checked here, because here their line in robot.yaml is known.
    """
    robot = read_urdf(urdf, entry.urdf)
    links = [link.get("name", "") for link in robot.findall("link")]
    joints = [joint.get("name", "") for joint in robot.findall("joint") if joint.get("type") in MOVING_TYPES]
    for k, joint in enumerate(entry.joints):
        if joint.name not in joints:
            detail = f"the URDF holds no movable joint {joint.name!r}"
            raise BadRobot(
                page.fault(detail, "unknown_joint", ("joints", k, "name"), suggestion(joint.name, joints), joint.name)
            )
    fixed = [joint.get("name", "") for joint in robot.findall("joint") if joint.get("type") == "fixed"]
    for k, sensor in enumerate(entry.ft_sensors):
        if sensor.frame not in links and sensor.frame not in fixed:
            detail, advice = f"the URDF holds no frame {sensor.frame!r}", suggestion(sensor.frame, [*links, *fixed])
            raise BadRobot(page.fault(detail, "unknown_frame", ("ft_sensors", k, "frame"), advice, sensor.frame))
    if entry.base_link is not None:
        if entry.base_link not in links:
            detail, advice = f"the URDF holds no link {entry.base_link!r}", suggestion(entry.base_link, links)
            raise BadRobot(page.fault(detail, "unknown_link", ("base_link",), advice, entry.base_link))
        return entry.base_link, robot.get("name", "")
    children = {child.get("link") for joint in robot.findall("joint") for child in joint.findall("child")}
    return next(link for link in links if link not in children), robot.get("name", "")


def describe(entry: RobotFile, tree: RigidTree, page: YamlPage, name: str) -> Robot:
    return Robot(
        name=name,
        tree=tree,
        joints=tuple(
            Joint(
                joint.name,
                joint.actuation,
                joint.gear_ratio,
                joint.prior.model_dump(exclude_none=True),
                joint.prior_std.model_dump(exclude_none=True),
                joint.sign_checked,
            )
            for joint in entry.joints
        ),
        T_base_imu=_imu_in_base(entry, tree, page),
        sensors=tuple(
            WrenchSensor(each.name, each.frame, each.role, _sign(each.role, each.sees, tree.frames[each.frame][0]))
            for each in entry.ft_sensors
        ),
        axes_from_joints=axes_from_joints(entry),
        noise=entry.noise.model_dump(exclude_none=True),
        inertial_std=_inertial_std(entry.inertial_prior_std, tree, page),
        declared=_declared(entry, page),
    )


def _declared(entry: RobotFile, page: YamlPage) -> Declared:
    """As stated, and what is usual of the rest."""
    if entry.uncertainty == "none":
        return EXACT
    stated, of_joints = entry.uncertainty.model_dump(exclude={"zeros_taken"}), dict[str, float]()
    if isinstance(stated["torque_zero"], dict):
        of_joints = stated["torque_zero"]
        stated["torque_zero"] = of_joints.pop("default", None)
        names = [joint.name for joint in entry.joints]
        for name in of_joints:
            if name not in names:
                advice = suggestion(name, names)
                pointer = ("uncertainty", "torque_zero", name)
                raise BadRobot(page.fault(f"no joint {name!r}", "unknown_joint", pointer, advice))
    values = {key: (value, getattr(DECLARED, key)) for key, value in stated.items()}
    left_out = frozenset(key for key, (value, _) in values.items() if value is None)
    return Declared(
        **{key: usual if value is None else value for key, (value, usual) in values.items()},
        zeros_taken=entry.uncertainty.zeros_taken,
        torque_zero_of=of_joints,
        defaulted=left_out,
    )


def _sign(role: str, sees: str, body: int) -> float:
    """A sensor under a robot that stands on it carries the robot, so what the world does to the robot holds it."""
    under = role == "cut" and body < 0 and sees in ("world_on_robot", "robot_on_world")
    return -SIGN[sees] if under else SIGN[sees]


def motor_from_joint(entry: RobotFile) -> Array:
    """(J, J) matrix, motor angle = matrix @ joint angle; NaN on the diagonal where no gear ratio is given."""
    matrix = np.diag([np.nan if joint.gear_ratio is None else joint.gear_ratio for joint in entry.joints])
    if entry.transmission is not None:
        rows = _coupled(entry)
        matrix[np.ix_(rows, rows)] = entry.transmission.matrix
    return matrix


def axes_from_joints(entry: RobotFile) -> Array:
    """(J, J) matrix C = D⁻¹ M, axis coordinate = C @ joint angle.

    M: the coupled block of robot.yaml; D: the rows' own gears, so that an axis is a motor axis seen at its joint
    (unit diagonal; friction, k_T and rotor inertia come out joint-side). Identity where nothing is coupled.
    """
    matrix = np.eye(len(entry.joints))
    if entry.transmission is not None:
        rows, block = _coupled(entry), np.array(entry.transmission.matrix)
        matrix[np.ix_(rows, rows)] = block / np.diag(block)[:, None]
    return matrix


def _coupled(entry: RobotFile) -> list[int]:
    names = [joint.name for joint in entry.joints]
    return [names.index(name) for name in (entry.transmission.joints if entry.transmission else [])]


def _refuse_repeated(entry: RobotFile, page: YamlPage) -> None:
    for key, items in (("joints", entry.joints), ("ft_sensors", entry.ft_sensors)):
        names = [item.name for item in items]
        for k, name in enumerate(names):
            if name in names[:k]:
                raise BadRobot(page.fault(f"{name!r} is listed twice", "duplicate_name", (key, k, "name")))
    joints = [joint.name for joint in entry.joints]
    transmission = entry.transmission
    if transmission is None:
        return
    for k, name in enumerate(transmission.joints):
        pointer = ("transmission", "joints", k)
        if name not in joints:
            raise BadRobot(page.fault(f"no joint {name!r}", "unknown_joint", pointer, suggestion(name, joints), name))
        if name in transmission.joints[:k]:
            raise BadRobot(page.fault(f"{name!r} is listed twice", "duplicate_name", pointer))
        own, written = transmission.matrix[k][k], entry.joints[joints.index(name)].gear_ratio
        if written is not None and not np.isclose(written, own, rtol=1e-6):
            detail = f"joint {name!r} has gear_ratio {written:g}, but its motor's own entry in the matrix is {own:g}"
            raise BadRobot(
                page.fault(detail, "gear_mismatch", ("transmission", "matrix", k), "Make them equal.", f"{own:g}")
            )
    unlogged = [joint.name for joint in entry.joints if joint.actuation == "none" and joint.name in transmission.joints]
    if unlogged and len(unlogged) < len(transmission.joints):
        detail = f"the motors of coupled joints share their torque, but that of {unlogged[0]!r} is not logged"
        advice = "Give all of them `actuation: none`, or log them all."
        raise BadRobot(page.fault(detail, "coupled_and_not_logged", ("transmission", "joints"), advice, unlogged[0]))
    block = np.array(transmission.matrix)
    if np.linalg.matrix_rank(block / np.abs(block).max(axis=1, keepdims=True)) < len(block):
        raise BadRobot(
            page.fault("the coupling matrix cannot be inverted", "singular_matrix", ("transmission", "matrix"))
        )


def _imu_in_base(entry: RobotFile, tree: RigidTree, page: YamlPage) -> pin.SE3 | None:
    """T_base_imu for a floating base; a fixed base has no use for an IMU."""
    if not tree.floating or entry.imu is None:
        return None
    key = "frame" if entry.imu.frame is not None else "parent"
    name = entry.imu.frame or entry.imu.parent or ""
    body, T_body_frame = _frame(name, tree, page, ("imu", key))
    if body != 0:
        detail = f"the IMU sits on {tree.bodies[body]!r}, the base link is {tree.bodies[0]!r}"
        raise BadRobot(
            page.fault(
                detail, "imu_not_on_base", ("imu", key), "Name the link that carries the IMU as base_link.", name
            )
        )
    if entry.imu.frame is not None:
        return T_body_frame
    rotation = pin.rpy.rpyToMatrix(np.array(entry.imu.rpy or (0.0, 0.0, 0.0)))
    return T_body_frame * pin.SE3(rotation, np.array(entry.imu.xyz or (0.0, 0.0, 0.0)))


def _frame(name: str, tree: RigidTree, page: YamlPage, pointer: Pointer) -> tuple[int, pin.SE3]:
    if name not in tree.frames:
        raise BadRobot(
            page.fault(
                f"the URDF holds no frame {name!r}", "unknown_frame", pointer, suggestion(name, list(tree.frames))
            )
        )
    return tree.frames[name]


def _inertial_std(written: Mapping[str, float], tree: RigidTree, page: YamlPage) -> dict[str, float]:
    """By body name, "" = every other body."""
    result = {}
    for name, value in written.items():
        if name != "default" and name not in tree.bodies:
            advice = suggestion(name, tree.bodies)
            if name in tree.frames and tree.frames[name][0] >= 0:
                advice = f"It is fixed to {tree.bodies[tree.frames[name][0]]!r}: name that one."
            raise BadRobot(page.fault(f"no moving link {name!r}", "unknown_link", ("inertial_prior_std", name), advice))
        result["" if name == "default" else name] = value
    return result
