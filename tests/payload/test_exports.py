"""Every export says the body that was identified: loaded back where a loader exists, else read by its definition."""

from __future__ import annotations

import csv
import io
import json
import re
import xml.etree.ElementTree as ET
from pathlib import Path

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from exogauge.cli import main
from exogauge.errors import BadInput
from exogauge.payload.dynamics import NAMES, ZERO_NAMES
from exogauge.payload.exports.body import TENSOR, body_of, in_flange
from exogauge.payload.exports.formats import FORMATS, export, read_results
from exogauge.payload.results import DynamicResults, MissingResults, PayloadResults, Value

Array = NDArray[np.float64]
CENTRAL = np.array([[0.31, 0.02, -0.03], [0.02, 0.22, 0.05], [-0.03, 0.05, 0.17]])
BODY = pin.Inertia(7.3, np.array([0.021, -0.043, 0.118]), CENTRAL)
FLANGE = (0.01, -0.02, 0.045, 10.0, -20.0, 130.0)
NUMBER = r"[-+]?\d+\.?\d*(?:[eE][-+]?\d+)?"


NOTHING = MissingResults(
    verdict="none", reason=None, found=[], suspected=[], left={}, in_the_model=False, without=[], candidates=9,
    said="Nothing is missing.",
)  # fmt: skip


def found(
    body: pin.Inertia = BODY, *, identified: bool = True, covariance: Array | None = None, **more: object
) -> PayloadResults:
    """Results in which this body was identified, about the sensor's origin as they are told."""
    at_origin = body.matrix()[3:, 3:]
    h = body.mass * body.lever
    tensor = [at_origin["xyz".index(n[1]), "xyz".index(n[2])] for n in TENSOR]
    x = [body.mass, *h, *tensor, *(0.0,) * 6]
    C = 1e-8 * np.eye(16) if covariance is None else covariance
    values = [
        Value(name=n, unit="", value=float(v), std=float(s), low=0, high=0, identified=identified or n not in TENSOR)
        for n, v, s in zip((*NAMES, *ZERO_NAMES), x, np.sqrt(np.diag(C)), strict=True)
    ]
    dynamic = DynamicResults(
        method="ls", mu=None, mu_std=None, values=values, covariance=C.tolist(), by_method={}, recursion={},
        least_squares_would_do=None, mass_from_motion_alone=values[0], possible=None, cost_of_possible=0.0,
        residual_rms=[], jerk_density=[], left_out_s=[],
    )  # fmt: skip
    given = {"name": "Door -- <of> cell\n4", "frame": "axes and origin of the sensor (ft)"} | more
    return PayloadResults(
        version=1, exogauge="0", sees="payload_on_sensor", static=None, dynamic=dynamic, tests={}, contacts={},
        contact_threshold_n={}, imu=None, mass_error_kg=None, warnings=[], **({"missing": NOTHING} | given),
    )  # fmt: skip


def test_urdf_is_loaded_back() -> None:
    model = pin.buildModelFromXML(export(found(), "urdf"), pin.JointModelFreeFlyer())
    np.testing.assert_allclose(model.inertias[1].matrix(), BODY.matrix(), atol=1e-9)


def test_mjcf_is_loaded_back() -> None:
    model = mujoco.MjModel.from_xml_string(export(found(), "mjcf"))
    R = Rotation.from_quat(model.body_iquat[1], scalar_first=True).as_matrix()
    loaded = pin.Inertia(model.body_mass[1], model.body_ipos[1], R @ np.diag(model.body_inertia[1]) @ R.T)
    np.testing.assert_allclose(loaded.matrix(), BODY.matrix(), atol=1e-9)


def test_sdf_is_read_as_its_specification_says() -> None:
    """pinocchio is built without a reader of SDF; pose x y z roll pitch yaw, tensor about it."""
    inertial = ET.fromstring(export(found(), "sdf")).find("model/link/inertial")
    assert inertial is not None
    pose = [float(x) for x in (inertial.findtext("pose") or "").split()]
    six = {each.tag: float(each.text or "") for each in inertial.find("inertia") or ()}
    tensor = np.array([[six["i" + "".join(sorted(a + b))] for b in "xyz"] for a in "xyz"])
    read = pin.Inertia(float(inertial.findtext("mass") or ""), np.array(pose[:3]), tensor)
    np.testing.assert_allclose(read.matrix(), BODY.matrix(), atol=1e-9)
    assert pose[3:] == [0.0, 0.0, 0.0]


def test_set_target_payload_is_read_as_its_manual_says() -> None:
    line = export(found(), "ur", FLANGE).splitlines()[-1]
    m, *rest = [float(x) for x in re.findall(NUMBER, line)]
    assert re.fullmatch(rf"set_target_payload\({NUMBER}, \[[^\]]+\], \[[^\]]+\]\)", line)
    xx, yy, zz, xy, xz, yz = rest[3:]
    read = pin.Inertia(m, np.array(rest[:3]), np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]))
    np.testing.assert_allclose(read.matrix(), placed().matrix(), atol=1e-8)


def test_load_data_is_read_as_its_manual_says() -> None:
    """mm and degrees; A about Z, then B about the new Y, then C about the new X; J about these axes."""
    line = export(found(), "kuka", FLANGE).splitlines()[-1]
    m, x, y, z, A, B, C, *J = [float(v) for v in re.findall(rf"[A-Z] ({NUMBER})", line)]
    assert line.startswith("LOAD_DATA[1]={M ")
    R = Rotation.from_euler("ZYX", [A, B, C], degrees=True).as_matrix()
    read = pin.Inertia(m, 1e-3 * np.array([x, y, z]), R @ np.diag(J) @ R.T)
    np.testing.assert_allclose(read.matrix(), placed().matrix(), atol=2e-8)


def test_loaddata_is_read_as_its_manual_says() -> None:
    line = export(found(), "abb", FLANGE).splitlines()[-1]
    m, x, y, z, q1, q2, q3, q4, *J = [float(v) for v in re.findall(NUMBER, line.partition(":=")[2])]
    R = Rotation.from_quat([q1, q2, q3, q4], scalar_first=True).as_matrix()
    read = pin.Inertia(m, 1e-3 * np.array([x, y, z]), R @ np.diag(J) @ R.T)
    np.testing.assert_allclose(read.matrix(), placed().matrix(), atol=2e-8)
    assert abs(np.linalg.norm([q1, q2, q3, q4]) - 1.0) < 1e-8


def placed() -> pin.Inertia:
    """The body seen from the flange, by pinocchio."""
    R = Rotation.from_euler("xyz", FLANGE[3:], degrees=True).as_matrix()
    return pin.SE3(R, np.array(FLANGE[:3])).act(BODY)


def test_the_doubt_of_centre_and_central_inertia_is_that_of_a_thousand_draws() -> None:
    rng = np.random.default_rng(1)
    root = 1e-3 * rng.standard_normal((16, 16))
    C = root @ root.T
    told = in_flange(body_of(found(covariance=C)), FLANGE)
    mean = np.array([v.value for v in found().dynamic.values])  # type: ignore[union-attr]
    R = Rotation.from_euler("xyz", FLANGE[3:], degrees=True).as_matrix()
    drawn = []
    for x in rng.multivariate_normal(mean, 1e-4 * C, 4000):
        about = np.array([[x[4], x[5], x[7]], [x[5], x[6], x[8]], [x[7], x[8], x[9]]])
        c = x[1:4] / x[0]
        central = R @ (about - x[0] * (c @ c * np.eye(3) - np.outer(c, c))) @ R.T
        drawn.append([x[0], *(R @ c), *(central["xyz".index(n[1]), "xyz".index(n[2])] for n in TENSOR)])
    np.testing.assert_allclose(1e-2 * told.std, np.std(drawn, axis=0), rtol=0.06)


def test_tables_say_unit_frame_and_doubt() -> None:
    content = json.loads(export(found(), "json"))
    assert content["frame"] == "axes and origin of the sensor (ft)"
    values = {each["name"]: each for each in content["values"]}
    assert values["Ixy"]["value"] == pytest.approx(0.02, abs=1e-12)
    assert (values["Ixy"]["unit"], values["cx"]["unit"], values["m"]["unit"]) == ("kg·m²", "m", "kg")
    rows = list(csv.DictReader(io.StringIO(export(found(), "csv"))))
    assert [row["name"] for row in rows] == ["m", "cx", "cy", "cz", *TENSOR]
    for row in rows:
        assert "sensor (ft)" in row["frame"]
        half = (float(row["high"]) - float(row["low"])) / 2
        assert half == pytest.approx(1.959964 * values[row["name"]]["std"])


@pytest.mark.parametrize("name", FORMATS)
def test_every_format_says_its_frame_and_stays_whole_with_any_name(name: str) -> None:
    text = export(found(name="--> </robot>\n evil := 1 \u2028 ] */", frame="axes of -- (\nft)"), name)
    assert "ft)" in text
    if name in ("urdf", "sdf", "mjcf"):
        ET.fromstring(text)
    if name in ("ur", "kuka", "abb"):
        assert text.isascii()
        assert len([line for line in text.splitlines() if line[0] not in "#;!"]) == 1


@pytest.mark.parametrize("name", [each for each in FORMATS if each not in ("json", "csv")])
def test_that_something_is_missing_beside_the_rigid_body_is_said_where_it_is_used(name: str) -> None:
    missing = MissingResults(
        verdict="effects",
        reason=None,
        found=[],
        suspected=[],
        left={},
        in_the_model=True,
        without=[],
        candidates=9,
        said="Missing: a delay.",
    )
    assert "a delay" in export(found(missing=missing), name)
    assert "a delay" not in export(found(missing=missing.model_copy(update={"verdict": "none"})), name)


def test_without_an_inertia_only_formats_that_allow_it_are_written() -> None:
    results = found(identified=False)
    assert export(results, "ur").splitlines()[-1].count("[") == 1
    assert export(results, "abb").splitlines()[-1].endswith("[1.000000000, 0.000000000, 0.000000000, 0.000000000], "
                                                            "0.000000000, 0.000000000, 0.000000000];")  # fmt: skip
    assert len(json.loads(export(results, "json"))["values"]) == 4
    for name in ("urdf", "sdf", "mjcf", "kuka"):
        with pytest.raises(BadInput, match="the data decide none"):
            export(results, name)


def test_no_body_has_an_inertia_that_breaks_the_triangle() -> None:
    wrong = pin.Inertia(1.0, np.zeros(3), np.diag([1.0, 1.0, 2.5]))
    for name in ("urdf", "sdf", "mjcf", "ur", "kuka", "abb"):
        with pytest.raises(BadInput, match="no body has"):
            export(found(wrong), name)


def test_what_cannot_be_exported_is_said_with_advice(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "results.json"
    file.write_text(found().model_dump_json())
    assert export(read_results(tmp_path), "csv") == export(found(), "csv")
    assert main(["payload", "export", str(file), "--format", "urdff"]) == 2
    assert "Did you mean 'urdf'?" in capsys.readouterr().err
    assert main(["payload", "export", str(file), "--format", "ur", "--flange", "0", "0", "45", "0", "0", "0"]) == 2
    assert "x y z in m" in capsys.readouterr().err
    out = tmp_path / "payload.urdf"
    assert main(["payload", "export", str(file), "--format", "urdf", "--out", str(out)]) == 0
    assert out.read_text() == export(found(), "urdf")
    file.write_text('{"version": 1}')
    assert main(["payload", "export", str(file), "--format", "ur"]) == 2
    assert "results.json of `exogauge payload run`" in capsys.readouterr().err


def test_the_controller_s_frame_is_only_asked_for_where_it_is_another_one() -> None:
    assert "must be that of the tool flange" in export(found(), "ur")
    assert "must be" not in export(found(), "ur", FLANGE)
