"""Robots that a preset knows: they stand on their soles, touch nothing at home, and bend."""

from __future__ import annotations

import gzip
import re
import shutil
from dataclasses import replace
from importlib.metadata import distribution
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
import yaml
from tests.motion.robots import STOCK, sample_folder

from exogauge.cli import main
from exogauge.criteria.motion_plan import USUAL
from exogauge.errors import BadMotion
from exogauge.motion.files import open_motion
from exogauge.motion.person import person_of
from exogauge.motion.plan.at_rest import at_home
from exogauge.motion.plan.retarget import ask
from exogauge.motion.plan.solve import Round, plan
from exogauge.motion.robot_draft import draft_of
from exogauge.motion.robot_file import load_motion_robot
from exogauge.robots.moving.stance import Standing
from exogauge.robots.moving.touching import Pairs
from exogauge.synthetic.urdf import robot_urdf

SHARED = Path(__file__).parents[3] / "shared" / "data"
CAPTURES = SHARED / "cmu_mocap_bend_twist"
URDF = {
    "talos": Path(str(distribution("example-robot-data").locate_file(f"{STOCK}/talos_data/robots/talos_reduced.urdf"))),
    "jvrc1": SHARED / "model_jvrc1" / "jvrc_description" / "urdf" / "jvrc1.urdf",
    "ergocub": SHARED / "model_ergocub_urdf" / "ergoCubSN001.urdf",
}
MASS = {"talos": 90.3, "jvrc1": 62.4, "ergocub": 56.7}  # [kg] as their makers and the models' descriptions say
TORSO = {"talos": 2, "jvrc1": 3, "ergocub": 3}


def preset(name: str, folder: Path) -> Path:
    """robot.yaml as the command writes it."""
    if not URDF[name].is_file():
        pytest.skip(f"the model of {name} is not there: {URDF[name].name}")
    shutil.copy(URDF[name], folder / "robot.urdf")
    assert main(["motion", "robot", str(folder / "robot.urdf")]) == 0
    return folder / "robot.yaml"


@pytest.mark.slow
@pytest.mark.parametrize("name", list(URDF))
def test_a_known_robot_stands_and_touches_nothing(name: str, tmp_path: Path, capsys) -> None:
    robot = load_motion_robot(preset(name, tmp_path))
    assert f"robot                    {name}" in capsys.readouterr().out
    assert robot.mass == pytest.approx(MASS[name], abs=0.1)
    assert len(robot.torso) == TORSO[name]
    pin.forwardKinematics(robot.model, robot.data, robot.home)
    for sole, side in zip(robot.soles, (1.0, -1.0), strict=True):
        at = pin.updateFramePlacement(robot.model, robot.data, robot.frame(sole.link))
        corners = sole.outline @ at.rotation.T + at.translation
        assert np.abs(corners[:, 2]).max() < 1e-6  # flat on the floor, though the knees are bent
        assert (side * corners[:, 1] > 0.0).all()
    whole = pin.centerOfMass(robot.model, robot.data, robot.home)
    assert corners[:, 0].min() + 0.02 < whole[0] < corners[:, 0].max() - 0.02
    pairs = Pairs(robot, 0.01)
    assert robot.shapeless == ()
    assert len(pairs.names) > 90
    arms = ("arm", "ELBOW", "WRIST", "SHOULDER", "wrist")
    for pair in pairs.left_out:  # what lies on each other by construction: never two limbs, nor a limb and the trunk
        assert sum(any(part in link for part in arms) for link in pair) != 1


G1 = "g1_description/urdf/g1_29dof_rev_1_0.urdf"


def stock(name: str, folder: Path) -> Path:
    """A maker's URDF, alone in a folder."""
    shutil.copy(Path(str(distribution("example-robot-data").locate_file(f"{STOCK}/{name}"))), folder / "robot.urdf")
    return folder / "robot.urdf"


def test_a_robot_that_no_preset_knows_is_drafted_and_stands(tmp_path: Path, capsys) -> None:
    """Unitree's G1, whose feet are four balls each."""
    assert main(["motion", "robot", str(stock(G1, tmp_path))]) == 0
    assert "left first; so it faces along the x of pelvis" in capsys.readouterr().out
    robot = load_motion_robot(tmp_path / "robot.yaml")
    assert [robot.joints[k] for k in robot.torso] == ["waist_yaw_joint", "waist_roll_joint", "waist_pitch_joint"]
    assert robot.segments["l_forearm"] == "left_elbow_link"
    assert [robot.joints[k] for k in robot.beyond("r_forearm")] == [f"right_wrist_{way}_joint" for way in
                                                                    ("roll", "pitch", "yaw")]  # fmt: skip
    pin.forwardKinematics(robot.model, robot.data, robot.home)
    for sole, side in zip(robot.soles, (1.0, -1.0), strict=True):
        at = pin.updateFramePlacement(robot.model, robot.data, robot.frame(sole.link))
        corners = sole.outline @ at.rotation.T + at.translation
        assert np.abs(corners[:, 2]).max() < 1e-3
        assert sole.axes[:, 2] == pytest.approx([0, 0, 1])
        assert np.ptp(corners, axis=0)[:2] == pytest.approx([0.18, 0.07], abs=1e-3)
        assert (side * corners[:, 1] > 0.0).all()
    knee = robot.data.oMi[robot.model.getJointId("left_knee_joint")].translation
    assert knee[0] > corners[:, 0].mean()
    assert not at_home(robot, USUAL).lacks


def test_a_draft_says_what_the_urdf_does_not(tmp_path: Path, capsys) -> None:
    """iCub faces against its root's x, and its feet are meshes that are not there; left is left all the same."""
    assert main(["motion", "robot", str(stock("icub_description/robots/icub_reduced.urdf", tmp_path))]) == 1
    said = capsys.readouterr().out
    assert "faces against the x of base_link" in said
    assert "# ! soles: the feet have no shape that can be read" in said
    content = yaml.safe_load((tmp_path / "robot.yaml").read_text())
    assert "soles" not in content
    assert (content["human_map"]["l_hand"], content["human_map"]["thorax"]) == ("l_hand", "chest")
    assert content["home"]["l_knee"] == pytest.approx(content["home"]["r_knee"])
    assert content["home"]["l_knee"] < -0.5


def test_legs_whose_limits_let_no_knee_go_ahead_are_told(tmp_path: Path, capsys) -> None:
    """A teaching model: the ankles of its left leg have the limits of knees."""
    urdf = stock("simple_humanoid_description/urdf/simple_humanoid.urdf", tmp_path)
    assert main(["motion", "robot", str(urdf)]) == 1
    told = capsys.readouterr().out
    for side in "LR":  # what it takes, what the file says, and where to say otherwise
        assert re.search(rf"{side}LEG_ANKLE_P takes -0\.3\d rad, its limit is 0 to 2\.618", told)
    assert "correct its <limit> in the URDF" in told
    assert not {"LLEG_HIP_P", "RLEG_HIP_P"} & set(yaml.safe_load((tmp_path / "robot.yaml").read_text())["home"])


HUMAN = "human_description/robots/human.urdf"


@pytest.mark.parametrize("rpy", ["", "1.570796 0 0", "3.141593 0 0"])
def test_a_robot_that_does_not_stand_along_z_is_refused_with_the_joint_that_turns_it(
    rpy: str, tmp_path: Path, capsys
) -> None:
    """A human with y up, as is, along z and along -y: it was told to have no elbow and knees without room."""
    urdf = stock(HUMAN, tmp_path)
    if rpy:
        turned = (f'<link name="u"/><joint name="j" type="fixed"><parent link="u"/><child link="middle_pelvis"/>'
                  f'<origin rpy="{rpy}"/></joint>')  # fmt: skip
        urdf.write_text(urdf.read_text().replace('<link name="middle_pelvis">', turned + '<link name="middle_pelvis">'))
    code = main(["motion", "robot", str(urdf)])
    said = capsys.readouterr()
    if rpy.startswith("1.57"):
        assert code == 1  # its feet have no shape
        content = (tmp_path / "robot.yaml").read_text()
        assert content.count("# !") == 1
        assert "l_hand: left_hand" in content
        assert "left_knee_Z: 0.69" in content
        return
    assert code == 2
    joint = re.search(r"<link name=\"upright\"/> .*</joint>", said.err)
    assert joint is not None
    urdf.write_text(urdf.read_text().replace("</robot>", joint.group() + "</robot>"))
    assert main(["motion", "robot", str(urdf)]) == 1
    assert "left_knee_Z: 0.69" in (tmp_path / "robot.yaml").read_text()


def test_a_root_link_may_be_called_base_and_a_foot_as_its_joint(tmp_path: Path) -> None:
    """A frame of the planner's own is called base; names of links and joints may be alike."""
    folder = sample_folder(tmp_path).parent
    urdf, file = (folder / "robot.urdf").read_text(), (folder / "robot.yaml").read_text()
    for link, other in (("BODY", "base"), ("l_foot", "l_ankle_roll")):
        assert f'link name="{link}"' in urdf
        urdf = re.sub(rf'(link(?: name)?=)"{link}"', rf'\1"{other}"', urdf)
        file = re.sub(rf"\b{link}\b(?!:)", other, file)
    (folder / "robot.urdf").write_text(urdf)
    (folder / "robot.yaml").write_text(file)
    robot = load_motion_robot(folder / "robot.yaml")
    assert [robot.joints[k] for k in robot.torso] == ["torso_yaw", "torso_pitch"]
    assert len(Standing(robot).legs) == 2
    assert not at_home(robot, USUAL).lacks


def test_feet_and_elbows_are_found_by_their_short_names(tmp_path: Path) -> None:
    """ARMAR4's end in leg_ank2_r0 and bend at arm_elb1_joint_r0: it was bolted down."""
    urdf = robot_urdf()
    for side, short in (("l", "r0"), ("r", "r1")):
        urdf = urdf.replace(f'"{side}_foot"', f'"leg_ank2_{short}"').replace(f"{side}_elbow", f"arm_elb1_{short}")
        urdf = urdf.replace(f'"{side}_sole"', f'"under_{short}"')
    assert "elbow" not in urdf
    content, told = draft_of(urdf.encode(), "robot.urdf", tmp_path)
    assert [sole["link"] for sole in content["soles"]] == ["leg_ank2_r0", "leg_ank2_r1"]  # by where they are
    assert content["human_map"]["thorax"] == "chest"
    assert not [line for line in told if line.startswith("# !")]


@pytest.mark.slow
def test_a_first_round_that_the_solver_gives_up_by_round_off_is_taken_again_nearer_to_where_it_began(
    tmp_path: Path,
) -> None:
    """JVRC-1, planned once more with feet that share evenly: "no motion keeps the feet where they stand", and the plan
    that there was already was lost too."""
    robot = load_motion_robot(preset("jvrc1", tmp_path))
    if not CAPTURES.is_dir():
        pytest.skip(f"the capture is not there: {CAPTURES.name}")
    (tmp_path / "02_06.amc").write_bytes(gzip.decompress((CAPTURES / "02_06.amc.gz").read_bytes()))
    person = person_of(open_motion(tmp_path / "02_06.amc", skeleton=CAPTURES / "02.asf")).cut(0.0, 5.0)
    strict = replace(USUAL, wrench=0.3, kept=0.95, margin_m=0.03)
    robot = replace(robot, limits=replace(robot.limits, jerk=0.5 * robot.jerk))
    rounds = list[Round]()
    with pytest.raises(BadMotion) as ended:  # once its first stretch is there
        plan(robot, ask(robot, person)[0], strict, rounds.append, lambda made: True)
    assert ended.value.faults[0].rule == "not_kept"
    assert rounds[-1].off < 1.0
