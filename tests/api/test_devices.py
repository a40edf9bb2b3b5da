"""Devices over HTTP: checked against a robot in a child process, versioned, worn in studies put together from parts."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator
from typing import Any

import pytest
import yaml
from fastapi.testclient import TestClient

from exogauge.api.app import create_app
from exogauge.effects.band_laws import all_laws, check_values
from exogauge.errors import BadInput
from exogauge.settings import Settings

V1 = "/api/v1"
NOBODY = "00000000-0000-4000-8000-000000000000"
DEVICE = b"""version: 1
name: Elbow strap
bands:
  - name: front
    group: A
    via_points:
      - {link: base, xyz: [0.05, 0, 0]}
      - {link: arm, xyz: [0.05, 0, 0.1]}
    stiffness_n_per_m: 200
    natural_length_m: 0.25
    bench: {file: bench/front.csv}
  - name: back
    via_points:
      - {link: base, xyz: [-0.05, 0, 0]}
      - {link: arm, xyz: [-0.05, 0, 0.1]}
    stiffness_n_per_m: 100
    natural_length_m: 2.0
"""
BENCH = b"length_m,force_n\n0.25,0\n0.30,10\n0.35,20\n"
FILES = {"device.yaml": DEVICE, "bench/front.csv": BENCH}
on_sqlite = pytest.mark.parametrize("database_url", ["sqlite"], indirect=True)


@pytest.fixture
def robot(client: TestClient, robot_files: dict[str, bytes], as_form: Callable[..., Any]) -> str:
    """The id of a stored robot that was checked for real."""
    answer = client.post(f"{V1}/robots", files=as_form(robot_files))
    assert answer.status_code == 201, answer.text
    key: str = answer.json()["id"]
    return key


@pytest.fixture
def hand_in(client: TestClient, robot: str, as_form: Callable[..., Any]) -> Callable[..., Any]:
    """hand_in(files, more fields): the answer to a device for that robot."""

    def post(files: dict[str, bytes] | None = None, **fields: str) -> Any:
        return client.post(f"{V1}/devices", files=as_form(files or FILES), data={"robot": robot, **fields})

    return post


@pytest.mark.slow  # reads in child processes
def test_a_device_is_checked_against_its_robot_kept_and_handed_back(
    client: TestClient, robot: str, hand_in: Callable[..., Any], pack: Callable[..., bytes]
) -> None:
    answer = hand_in()
    assert answer.status_code == 201, answer.text
    device = answer.json()
    assert (device["name"], device["version"], device["robot_id"]) == ("Elbow strap", 1, robot)
    summary = device["summary"]
    assert (summary["groups"], summary["joints"], summary["robot"]) == (["A", "back"], ["elbow"], "One-joint arm")
    front = summary["bands"][0]
    assert front["length_at_zero_m"] == pytest.approx(0.3)  # from z = 0 straight up to 0.2 + 0.1
    (arm,) = front["arms_at_zero"]
    assert (arm["joint"], arm["arm_m"]) == ("elbow", pytest.approx(-0.05))  # bent forward, the band is shorter
    assert "forward" in arm["pulls"]
    assert (front["stiffness_n_per_m"], front["natural_length_m"], front["bench_points"]) == (200.0, 0.25, 3)
    assert front["tension_at_zero_n"] == pytest.approx(10.0)  # 200 N/m times 0.05 m
    assert summary["torque_at_zero_n_m"] == {"elbow": pytest.approx(0.5)}  # the other band is slack
    (doubt,) = summary["warnings"]
    assert (doubt["rule"], doubt["row"], doubt["value"]) == ("never_taut", 17, "2")
    assert client.get(f"{V1}/devices/{device['id']}").json() == device

    hashes = {file["path"]: file["sha256"] for file in device["files"]}
    assert hashes == {path: hashlib.sha256(content).hexdigest() for path, content in FILES.items()}
    for path, content in FILES.items():
        file = client.get(f"{V1}/devices/{device['id']}/files/{path}")
        assert (file.content, file.headers["etag"]) == (content, f'"{hashes[path]}"')
        assert file.headers["content-disposition"].startswith("attachment")

    packed = {"files": ("strap.zip", pack({f"my strap/{path}": content for path, content in FILES.items()}))}
    again = client.post(f"{V1}/devices", files=packed, data={"robot": robot})
    assert (again.status_code, again.json()["id"]) == (200, device["id"])


@pytest.mark.slow
@on_sqlite
def test_every_fault_of_a_device_is_told_at_its_place(client: TestClient, hand_in: Callable[..., Any]) -> None:
    changes = {
        b"link: arm, xyz: [0.05": b"link: amr, xyz: [0.05",
        b"n_per_m: 200": b"n_per_m: -200",
        b"link: base, xyz: [-0.05, 0, 0]": b"link: arm, xyz: [-0.05, 0, 0.1]",
    }
    broken = DEVICE + b"  - name: short\n    via_points: [{link: base, xyz: [0, 0, 0]}]\n"
    for old, new in changes.items():
        broken = broken.replace(old, new)
    answer = hand_in({**FILES, "device.yaml": broken})
    assert answer.status_code == 422
    assert answer.headers["content-type"] == "application/problem+json"
    errors = answer.json()["errors"]
    found = {(error["file"], error["row"], error["column"], error["value"]) for error in errors}
    assert found >= {
        ("device.yaml", 8, "bands.0.via_points.1.link", "amr"),
        ("device.yaml", 9, "bands.0.stiffness_n_per_m", "-200"),
        ("device.yaml", 15, "bands.1.via_points.1", None),
        ("device.yaml", 19, "bands.2.via_points", None),
    }
    advice = {error["column"]: error["advice"] for error in errors}
    assert "Did you mean 'arm'" in advice["bands.0.via_points.1.link"]
    assert "Leave one of them out" in advice["bands.1.via_points.1"]
    assert all(error["detail"] for error in errors)
    assert client.get(f"{V1}/devices").json()["items"] == []


@pytest.mark.slow
@on_sqlite
def test_a_bench_test_that_is_missing_or_broken_is_refused_where_it_is(hand_in: Callable[..., Any]) -> None:
    missing = hand_in({"device.yaml": DEVICE}).json()["errors"]
    assert [(error["code"], error["row"], error["value"]) for error in missing] == [
        ("missing_file", 11, "bench/front.csv")
    ]
    broken = hand_in({**FILES, "bench/front.csv": BENCH.replace(b"10", b"ten")}).json()["errors"]
    assert [(error["file"], error["row"], error["column"], error["value"]) for error in broken] == [
        ("bench/front.csv", 2, "force_n", "ten")
    ]


@pytest.mark.usefixtures("unchecked")
def test_a_device_needs_a_robot_that_is_there(client: TestClient, as_form: Callable[..., Any]) -> None:
    nameless = client.post(f"{V1}/devices", files=as_form(FILES))
    assert nameless.status_code == 422
    assert nameless.json()["errors"][0]["pointer"] == "#/robot"
    for robot in (NOBODY, "suit", "\x00"):
        assert client.post(f"{V1}/devices", files=as_form(FILES), data={"robot": robot}).status_code == 404
    assert client.get(f"{V1}/devices/{NOBODY}").status_code == 404
    assert client.get(f"{V1}/devices/{NOBODY}/files/device.yaml").status_code == 404


@pytest.mark.usefixtures("unchecked")
def test_versions_of_a_device_are_listed_by_its_name(
    client: TestClient, robot: str, hand_in: Callable[..., Any], as_form: Callable[..., Any]
) -> None:
    key = {"Idempotency-Key": "once"}
    form = {"files": as_form(FILES), "data": {"robot": robot}}
    first, replayed = (client.post(f"{V1}/devices", headers=key, **form) for _ in range(2))
    assert (replayed.status_code, replayed.content) == (201, first.content)
    assert replayed.headers["idempotency-replayed"] == "true"
    assert hand_in().status_code == 200
    second = hand_in({**FILES, "bench/front.csv": BENCH + b"0.40,30\n"})
    hand_in(name="Spare strap")
    listed = client.get(f"{V1}/devices", params={"name": "Elbow strap"}).json()["items"]
    assert [(item["id"], item["version"]) for item in listed] == [
        (second.json()["id"], 2),
        (first.json()["id"], 1),
    ]
    assert len(client.get(f"{V1}/devices", params={"robot_id": robot}).json()["items"]) == 3
    assert client.get(f"{V1}/devices", params={"robot_id": NOBODY}).json()["items"] == []
    assert client.get(f"{V1}/devices", params={"name": "\x00"}).status_code in (200, 422)


@pytest.fixture
def stranger(client: TestClient, settings: Settings) -> Iterator[TestClient]:
    """The same database and blobs, seen from another lab; `client` has prepared them."""
    with TestClient(create_app(settings.model_copy(update={"lab": "other"}))) as opened:
        yield opened


@pytest.mark.usefixtures("unchecked")
def test_another_lab_sees_and_uses_none_of_it(
    stranger: TestClient, robot: str, hand_in: Callable[..., Any], as_form: Callable[..., Any]
) -> None:
    device = hand_in().json()["id"]
    assert stranger.get(f"{V1}/devices").json()["items"] == []
    for path in (f"devices/{device}", f"devices/{device}/files/device.yaml"):
        assert stranger.get(f"{V1}/{path}").status_code == 404
    assert stranger.post(f"{V1}/devices", files=as_form(FILES), data={"robot": robot}).status_code == 404


@pytest.fixture
def logs(client: TestClient, study_files: dict[str, bytes], monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Ids of two logs; they are read for real only when a study is made of them."""
    from exogauge.api import checking

    ids = []
    with monkeypatch.context() as patch:
        patch.setattr(checking, "check_log", lambda *_: {})
        for path in ("logs/id.csv", "logs/val.csv"):
            ids.append(client.post(f"{V1}/logs", files={"file": (path, study_files[path])}).json()["id"])
    return ids


@pytest.mark.slow  # reads in child processes
def test_a_study_from_parts_names_what_was_worn(
    client: TestClient, robot: str, hand_in: Callable[..., Any], logs: list[str]
) -> None:
    strap = hand_in().json()["id"]
    other = {"device.yaml": DEVICE.replace(b"Elbow strap", b"Soft strap").replace(b"200", b"90"), "readme.txt": b"soft"}
    soft = hand_in({**FILES, **other}).json()["id"]
    parts = [
        {"log_id": logs[0], "role": "identification"},
        {"log_id": logs[1], "role": "without_device", "motion": "lift", "name": "plain"},
        {"log_id": logs[1], "role": "with_device", "motion": "lift", "name": "worn", "started": 95.5},
        {"log_id": logs[1], "role": "with_device", "motion": "lift", "name": "worn_soft", "device_id": soft},
    ]
    wanted = {"name": "Straps", "robot_id": robot, "device_id": strap, "logs": parts}
    answer = client.post(f"{V1}/studies", json=wanted)
    assert answer.status_code == 201, answer.text
    summary = answer.json()["summary"]
    assert [(device["file"], device["name"]) for device in summary["devices"]] == [
        ("device_0.yaml", "Elbow strap"),
        ("device_1.yaml", "Soft strap"),
    ]
    assert summary["devices"][1]["bands"][0]["stiffness_n_per_m"] == 90.0
    assert [(log["motion"], log["device"]) for log in summary["logs"]] == [
        (None, None),
        ("lift", None),
        ("lift", "device_0.yaml"),
        ("lift", "device_1.yaml"),
    ]
    assert any("never taut" in warning for warning in summary["warnings"])
    paths = {file["path"] for file in answer.json()["files"]}
    assert paths >= {"bench/front.csv", "device_0.yaml", "device_1.yaml"}
    assert "readme.txt" not in paths
    written = client.get(f"{V1}/studies/{answer.json()['id']}/files/study.yaml").text
    assert [log.get("started") for log in yaml.safe_load(written)["logs"]] == [None, None, 95.5, None]


@on_sqlite
@pytest.mark.usefixtures("unchecked")
def test_parts_that_do_not_fit_together_are_refused(
    client: TestClient, robot: str, hand_in: Callable[..., Any], logs: list[str]
) -> None:
    strap = hand_in().json()["id"]
    other = hand_in({**FILES, "bench/front.csv": BENCH + b"0.40,30\n"}).json()["id"]
    worn = {"log_id": logs[1], "role": "with_device"}
    first = {"log_id": logs[0], "role": "identification"}
    wanted = {"name": "n", "robot_id": robot, "device_id": strap, "logs": [first, {**worn, "device_id": other}]}
    clash = client.post(f"{V1}/studies", json=wanted)
    assert clash.status_code == 422
    assert (clash.json()["errors"][0]["code"], clash.json()["errors"][0]["file"]) == ("path_clash", "bench/front.csv")
    plain = client.post(f"{V1}/studies", json={**wanted, "logs": [{**first, "device_id": strap}]})
    assert plain.status_code == 422
    assert plain.json()["errors"][0]["pointer"] == "#/logs/0"
    nobody = client.post(f"{V1}/studies", json={**wanted, "device_id": NOBODY})
    assert nobody.status_code == 404


def test_every_law_that_device_yaml_takes_is_told_with_its_values(client: TestClient) -> None:
    told = client.get(f"{V1}/band-laws").json()["laws"]
    assert {law["name"] for law in told} == set(all_laws())
    for law in told:
        assert law["sentence"]
        check_values(law["name"], {value["name"]: value["typical"] for value in law["values"]})
        check_values(law["name"], {value["name"]: value["low"] for value in law["values"] if value["default"] is None})
        for value in law["values"]:
            if value["high"] is not None:
                with pytest.raises(BadInput):
                    check_values(law["name"], {value["name"]: value["high"] * 1.01})
