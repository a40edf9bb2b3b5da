"""Robots that nobody here made: what is exported for them is judged by MuJoCo, sample by sample, as the URDF has it."""

from __future__ import annotations

import gzip
import shutil
from importlib.metadata import distribution
from pathlib import Path

import numpy as np
import pytest
import yaml
from tests.motion.by_mujoco import ByMuJoCo, Shapes, bare, felt, limits
from tests.motion.robots import STOCK

from exogauge.cli import main
from exogauge.criteria.motion_plan import USUAL
from exogauge.motion.plan.written import read_written
from exogauge.motion.robot_file import load_motion_robot
from exogauge.robots.moving.touching import Pairs

SHARED = Path(__file__).parents[3] / "shared" / "data"
ROBOTS = Path(str(distribution("example-robot-data").locate_file(STOCK)))
SOLE = [[0.16, -0.08, -0.04], [-0.05, -0.08, -0.04], [-0.05, -0.08, 0.04], [0.16, -0.08, 0.04]]  # of its foot's mesh
UPRIGHT = ('<link name="upright"/><joint name="to_upright" type="fixed"><parent link="upright"/>'
           '<child link="middle_pelvis"/><origin rpy="1.570796 0 0"/></joint></robot>')  # fmt: skip


def there(path: Path) -> Path:
    """Of ../shared; unpacked by whoever reads it."""
    if not path.exists():
        pytest.skip(f"{path.name} is not beside the repository (../shared/data/{path.parent.name})")
    return path


def g1(folder: Path) -> Path:
    """With its meshes, as drafted."""
    shutil.copy(ROBOTS / "g1_description/urdf/g1_29dof_rev_1_0.urdf", folder / "robot.urdf")
    shutil.copytree(ROBOTS / "g1_description/meshes", folder / "meshes")
    assert main(["motion", "robot", str(folder / "robot.urdf")]) == 0
    return folder / "robot.yaml"


def jvrc1(folder: Path) -> Path:
    """As its preset has it."""
    shutil.copy(there(SHARED / "model_jvrc1") / "jvrc_description/urdf/jvrc1.urdf", folder / "robot.urdf")
    assert main(["motion", "robot", str(folder / "robot.urdf")]) == 0
    return folder / "robot.yaml"


def human(folder: Path) -> Path:
    """Put upright, its soles by hand; it has no shapes."""
    urdf = (ROBOTS / "human_description/robots/human.urdf").read_text()
    (folder / "robot.urdf").write_text(urdf.replace("</robot>", UPRIGHT))
    assert main(["motion", "robot", str(folder / "robot.urdf")]) == 1
    whole = yaml.safe_load((folder / "robot.yaml").read_text())
    whole["soles"] = [{"link": f"{side}_foot", "outline": SOLE} for side in ("left", "right")]
    (folder / "robot.yaml").write_text(yaml.safe_dump(whole))
    return folder / "robot.yaml"


def squat(folder: Path) -> list[str]:
    (folder / "squat.c3d").write_bytes(gzip.decompress(there(SHARED / "mocap_c3d/squat.c3d.gz").read_bytes()))
    return [str(folder / "squat.c3d")]


def bend(folder: Path) -> list[str]:
    packed = there(SHARED / "cmu_mocap_bend_twist/02_06.amc.gz")
    (folder / "02_06.amc").write_bytes(gzip.decompress(packed.read_bytes()))
    return [str(folder / "02_06.amc"), "--skeleton", str(packed.with_name("02.asf"))]


def knee(folder: Path) -> list[str]:
    packed = there(SHARED / "cmu_mocap_bend_twist/13_29.amc.gz")
    (folder / "13_29.amc").write_bytes(gzip.decompress(packed.read_bytes()))
    return [str(folder / "13_29.amc"), "--skeleton", str(packed.with_name("02.asf"))]


@pytest.mark.slow
@pytest.mark.thorough
@pytest.mark.parametrize("made", [jvrc1, g1])
def test_a_knee_is_raised_at_its_own_speed_within_every_bound_by_its_table_too(made, tmp_path: Path) -> None:
    """JVRC-1's plan kept every bound, and its table asked 104 % of a knee's torque: told, and written."""
    file, table = made(tmp_path), tmp_path / "plan.csv"
    given = ["--robot", str(file), "--from", "24.6", "--to", "26.2", "--no-what-would-do", "--out", str(table)]
    assert main(["motion", "retarget", *knee(tmp_path), *given]) == 0
    robot = load_motion_robot(file, beside=True)
    urdf, _ = felt(tmp_path)
    said, legs = limits(urdf, robot.joints), np.concatenate([robot.leg(foot) for foot in (0, 1)]) - robot.base
    for rate in ("200", "1000"):
        assert main(["motion", "check", str(table), "--robot", str(file), "--rate", rate]) == 0
    out = tmp_path / "samples.npz"
    command = ["motion", "export", str(table), "--robot", str(file), "--rate", "1000", "--format", "mujoco"]
    assert main([*command, "--out", str(out)]) == 0
    with np.load(out) as samples:
        seen = ByMuJoCo.of_file(robot, samples, bare(urdf))
    assert (np.abs(seen.evenly[:, legs]) <= 1.005 * said["effort"][legs]).all()  # accelerations are means of 1 ms,
    assert seen.inside.min() >= USUAL.inside_m - 0.0015  # which took the pressure 1.5 mm aside where a knee is raised


@pytest.mark.slow
@pytest.mark.parametrize(
    ("made", "capture", "until"),
    [
        (g1, squat, 1.0),
        pytest.param(g1, squat, 4.0, marks=pytest.mark.thorough),
        pytest.param(jvrc1, bend, 5.0, marks=pytest.mark.thorough),
        pytest.param(human, bend, 5.0, marks=pytest.mark.thorough),
        pytest.param(g1, bend, 5.0, marks=pytest.mark.thorough),
        pytest.param(jvrc1, squat, 4.0, marks=pytest.mark.thorough),
    ],
)
def test_what_is_exported_for_a_robot_of_others_keeps_its_bounds_by_mujoco(
    made, capture, until: float, tmp_path: Path
) -> None:
    file, table = made(tmp_path), tmp_path / "plan.csv"
    given = ["--robot", str(file), "--to", f"{until:g}", "--no-what-would-do", "--out", str(table)]
    assert main(["motion", "retarget", *capture(tmp_path), *given]) == 0
    robot = load_motion_robot(file, beside=True)
    urdf, assets = felt(tmp_path)
    said, legs = limits(urdf, robot.joints), np.concatenate([robot.leg(foot) for foot in (0, 1)]) - robot.base
    upper = np.setdiff1d(np.arange(len(robot.joints)), legs)
    for rate in ("200", "1000"):
        assert main(["motion", "check", str(table), "--robot", str(file), "--rate", rate]) == 0
        out = tmp_path / f"at_{rate}.npz"
        command = ["motion", "export", str(table), "--robot", str(file), "--rate", rate, "--format", "mujoco"]
        assert main([*command, "--out", str(out)]) == 0
        with np.load(out) as samples:
            seen = ByMuJoCo.of_file(robot, samples, bare(urdf))
        assert seen.inside.min() >= USUAL.inside_m
        assert seen.rubbed.max() <= USUAL.friction
        assert seen.carried.min() >= USUAL.least_weight * robot.weight
        assert np.linalg.norm(seen.feet - seen.feet[0], axis=2).max() <= USUAL.feet_m
        assert seen.turned.max() <= USUAL.feet_rad
        assert np.maximum(said["lower"] - seen.angle, seen.angle - said["upper"]).max() <= USUAL.beyond_rad
        assert (np.abs(seen.speed) <= said["velocity"]).all()
        assert (np.abs(seen.torque[:, upper]) <= said["effort"][upper]).all()
        assert (np.abs(seen.evenly[:, legs]) <= said["effort"][legs]).all()
    if not robot.shapes:
        return
    near = Shapes(robot, urdf, assets).nearer_than(USUAL.clearance_m - 1e-4, read_written(robot, table).q)
    assert not near & {frozenset(pair) for pair in Pairs(robot, USUAL.clearance_m).names}
