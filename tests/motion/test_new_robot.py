"""A robot that nobody knows, from its URDF to a motion that is judged: what a new user meets."""

from __future__ import annotations

import re
import shutil
from dataclasses import replace
from importlib.metadata import distribution
from pathlib import Path

import mujoco
import numpy as np
import pytest
import yaml
from tests.motion.robots import STOCK, sample_folder

from exogauge.cli import main
from exogauge.criteria.motion_excite import MotionExcite
from exogauge.motion.excite import plan
from exogauge.motion.robot_draft import arms_aside
from exogauge.motion.robot_file import load_motion_robot
from exogauge.robots.moving.touching import Pairs
from exogauge.studies.intake.mesh_files import mesh_opener

QUICK = MotionExcite(top_hz=0.6, per_period=8, drawn=1, steps=25)


def stock(path: str) -> Path:
    return Path(str(distribution("example-robot-data").locate_file(f"{STOCK}/{path}")))


def package(path: str, folder: Path) -> Path:
    """A maker's URDF where it lies in its package, meshes beside it: shared/…/robots/…/urdf."""
    urdf = folder / "example-robot-data" / "robots" / path
    urdf.parent.mkdir(parents=True)
    shutil.copy(stock(path), urdf)
    shutil.copytree(stock(path).parents[1] / "meshes", urdf.parents[1] / "meshes")
    return urdf


@pytest.mark.slow
def test_an_arm_is_drafted_excited_and_judged_without_a_hand(tmp_path: Path, capsys, monkeypatch) -> None:
    """It was no robot with two feet; its own draft was refused for torques per ampere; `check` asked for soles."""
    monkeypatch.setattr(plan.plan_excitation, "__kwdefaults__", {**plan.plan_excitation.__kwdefaults__,
                                                                 "criteria": QUICK})  # fmt: skip
    urdf = package("ur_description/urdf/ur5_robot.urdf", tmp_path)
    robot, table = str(urdf.with_name("robot.yaml")), tmp_path / "a.csv"
    assert main(["motion", "robot", str(urdf)]) == 0
    assert "bolted down" in capsys.readouterr().out
    assert main(["motion", "excite", "--robot", robot, "--seconds", "4", "--out", str(table)]) == 0
    said = capsys.readouterr().out
    assert "not looked at" not in said  # its meshes lie beside the folder of its URDF
    assert main(["motion", "check", str(table), "--robot", robot, "--rate", "1000"]) == 0
    said = capsys.readouterr().out
    assert "centre of pressure" not in said
    share = float(re.search(r"torque +(\d+) % of its bound", said)[1])  # type: ignore[index]
    assert share == pytest.approx(100 * torque_by_mujoco(urdf, table, robot), abs=1.0)
    fast = np.genfromtxt(table, delimiter=",", names=True)
    rows = table.read_text().splitlines()
    table.write_text("\n".join([rows[0], *(",".join([f"{t / 3:.8f}", *row.split(",")[1:]])
                                           for t, row in zip(fast["t"], rows[1:], strict=True))]))  # fmt: skip
    assert main(["motion", "check", str(table), "--robot", robot]) == 1
    assert "velocity of" in capsys.readouterr().out


def torque_by_mujoco(urdf: Path, table: Path, robot: str) -> float:
    """Largest share of an effort, by another program."""
    text = re.sub(r"<(visual|collision)>.*?</\1>", "", urdf.read_text(), flags=re.DOTALL)
    bare = urdf.with_name("bare.urdf")
    bare.write_text(text.replace("</robot>", '<mujoco><compiler fusestatic="false"/></mujoco></robot>'))
    model = mujoco.MjModel.from_xml_path(str(bare))
    data, moving = mujoco.MjData(model), load_motion_robot(Path(robot))
    sampled = np.genfromtxt(table, delimiter=",", names=True, deletechars="")
    q = np.stack([sampled[f"q.{name}"] for name in moving.joints], axis=1)
    step = sampled["t"][1]
    v, a = np.gradient(q, step, axis=0), (q[2:] - 2 * q[1:-1] + q[:-2]) / step**2
    at = [int(model.joint(name).dofadr[0]) for name in moving.joints]
    most = 0.0
    for k in range(1, len(q) - 1):
        data.qpos[at], data.qvel[at], data.qacc[at] = q[k], v[k], a[k - 1]
        mujoco.mj_inverse(model, data)
        most = max(most, float((np.abs(data.qfrc_inverse[at]) / moving.limits.torque).max()))
    return most


def test_joints_without_ends_turn_once_each_way(tmp_path: Path, capsys) -> None:
    """Kinova's were refused until its URDF was rewritten."""
    shutil.copy(stock("kinova_description/robots/kinova.urdf"), tmp_path / "kinova.urdf")
    assert main(["motion", "robot", str(tmp_path / "kinova.urdf")]) == 0
    capsys.readouterr()
    robot = load_motion_robot(tmp_path / "robot.yaml")
    assert robot.model.nq == robot.model.nv == len(robot.joints) == 6
    assert robot.limits.upper[0] == pytest.approx(2 * np.pi)
    assert robot.limits.lower[0] == pytest.approx(-2 * np.pi)
    assert robot.limits.upper[1] == pytest.approx(5.46288, abs=1e-4)  # as the URDF states


@pytest.mark.slow
def test_meshes_of_a_package_with_an_empty_name_are_no_absolute_paths(tmp_path: Path, capsys) -> None:
    """Talos writes package:///example-robot-data/…: each of sixty meshes was refused."""
    shutil.copy(stock("talos_data/robots/talos_full_v2.urdf"), tmp_path / "talos.urdf")
    assert main(["motion", "robot", str(tmp_path / "talos.urdf")]) == 0
    assert yaml.safe_load((tmp_path / "robot.yaml").read_text())["name"] == "talos"
    capsys.readouterr()


def test_meshes_beside_a_folder_are_opened_for_ones_own_files_alone(tmp_path: Path) -> None:
    """A service that looked beside a study's folder would hand out another's."""
    inner = tmp_path / "a" / "urdf"
    inner.mkdir(parents=True)
    for place in (tmp_path / "a" / "meshes", tmp_path / "b"):
        place.mkdir()
        (place / "link.stl").write_bytes(place.name.encode())
    name = "package://a/meshes/link.stl"
    assert mesh_opener(inner)(name) is None
    opened = mesh_opener(inner, beside=True)
    assert opened(name) == b"meshes"
    assert opened("package://elsewhere/meshes/link.stl") == b"meshes"
    assert opened("package://elsewhere/other/link.stl") is None
    assert opened("link.stl") is None
    assert opened("package:///b/link.stl") == b"b"


@pytest.mark.parametrize("folder", ["../meshes", "file:///opt/ros/share/ur_description/meshes"])
def test_a_robot_whose_meshes_lie_upwards_is_drafted_with_or_without_them(folder: str, tmp_path: Path, capsys) -> None:
    """`../meshes/…` from the folder of the URDF, as Vega's and Robotiq's; as xacro writes those of its own machine."""
    urdf = package("ur_description/urdf/ur5_robot.urdf", tmp_path)
    text = re.sub(r"package://[^\"]*?/meshes", folder, urdf.read_text())
    assert text.count(f"{folder}/") > 6
    urdf.write_text(text)
    assert main(["motion", "robot", str(urdf)]) == 0
    assert load_motion_robot(urdf.with_name("robot.yaml"), beside=True).shapeless == ()
    assert "base_link" in load_motion_robot(urdf.with_name("robot.yaml")).shapeless
    capsys.readouterr()
    table, alone = tmp_path / "still.csv", tmp_path / "alone"
    alone.mkdir()
    (alone / "ur5.urdf").write_text(text.replace(folder, "../../../nowhere"))
    assert main(["motion", "robot", str(alone / "ur5.urdf")]) == 0
    joints = load_motion_robot(alone / "robot.yaml").joints
    rows = [",".join(f"{cell:g}" for cell in (t / 100, *[-1.0] * 6)) for t in range(100)]
    table.write_text("\n".join([",".join(["t", *(f"q.{name}" for name in joints)]), *rows]))
    main(["motion", "check", str(table), "--robot", str(alone / "robot.yaml")])
    said = capsys.readouterr().out
    assert "collisions of" in said
    assert "their meshes are not there" in said


def test_a_study_opens_no_mesh_outside_it_however_far_up_its_name_leads(tmp_path: Path) -> None:
    urdf = package("ur_description/urdf/ur5_robot.urdf", tmp_path)
    urdf.write_text(re.sub(r"package://[^\"]*?/meshes", "../meshes", urdf.read_text()))
    opened = mesh_opener(urdf.parent)
    names = set(re.findall(r'filename="([^"]+stl)"', urdf.read_text()))
    assert names
    assert all((urdf.parent / name).is_file() for name in names)
    assert [name for name in names if opened(name) is not None] == []


@pytest.mark.slow
def test_arms_that_lie_against_the_body_at_home_are_taken_off_it(tmp_path: Path) -> None:
    """iCub's hang against its hips: forearms and hands were never looked at."""
    robot = load_motion_robot(sample_folder(tmp_path))
    assert robot.home is not None
    assert arms_aside(robot, 0.01) == {}
    roll, home = robot.joints.index("l_shoulder_roll"), robot.home.copy()
    hidden = [pair for pair in Pairs(robot, 0.01).left_out if "l_hand" in pair]
    for angle in np.arange(0.0, 1.2, 0.05):
        home[robot.base + roll] = robot.home[robot.base + roll] - angle
        against = replace(robot, home=home.copy())
        if [pair for pair in Pairs(against, 0.01).left_out if "l_hand" in pair] != hidden:
            break
    found = arms_aside(against, 0.01)
    assert next(iter(found)).startswith("l_shoulder")
    for name, value in found.items():
        home[robot.base + robot.joints.index(name)] = value
    assert [pair for pair in Pairs(replace(robot, home=home), 0.01).left_out if "l_hand" in pair] == hidden


@pytest.mark.slow
def test_a_draft_tells_what_its_home_hides_and_what_home_cannot_bear(tmp_path: Path, capsys) -> None:
    """Pairs that are near at home are never looked at: seen in a plan's small print alone."""
    shutil.copy(stock("baxter_description/urdf/baxter.urdf"), tmp_path / "baxter.urdf")
    assert main(["motion", "robot", str(tmp_path / "baxter.urdf")]) == 0
    said = capsys.readouterr().out
    assert "right_upper_elbow_visual and right_lower_elbow" in said
    assert "nearer than 10 mm at home, and so never looked at" in said
    assert main(["motion", "excite", "--robot", str(tmp_path / "robot.yaml")]) != 0
    assert re.search(r"torque of right_s1: 1\d\d % of it", capsys.readouterr().err)  # arms straight out sideways


def test_a_robot_of_which_nothing_is_logged_is_not_excited(tmp_path: Path, capsys) -> None:
    """After the whole search it was told that no joint moves steadily in any log."""
    path = sample_folder(tmp_path)
    content = yaml.safe_load(path.read_text())
    content["joints"] = [{"name": each["name"], "actuation": "none"} for each in content["joints"]]
    content.pop("ft_sensors", None)
    path.write_text(yaml.safe_dump(content))
    assert main(["motion", "excite", "--robot", str(path)]) == 2
    said = capsys.readouterr()
    assert "nothing can be identified" in said.err
    assert "actuation: torque" in said.err
    assert "search" not in said.err


LINK = (
    '<link name="{}"><inertial><mass value="1"/><inertia ixx=".1" iyy=".1" izz=".1" ixy="0" ixz="0" iyz="0"/>'
    "</inertial></link>"
)
JOINT = '<joint name="{0}{1}" type="revolute"><parent link="{0}"/><child link="{1}"/><origin xyz="0 0 .3"/>{2}</joint>'


@pytest.mark.parametrize("more", ["", "<limit/>", "<mimic/>", '<dynamics damping="x"/>', '<calibration rising="x"/>'])
@pytest.mark.parametrize("encoding", ["UTF-8", "UTF-16", "ISO-8859-1"])
def test_a_urdf_as_others_write_it_is_drafted(tmp_path: Path, capsys, more: str, encoding: str) -> None:
    """Whatever the check lets pass: the draft read the raw text anew, and ended with a traceback."""
    links, joints = "".join(map(LINK.format, "abc")), JOINT.format("a", "b", "") + JOINT.format("b", "c", more)
    text = f"<?xml version='1.0' encoding='{encoding}'?><robot>{links}{joints}<drake:x/><!-- Größe --></robot>"
    (tmp_path / "r.urdf").write_bytes(text.encode(encoding))
    assert main(["motion", "robot", str(tmp_path / "r.urdf")]) == 0
    said = capsys.readouterr()
    assert "3.0 kg" in said.out
    assert not said.err


def test_a_draft_tells_what_looks_like_a_slip_in_the_urdf(tmp_path: Path, capsys) -> None:
    light = LINK.replace('"1"', '"1000"')
    links = "".join(map(light.format, "ab")) + '<link name="c"/>'
    urdf = f"<robot>{links}{JOINT.format('a', 'b', '')}{JOINT.format('b', 'c', '')}</robot>"
    (tmp_path / "r.urdf").write_text(urdf)
    for command in (["motion", "robot"], ["robot"]):
        assert main([*command, str(tmp_path / "r.urdf")]) == 0
        assert "nothing that weighs hangs on bc" in capsys.readouterr().out
