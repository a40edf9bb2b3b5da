"""A foreign log is looked at, suggested for, judged; its mapping is kept for the robot's next one."""

from __future__ import annotations

import base64
import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import pytest

pytestmark = pytest.mark.slow

if TYPE_CHECKING:
    from fastapi.testclient import TestClient

V1 = "/api/v1"
TUS = {"Tus-Resumable": "1.0.0"}
NOBODY = "00000000-0000-4000-8000-000000000000"
on_sqlite = pytest.mark.parametrize("database_url", ["sqlite"], indirect=True)


@pytest.fixture
def robot(client: TestClient, robot_files: dict[str, bytes], as_form: Callable[..., Any]) -> str:
    """A robot whose one joint, elbow, turns from -2 to 2 rad at up to 5 rad/s."""
    answer = client.post(f"{V1}/robots", files=as_form(robot_files))
    assert answer.status_code == 201, answer.text
    key: str = answer.json()["id"]
    return key


def uploaded(client: TestClient, table: str, name: str = "vendor.csv") -> str:
    metadata = f"filename {base64.b64encode(name.encode()).decode()}"
    headers = {**TUS, "Upload-Length": str(len(table.encode())), "Upload-Metadata": metadata}
    place = client.post(f"{V1}/uploads", headers=headers).headers["location"]
    piece = {**TUS, "Upload-Offset": "0", "Content-Type": "application/offset+octet-stream"}
    assert client.patch(place, content=table.encode(), headers=piece).status_code == 204
    return place.rsplit("/", 1)[-1]


def rows(header: str, *columns: Callable[[float], float | str], samples: int = 400) -> str:
    lines = [header] if header else []
    for k in range(samples):
        lines.append(",".join(str(column(k / 100)) for column in columns))
    return "\n".join(lines) + "\n"


TABLE = rows(
    "stamp_ms,elbow_pos,elbow_trq [Nm],elbow_des_pos,note,x7",
    lambda t: round(1000 * t),
    lambda t: round(57.3 * math.sin(2 * t), 4),
    lambda t: round(1.5 * math.sin(2 * t), 5),
    lambda t: 0.0,
    lambda t: "ok",
    lambda t: 1.0,
)


def preview(client: TestClient, **asked: Any) -> Any:
    answer = client.post(f"{V1}/imports/preview", json=asked)
    assert answer.status_code == 200, answer.text
    return answer.json()


@on_sqlite
def test_columns_are_shown_and_suggested_for_by_name_range_and_joint(client: TestClient, robot: str) -> None:
    found = preview(client, upload_id=uploaded(client, TABLE), robot_id=robot)
    assert (found["file"], found["rows"], found["header"], found["remembered"]) == ("vendor.csv", 400, True, None)
    columns = {column["name"]: column for column in found["columns"]}
    assert columns["elbow_pos"]["samples"][:2] == [0.0, round(57.3 * math.sin(0.02), 4)]
    assert columns["elbow_pos"]["max"] == pytest.approx(57.3, abs=0.01)
    suggested = {name: column["suggestion"] for name, column in columns.items()}
    assert (suggested["stamp_ms"]["channel"], suggested["stamp_ms"]["unit"]) == ("t", "ms")
    elbow = suggested["elbow_pos"]
    assert (elbow["channel"], elbow["unit"], elbow["sign"], elbow["sure"]) == ("q.elbow", "deg", 1, True)
    assert "only deg stays within the joint's limits" in elbow["why"]
    assert (suggested["elbow_trq [Nm]"]["channel"], suggested["elbow_trq [Nm]"]["unit"]) == ("tau.elbow", "Nm")
    assert "commanded" in columns["elbow_des_pos"]["advice"]
    assert (columns["note"]["dtype"], suggested["note"]) == ("text", None)
    assert "ignore" in columns["note"]["advice"]
    assert suggested["x7"] is None
    assert "ignore" in columns["x7"]["advice"]


@on_sqlite
def test_the_mapping_of_what_is_sure_is_refused_until_every_column_is_named_or_left_out(
    client: TestClient, robot: str
) -> None:
    key = uploaded(client, TABLE)
    mapping = preview(client, upload_id=key, robot_id=robot)["mapping"]
    open_ = preview(client, upload_id=key, robot_id=robot, mapping=mapping)
    assert not open_["complete"]
    assert {error["column"] for error in open_["errors"]} == {"elbow_des_pos", "note", "x7"}
    assert open_["findings"] == []
    mapping["files"][0]["ignore"] = ["elbow_des_pos", "note", "x7"]
    closed = preview(client, upload_id=key, robot_id=robot, mapping=mapping)
    assert (closed["complete"], closed["errors"]) == (True, [])
    assert closed["clock"] == {"samples": 400, "duration_s": pytest.approx(3.99), "rate_hz": pytest.approx(100.0)}
    assert set(closed["channels"]) == {"q.elbow", "tau.elbow"}


@on_sqlite
def test_a_wrong_unit_of_time_shows_in_the_clock_and_is_not_stored(client: TestClient, robot: str) -> None:
    """Milliseconds read as seconds: 3990 s at 0.1 Hz."""
    key = uploaded(client, TABLE)
    mapping = preview(client, upload_id=key, robot_id=robot)["mapping"]
    mapping["files"][0] |= {"ignore": "rest", "time": {"column": "stamp_ms", "unit": "s"}}
    found = preview(client, upload_id=key, robot_id=robot, mapping=mapping)
    assert not found["complete"]
    assert found["clock"] == {"samples": 400, "duration_s": pytest.approx(3990), "rate_hz": pytest.approx(0.1)}
    assert "0.1 Hz" in found["errors"][0]["detail"]
    answer = client.post(f"{V1}/logs/from-upload", json={"upload_id": key, "robot_id": robot, "mapping": mapping})
    assert answer.status_code == 422, answer.text
    assert "0.1 Hz" in answer.text


@on_sqlite
def test_the_doctor_says_where_in_the_log_it_is_sick(client: TestClient, robot: str) -> None:
    def torque(t: float) -> float:
        return round(math.sin(2 * t), 5) if not 1.5 <= t < 2.5 else 0.14112

    table = rows("t,q.elbow,tau.elbow", lambda t: t, lambda t: round(math.sin(2 * t), 5), torque)
    key = uploaded(client, table)
    mapping = preview(client, upload_id=key, robot_id=robot)["mapping"]
    found = preview(client, upload_id=key, robot_id=robot, mapping=mapping)
    assert found["complete"], found["errors"]
    (frozen,) = [each for each in found["findings"] if each["rule"] == "frozen"]
    assert (frozen["channel"], frozen["index"], frozen["row"], frozen["t"]) == ("tau.elbow", 150, 151, 1.5)
    around = frozen["around"]
    assert (around["unit"], around["t"][0], around["t"][-1]) == (
        "N·m",
        0.0,
        3.5,
    )  # 200 samples to each side, or the end
    assert around["values"][150] == 0.14112
    assert frozen["advice"]


@on_sqlite
def test_a_table_of_bare_numbers_is_shown_with_its_columns_counted(client: TestClient) -> None:
    found = preview(client, upload_id=uploaded(client, rows("", lambda t: t, lambda t: t * t)))
    assert (found["header"], [column["name"] for column in found["columns"]]) == (False, ["1", "2"])
    assert found["mapping"]["files"] == [{"file": "vendor.csv", "layout": {"header": False}}]
    assert all(column["suggestion"] is None and column["advice"] for column in found["columns"])


@on_sqlite
@pytest.mark.parametrize(
    "mapping", ["version: 1\nfiles: [", {"version": 1}, {"version": 1, "files": [{"file": "x"}]}, ""]
)
def test_a_mapping_that_is_none_is_told_beside_the_columns(client: TestClient, mapping: Any) -> None:
    found = preview(client, upload_id=uploaded(client, TABLE), mapping=mapping)
    assert not found["complete"]
    assert found["errors"]
    assert len(found["columns"]) == 6


@on_sqlite
def test_what_is_no_log_is_refused_with_a_reason(client: TestClient) -> None:
    for name, content, code in (("a.pdf", "%PDF-1.4 and so on", "unknown_format"), ("b.csv", "\n\n", "no_header")):
        answer = client.post(f"{V1}/imports/preview", json={"upload_id": uploaded(client, content, name)})
        assert answer.status_code == 422, answer.text
        (error,) = answer.json()["errors"]
        assert (error["code"], error["file"]) == (code, name)
    nobody = client.post(f"{V1}/imports/preview", json={"upload_id": NOBODY})
    assert nobody.status_code == 404


JSON = {"content-type": "application/json"}
MAPPING = {
    "version": 1,
    "files": [{"file": "vendor.csv", "time": {"column": "stamp_ms", "unit": "ms"}, "ignore": "rest",
               "columns": {"elbow_pos": {"channel": "q.elbow", "unit": "deg"}}}],
}  # fmt: skip


@pytest.mark.slow
def test_a_robot_remembers_its_mapping_and_so_does_its_next_version(
    client: TestClient, robot: str, robot_files: dict[str, bytes], as_form: Callable[..., Any]
) -> None:
    place = f"{V1}/robots/{robot}/mapping"
    assert client.get(place).status_code == 404
    first = client.put(place, json={"mapping": MAPPING})
    assert (first.status_code, first.json()["mapping"]) == (201, MAPPING)
    etag = first.headers["etag"]
    again = client.put(place, json={"mapping": first.json()["yaml"]}, headers={"If-Match": etag})
    assert (again.status_code, again.headers["etag"]) == (200, etag)
    assert client.get(place).json() == again.json()
    assert client.put(place, json={"mapping": MAPPING}, headers={"If-Match": '"other"'}).status_code == 412
    deep = client.put(place, content=b'{"mapping": ' + b'{"a":' * 900 + b"1" + b"}" * 901, headers=JSON)
    assert (deep.status_code, deep.json()["errors"][0]["code"]) == (422, "too_deep")

    other = robot_files | {"robot.yaml": robot_files["robot.yaml"] + b"noise: {q: 1e-4}\n"}
    newer = client.post(f"{V1}/robots", files=as_form(other)).json()["id"]
    inherited = client.get(f"{V1}/robots/{newer}/mapping").json()
    assert (inherited["robot_id"], inherited["mapping"]) == (robot, MAPPING)
    taken_over = {"If-Match": client.get(f"{V1}/robots/{newer}/mapping").headers["etag"]}
    ignoring = client.get(f"{V1}/robots/{newer}/mapping").json()["yaml"].replace("deg", "rad")
    for status in (201, 412):  # what was read of the other version is replaced once
        said = client.put(f"{V1}/robots/{newer}/mapping", json={"mapping": ignoring}, headers=taken_over)
        assert said.status_code == status, said.text
    assert client.put(f"{V1}/robots/{newer}/mapping", json={"mapping": MAPPING}).status_code == 200
    seen = preview(client, upload_id=uploaded(client, TABLE, "next.csv"), robot_id=newer)
    assert seen["remembered"]["files"][0]["file"] == "next.csv"
    assert preview(client, upload_id=seen["upload_id"], robot_id=newer, mapping=seen["remembered"])["complete"]


@on_sqlite
def test_a_mapping_of_another_robot_is_not_kept(client: TestClient, robot: str) -> None:
    place = f"{V1}/robots/{robot}/mapping"
    entry = MAPPING["files"][0] | {"columns": {"a": {"channel": "q.knee", "unit": "deg"}}}
    refused = client.put(place, json={"mapping": {"version": 1, "files": [entry]}})
    assert refused.status_code == 422
    (error,) = refused.json()["errors"]
    assert (error["code"], error["value"]) == ("unknown_joint", "knee")
    assert client.put(place, json={"mapping": "version: 9"}).status_code == 422
    assert client.put(f"{V1}/robots/{NOBODY}/mapping", json={"mapping": MAPPING}).status_code == 404
    assert client.get(place).status_code == 404
