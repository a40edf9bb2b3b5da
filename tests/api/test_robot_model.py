"""What a page shows of a robot, and the files that it was handed in as."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from fastapi.testclient import TestClient

V1 = "/api/v1"
AsForm = Callable[[dict[str, bytes]], list[tuple[str, tuple[str, bytes]]]]


@pytest.fixture
def robot(client: TestClient, robot_files: dict[str, bytes], as_form: AsForm) -> dict[str, Any]:
    answer = client.post(f"{V1}/robots", files=as_form(robot_files))
    assert answer.status_code == 201, answer.text
    found: dict[str, Any] = client.get(f"{V1}/robots/{answer.json()['id']}").json()
    return found


@pytest.mark.slow
@pytest.mark.parametrize("database_url", ["sqlite"], indirect=True)
def test_one_robot_tells_its_joints_limits_and_where_its_links_are(robot: dict[str, Any]) -> None:
    model = robot["summary"]["model"]
    joint = model["joints"][0]
    said = {key: joint[key] for key in ("name", "kind", "moves", "actuation", "gear_ratio", "lower", "upper", "effort")}
    assert said == {
        "name": "elbow", "kind": "revolute", "moves": "arm", "actuation": "torque", "gear_ratio": 50.0,
        "lower": -2.0, "upper": 2.0, "effort": 50.0,
    }  # fmt: skip
    arm = next(link for link in model["links"] if link["name"] == "arm")
    assert arm["at"] == [0.0, 0.0, 0.2]  # the joint's origin in the URDF
    assert arm["turn"] == [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
    assert (arm["joint"], arm["mass_kg"], arm["centre"]) == ("elbow", 2.0, [0.0, 0.0, 0.1])


@pytest.mark.slow
@pytest.mark.parametrize("database_url", ["sqlite"], indirect=True)
def test_a_list_of_robots_leaves_the_model_out(client: TestClient, robot: dict[str, Any]) -> None:
    listed = client.get(f"{V1}/robots").json()["items"][0]
    assert listed["summary"] == {key: value for key, value in robot["summary"].items() if key != "model"}


@pytest.mark.slow
@pytest.mark.parametrize("database_url", ["sqlite"], indirect=True)
def test_a_robots_files_come_back_byte_for_byte(
    client: TestClient, robot: dict[str, Any], robot_files: dict[str, bytes]
) -> None:
    for path, content in robot_files.items():
        answer = client.get(f"{V1}/robots/{robot['id']}/files/{path}")
        assert answer.content == content
        assert answer.headers["content-disposition"].startswith("attachment")
    missing = client.get(f"{V1}/robots/{robot['id']}/files/robot.yml")
    assert (missing.status_code, missing.headers["content-type"]) == (404, "application/problem+json")


def test_a_studys_files_come_back_byte_for_byte(
    client: TestClient, study_id: str, study_files: dict[str, bytes]
) -> None:
    assert client.get(f"{V1}/studies/{study_id}/files/logs/id.csv").content == study_files["logs/id.csv"]
    assert client.get(f"{V1}/studies/{study_id}/files/../robots").status_code == 404
