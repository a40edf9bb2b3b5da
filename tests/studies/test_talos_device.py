"""A back support on a robot that is not ours, from its maker's URDF alone, as docs/device.md tells to write it."""

from __future__ import annotations

import re
import sysconfig
from pathlib import Path
from xml.etree.ElementTree import fromstring

import numpy as np
import pytest
import yaml

from exogauge.cli import main
from exogauge.devices.routing import Routing
from exogauge.effects.band_laws import all_laws
from exogauge.errors import BadStudy
from exogauge.studies.intake.contract import Band, DeviceFile
from exogauge.studies.intake.device_check import DeviceCheck
from exogauge.studies.intake.device_on_robot import check_device_file

ROBOTS = Path(sysconfig.get_path("purelib")) / "cmeel.prefix/share/example-robot-data/robots"
DOCUMENT = (Path(__file__).parents[2] / "docs/device.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```(?:yaml|text)\n(.*?)```", DOCUMENT, flags=re.DOTALL)
SUIT = next(block for block in BLOCKS if "bands:" in block)
BENCH = next(block for block in BLOCKS if block.startswith("length_m"))
SIDES = {"left": 1.0, "right": -1.0}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    root = tmp_path_factory.mktemp("talos")
    (root / "talos.urdf").write_bytes((ROBOTS / "talos_data/robots/talos_reduced.urdf").read_bytes())
    (root / "suit.yaml").write_text(SUIT)
    return root


@pytest.fixture(scope="module")
def check(folder: Path) -> DeviceCheck:
    return check_device_file(folder / "suit.yaml", folder / "talos.urdf")


def test_both_bands_pull_the_trunk_back_and_their_own_thigh(check: DeviceCheck) -> None:
    for band in check.bands:
        ways = {arm.joint: arm.way for arm in band.arms}
        assert ways["torso_2_joint"] == "moves torso_2_link back"
        assert ways[f"leg_{band.name}_3_joint"] == f"moves leg_{band.name}_3_link back"
        assert not any(other in joint for joint in ways for other in SIDES if other != band.name)
    assert check.doubts == ()
    assert check.torque["torso_2_joint"] < -4.0


def test_arms_are_the_distances_of_the_bands_from_the_joints(check: DeviceCheck) -> None:
    """From the URDF by hand: torso_2_joint 0.0722 m over the base, the hip at x -0.02, z -0.27105; both about y."""

    def distance(joint: tuple[float, float], a: tuple[float, float, float], b: tuple[float, float, float]) -> float:
        e = (np.array(b) - np.array(a)) / np.linalg.norm(np.array(b) - np.array(a))
        x, z = a[0] - joint[0], a[2] - joint[1]
        return abs(x * e[2] - z * e[0])

    waist = (-0.16, 0.1, 0.0)
    for band in check.bands:
        arms = {arm.joint: abs(arm.arm) for arm in band.arms}
        assert arms["torso_2_joint"] == pytest.approx(distance((0.0, 0.0722), (-0.15, 0.1, 0.3722), waist), abs=1e-6)
        thigh = (-0.12, 0.085, -0.27105 - 0.25)
        assert arms[f"leg_{band.name}_3_joint"] == pytest.approx(distance((-0.02, -0.27105), waist, thigh), abs=1e-6)


def test_the_bands_are_mirror_images(check: DeviceCheck) -> None:
    left, right = check.bands
    assert left.length == pytest.approx(right.length, abs=1e-9)
    tree = check.robot.tree
    pitch = [tree.joints.index(name) for name in ("torso_2_joint", "leg_left_3_joint", "leg_right_3_joint")]
    q = np.zeros((3, len(tree.joints)))
    q[:, pitch] = [[0.2, -0.3, -0.3], [0.5, -1.0, -1.0], [-0.1, 0.2, 0.2]]
    lengths = Routing(tree, check.device.bands).lengths(q)
    np.testing.assert_allclose(lengths[:, 0], lengths[:, 1], atol=1e-9)
    assert lengths[1, 0] > lengths[0, 0] > left.length > lengths[2, 0]


def test_what_a_first_try_gets_wrong_is_told_with_the_right_name(folder: Path) -> None:
    wrong = SUIT.replace("link: torso_2_link,    xyz", "link: torso_2_joint,   xyz", 1).replace(
        "base_link", "pelvis", 1
    )
    wrong = wrong.replace("leg_left_3_link", "leg_left_3").replace("stiffness_n_per_m", "stiffness")
    (folder / "wrong.yaml").write_text(wrong)
    with pytest.raises(BadStudy) as caught:
        check_device_file(folder / "wrong.yaml", folder / "talos.urdf")
    told = {fault.row: fault.advice for fault in caught.value.faults}
    assert list(told) == [7, 8, 9, 10]
    assert "'torso_2_link'" in told[7]
    assert "base_link" in told[8]
    assert "'leg_left_3_link'" in told[9]
    assert "'stiffness_n_per_m'" in told[10]


def test_a_forgotten_sign_is_doubted(folder: Path) -> None:
    (folder / "sign.yaml").write_text(SUIT.replace("[-0.16, -0.10,  0.00]", "[-0.16,  0.10,  0.00]"))
    (doubt,) = check_device_file(folder / "sign.yaml", folder / "talos.urdf").doubts
    assert doubt.row == 14
    assert "mirror images" in doubt.advice


def test_the_documents_commands_work(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    robot = ["--robot", str(folder / "talos.urdf")]
    assert main(["device", *robot, "--picture", str(folder / "links.svg")]) == 0
    assert "leg_left_3_joint" in capsys.readouterr().out
    assert main(["device", str(folder / "suit.yaml"), *robot, "--picture", str(folder / "bands.svg")]) == 0
    assert "negative angles: moves torso_2_link back" in capsys.readouterr().out
    assert fromstring((folder / "bands.svg").read_text()).tag.endswith("svg")


def test_a_place_seen_from_the_base_becomes_a_via_point(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    robot = ["device", "--robot", str(folder / "talos.urdf")]
    assert main([*robot, "--place", "torso_2_link", "-0.15", "0.10", "0.372"]) == 0
    told = capsys.readouterr().out.strip()
    assert told == "{link: torso_2_link, xyz: [-0.15, 0.1, 0.2998]}"
    assert told in DOCUMENT
    assert main([*robot, "--place", "imu_link", "0.049", "0.2", "0.15"]) == 0  # its x points left
    point = yaml.safe_load(capsys.readouterr().out)
    assert point["xyz"] == pytest.approx([0.2, 0.0, 0.0], abs=1e-3)
    assert main([*robot, "--place", "torso_2_link", "a", "b", "c"]) == 2
    assert main([*robot, "--place", "torso_3_link", "0", "0", "0"]) == 2
    assert "Did you mean 'torso_2_link'" in capsys.readouterr().err


def test_the_documents_bench_test_belongs_to_its_band(folder: Path) -> None:
    (folder / "bench.csv").write_text(BENCH)
    (folder / "bench.yaml").write_text(
        SUIT.replace("    group: back\n", "    group: back\n    bench: {file: bench.csv}\n")
    )
    check = check_device_file(folder / "bench.yaml", folder / "talos.urdf")
    assert check.device.bands[1].bench is not None
    assert check.doubts == ()


def test_the_document_names_every_key_and_every_law_with_its_values() -> None:
    for key in (*Band.model_fields, *DeviceFile.model_fields):
        assert re.search(rf"\b{key}\b", DOCUMENT), key
    rows = {cells[1].strip(" `"): cells[2] for line in DOCUMENT.splitlines() if len(cells := line.split("|")) == 5}
    for name, law in all_laws().items():
        for quantity in law.values:
            assert f"`{quantity.name}`" in rows[name]
