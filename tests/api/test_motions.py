"""Motions and plans over HTTP: read in child processes, kept, planned by a worker, handed out to robots."""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from fastapi.testclient import TestClient
from tests.motion.captures import bow, bvh
from tests.motion.robots import sample_folder
from tests.motion.tables import motive, mvnx, nexus, qualisys
from tests.motion.test_reading import LABELS, body

from exogauge.jobs.attempt import Runner
from exogauge.jobs.leases import Lease
from exogauge.storage.store import Installation

V1 = "/api/v1"
NOBODY = "00000000-0000-4000-8000-000000000000"
pytestmark = [
    pytest.mark.slow,  # reads in child processes
    pytest.mark.parametrize("database_url", ["sqlite"], indirect=True),
]
Work = Callable[[], None]


@pytest.fixture
def work(client: TestClient, tmp_path: Path) -> Iterator[Work]:
    """Brings the next job to an end, as a worker does."""
    installation: Installation = client.app.state.installation  # type: ignore[attr-defined]
    lease = Lease(installation.engine, "worker", 600.0)
    lease.take()
    runner = Runner(installation, "worker", tmp_path / "worker")
    yield runner.run
    runner.leave()
    runner._child.kill()  # a worker process just ends
    lease.give_back()


def hand_in(client: TestClient, files: dict[str, bytes], **said: str) -> Any:
    return client.post(f"{V1}/motions", files=[("files", each) for each in files.items()], data=said)


def robot_id(client: TestClient, folder: Path, without: str = "", **more: Any) -> str:
    content = yaml.safe_load(sample_folder(folder).read_bytes()) | more
    files = {path.name: path.read_bytes() for path in sorted(folder.iterdir())}
    kept = {key: value for key, value in content.items() if key != without}
    files["robot.yaml"] = yaml.safe_dump(kept).encode()
    answer = client.post(f"{V1}/robots", files=[("files", each) for each in files.items()])
    assert answer.status_code == 201, answer.text
    key: str = answer.json()["id"]
    return key


def codes(answer: Any) -> list[str]:
    assert answer.status_code == 422, answer.text
    assert answer.headers["content-type"] == "application/problem+json"
    return [each["code"] for each in answer.json()["errors"]]


def test_a_capture_is_read_told_restated_and_its_feet_can_be_corrected(client: TestClient) -> None:
    capture = bvh(bow())
    answer = hand_in(client, {"bow.bvh": capture})
    assert answer.status_code == 201, answer.text
    motion = answer.json()
    summary = motion["summary"]
    assert (motion["name"], summary["holds"], summary["frames"], summary["rate_hz"]) == ("bow", "skeleton", 121, 60.0)
    assert summary["told"]["up"].startswith("guessed: y")
    assert summary["told"]["unit"].startswith("guessed: cm")
    assert {each["name"]: each["segment"] for each in summary["labels"]}["Spine2"] == "thorax"
    assert client.get(f"{V1}/motions/{motion['id']}/files/bow.bvh").content == capture
    again = hand_in(client, {"bow.bvh": capture})
    assert (again.status_code, again.json()["id"]) == (200, motion["id"])

    stated = client.post(f"{V1}/motions/{motion['id']}/versions", json={"up": "y", "unit": "cm"})
    assert stated.status_code == 201, stated.text
    assert (stated.json()["version"], stated.json()["summary"]["told"]["up"]) == (2, "stated: y")
    assert [each["version"] for each in client.get(f"{V1}/motions").json()["items"]] == [2, 1]

    address = f"{V1}/motions/{motion['id']}/contacts"
    read = client.get(address).json()
    assert read["said"] is None
    assert read["read"] == {"left": [[0.0, 2.0]], "right": [[0.0, 2.0]]}
    said = {"left": [[0.0, 1.0]], "right": [[0.0, 0.5], [0.8, 2.0]]}
    kept = client.put(address, json=said, headers={"If-Match": client.get(address).headers["etag"]})
    assert kept.json()["said"] == said
    stale = {"If-Match": '"none"'}
    for refused in (client.put(address, json=said, headers=stale), client.delete(address, headers=stale)):
        assert refused.status_code == 412
    assert client.put(address, json={"left": [[1.0, 0.5]], "right": []}).status_code == 422
    beyond = client.put(address, json={"left": [[0.0, 1.0]], "right": [[0.0, 0.5], [0.8, 2.01]]})
    assert (beyond.status_code, codes(beyond)) == (422, ["past_the_end"])
    [told] = beyond.json()["errors"]
    assert (told["column"], told["value"]) == ("right.1", "0.8 to 2.01 s")
    assert "frame is 121, at 2 s" in told["advice"]
    assert client.get(address).json()["said"] == said
    gone = client.delete(address, headers={"If-Match": kept.headers["etag"]})
    assert (gone.json()["said"], gone.headers["etag"]) == (None, '"none"')
    assert client.put(address, json=said, headers={"If-Match": kept.headers["etag"]}).status_code == 412

    series = client.get(f"{V1}/motions/{motion['id']}/series").json()
    assert (series["samples"], series["end"]) == (121, pytest.approx(2.0))
    names = [each["name"] for each in series["channels"]]
    assert {"bone.Head.x", "stands.left"} <= set(names)
    ways = {"channels": ["bone.Head.x", "bone.Head.y", "bone.Head.z"]}
    tiles = client.get(f"{V1}/motions/{motion['id']}/series/tiles", params=ways).json()["channels"]
    moved = [max(each["max"]) - min(each["min"]) for each in tiles.values()]
    assert max(moved) == pytest.approx(0.40 * np.sin(np.radians(20.0)), abs=0.002)  # the head goes ahead with the trunk


@pytest.mark.parametrize(
    ("name", "text", "holds", "found"),
    [
        ("a.tsv", qualisys(body(), LABELS), "markers", "Qualisys TSV"),
        ("a.csv", motive(body(), LABELS), "markers", "Motive CSV"),
        ("b.csv", nexus(body(), LABELS), "markers", "Nexus CSV"),
        ("a.mvnx", mvnx(np.linspace(0.0, 0.5, 30)), "skeleton", "MVNX"),
    ],
)
def test_tables_and_segments_of_laboratories_are_taken(
    client: TestClient, name: str, text: str, holds: str, found: str
) -> None:
    answer = hand_in(client, {name: text.encode()})
    assert answer.status_code == 201, answer.text
    summary = client.get(f"{V1}/motions/{answer.json()['id']}").json()["summary"]
    assert (summary["holds"], summary["told"]["format"]) == (holds, found)


def test_what_cannot_be_read_is_refused_with_what_to_say(client: TestClient) -> None:
    assert codes(hand_in(client, {"a.bvh": b"HIERARCHY\nROOT"})) != []
    assert codes(hand_in(client, {"a.txt": b"no capture"})) == ["which_capture"]
    assert codes(hand_in(client, {"a.bvh": bvh(bow()), "b.bvh": bvh(bow(5.0))})) == ["which_capture"]
    assert codes(hand_in(client, {"a.bvh": bvh(bow())}, up="w")) == ["literal_error"]
    assert hand_in(client, {"a.bvh": bvh(bow())}, map="nobody's").status_code == 404
    foreign = bvh(bow()).replace(b"Hips", b"Becken").replace(b"Spine2", b"Brust").replace(b"Head", b"Kopf")
    names = {"Becken": "Hips", "Brust": "Spine2", "Kopf": "Head"}
    kept = client.post(f"{V1}/motion-maps", json={"name": "ours", "names": names})
    assert kept.status_code == 200, kept.text
    plain = hand_in(client, {"a.bvh": foreign}, up="y", unit="cm").json()
    assert "Becken" in plain["summary"]["told"]["unknown"]
    mapped = hand_in(client, {"a.bvh": foreign}, map="ours").json()
    assert mapped["summary"]["told"]["preset"] == "MotionBuilder and Mixamo"
    assert "unknown" not in mapped["summary"]["told"]
    assert client.delete(f"{V1}/motion-maps/{kept.json()['id']}").status_code == 204
    assert client.get(f"{V1}/motion-maps").json()["items"] == []


def test_a_captured_bow_becomes_a_motion_of_the_robot(client: TestClient, work: Work, tmp_path: Path) -> None:
    motion, robot = hand_in(client, {"bow.bvh": bvh(bow())}).json(), robot_id(client, tmp_path / "robot")
    wanted = {"robot_id": robot, "motion_id": motion["id"], "retarget": {"slow": 1.5}}
    asked = client.post(f"{V1}/plans", json=wanted)
    assert asked.status_code == 202, asked.text
    plan = asked.json()
    assert (plan["kind"], plan["name"], plan["latest_job"]["state"]) == ("retarget", "bow on hrp4_like", "queued")
    address = f"{V1}/plans/{plan['id']}"
    assert client.get(f"{address}/exports/csv").status_code == 404
    assert client.get(f"{address}/series").json()["items"] == []
    work()
    made = client.get(address).json()
    assert made["latest_job"]["state"] == "succeeded", made["latest_job"]
    found = made["found"]
    assert found["broken"] == []
    assert found["seconds"] == pytest.approx(2.0 + 3.0 + 2.0)
    pitch = {each["joint"]: each for each in found["trunk"]}["torso_pitch"]
    assert pitch["asked"] == pytest.approx([0.0, np.radians(20.0)], abs=2e-3)
    assert found["margins"]["pressure_inside_m"] > 0.015
    equal = client.post(f"{V1}/plans", json=wanted)
    assert (equal.status_code, equal.json()["id"]) == (200, plan["id"])

    (series,) = client.get(f"{address}/series").json()["items"]
    channels = {each["name"] for each in series["channels"]}
    assert {"human.trunk_flexion", "trunk.given.torso_pitch", "margin.pressure_inside", "binds"} <= channels
    tiles = client.get(
        f"{V1}/jobs/{made['found_job_id']}/series/motion/tiles", params={"channels": ["human.trunk_flexion"]}
    ).json()
    assert max(x for x in tiles["channels"]["human.trunk_flexion"]["max"] if x is not None) == pytest.approx(
        np.radians(20.0), abs=1e-3
    )

    table = client.get(f"{address}/exports/csv")
    assert table.status_code == 200
    assert table.text.startswith("t,q.")
    mujoco = client.get(f"{address}/exports/mujoco", params={"rate_hz": 100})
    assert mujoco.status_code == 200, mujoco.text
    with zipfile.ZipFile(io.BytesIO(mujoco.content)) as archive:
        sheet = json.loads(archive.read("bow_on_hrp4_like.json"))
        with np.load(io.BytesIO(archive.read("bow_on_hrp4_like.npz"))) as file:
            assert file["qpos"].shape == (701, 7 + len(file["joint_names"]))
    assert (sheet["broken"], sheet["rate_hz"]) == ([], 100.0)
    assert codes(client.get(f"{address}/exports/exe")) == ["unknown_format"]

    for kept in (f"motions/{motion['id']}", f"robots/{robot}"):
        assert client.delete(f"{V1}/{kept}").status_code == 409
    assert client.delete(address).status_code == 204
    assert client.delete(f"{V1}/motions/{motion['id']}").status_code == 204


def test_a_bow_of_a_robot_too_weak_for_it_is_told_and_handed_out_only_marked(
    client: TestClient, work: Work, tmp_path: Path
) -> None:
    motion = hand_in(client, {"b.bvh": bvh(bow())}).json()
    robot = robot_id(client, tmp_path / "robot", limits={"torque_share": 0.005})
    asked = client.post(f"{V1}/plans", json={"robot_id": robot, "motion_id": motion["id"], "retarget": {}})
    work()
    plan = client.get(f"{V1}/plans/{asked.json()['id']}").json()
    assert any(line.startswith("torque of ") for line in plan["found"]["broken"]), plan["found"]["broken"]
    assert plan["found"]["margins"]["bounds"][0]["kind"] == "torque"
    address = f"{V1}/plans/{plan['id']}/exports"
    assert set(codes(client.get(f"{address}/csv"))) == {"broken"}
    assert client.get(f"{address}/csv", params={"despite": True}).text.splitlines()[0].endswith(",broken")


def test_contacts_said_by_hand_are_what_the_plan_takes(client: TestClient, work: Work, tmp_path: Path) -> None:
    motion, robot = hand_in(client, {"b.bvh": bvh(bow())}).json(), robot_id(client, tmp_path / "robot")
    flown = {"left": [[0.0, 0.5], [1.5, 2.0]], "right": [[0.0, 0.5], [1.5, 2.0]]}
    client.put(f"{V1}/motions/{motion['id']}/contacts", json=flown)
    wanted = {"robot_id": robot, "motion_id": motion["id"], "retarget": {}}
    refused = client.post(f"{V1}/plans", json=wanted).json()
    work()
    job = client.get(f"{V1}/plans/{refused['id']}").json()["latest_job"]
    assert job["state"] == "failed"
    assert "foot" in job["reason"] or "feet" in job["reason"]
    client.delete(f"{V1}/motions/{motion['id']}/contacts")
    other = client.post(f"{V1}/plans", json=wanted).json()
    assert other["id"] != refused["id"]


@pytest.mark.parametrize(("without", "code"), [("soles", "no_soles"), ("human_map", "no_human_map")])
def test_a_robot_that_lacks_something_is_refused_before_anything_is_computed(
    client: TestClient, tmp_path: Path, without: str, code: str
) -> None:
    motion, robot = hand_in(client, {"b.bvh": bvh(bow())}).json(), robot_id(client, tmp_path / "robot", without)
    wanted = {"robot_id": robot, "motion_id": motion["id"], "retarget": {}}
    assert codes(client.post(f"{V1}/plans", json=wanted)) == [code]
    for wrong in ({"robot_id": robot}, {"robot_id": robot, "retarget": {}},
                  {"robot_id": robot, "motion_id": motion["id"], "excite": {}}):  # fmt: skip
        assert codes(client.post(f"{V1}/plans", json=wrong)) == ["wrong_request"]
    assert client.post(f"{V1}/plans", json=wanted | {"motion_id": NOBODY}).status_code == 404
    assert client.get(f"{V1}/plans").json()["items"] == []
