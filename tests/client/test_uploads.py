"""A large file goes up although the server is killed on the way: what it confirmed is there, and the rest follows."""

from __future__ import annotations

import hashlib
import os
import random
import signal
import socket
import threading
from pathlib import Path

import httpx
import pytest

from exogauge.client import Client, ClientProblem, uploading

pytestmark = pytest.mark.slow

MIB = 1 << 20
TUS = {"Tus-Resumable": "1.0.0"}


@pytest.fixture
def service(make_service):
    """A service that comes back at the same address."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    made = make_service(database_url="", workers=0)
    made.environment["EXOGAUGE_PORT"] = str(port)
    made.start()
    return made


def killed(service) -> None:
    os.kill(service.process.pid, signal.SIGKILL)
    service.process.wait()


def on_disk(service) -> list[Path]:
    return sorted((service.folder / "data" / "uploads").iterdir())


@pytest.mark.slow
def test_a_server_killed_in_the_middle_of_a_piece_goes_on_at_the_last_byte_it_has(service):
    data = random.Random(1).randbytes(24 * MIB)

    def pieces():
        for start in range(0, len(data), MIB // 4):
            if start == 16 * MIB:
                killed(service)
            yield data[start : start + MIB // 4]

    with httpx.Client(base_url=service.url) as http:
        begun = http.post("/api/v1/uploads", headers={**TUS, "Upload-Length": str(len(data))})
        place = begun.headers["location"]
        headers = {**TUS, "Content-Type": "application/offset+octet-stream"}
        with pytest.raises(httpx.TransportError):
            http.patch(place, content=pieces(), headers={**headers, "Upload-Offset": "0"})
        service.start()
        offset = int(http.head(place, headers=TUS).headers["upload-offset"])
        (file,) = on_disk(service)
        assert 0 < offset == file.stat().st_size < len(data)
        again = http.patch(place, content=data[offset:], headers={**headers, "Upload-Offset": str(offset)})
        assert again.headers["upload-offset"] == str(len(data))
    assert hashlib.sha256(file.read_bytes()).digest() == hashlib.sha256(data).digest()


@pytest.mark.slow
def test_the_client_outlives_the_server(service, tmp_path, monkeypatch):
    monkeypatch.setattr(uploading, "PIECE", 2 * MIB)
    large = tmp_path / "large.bin"
    large.write_bytes(random.Random(2).randbytes(9 * MIB))
    told, back = [], []

    def say(sent: int) -> None:
        told.append(sent)
        if len(told) == 2:
            killed(service)
            back.append(threading.Thread(target=service.start))
            back[0].start()

    with Client(service.url) as opened:
        key = uploading.upload(opened._http, large, say)
        back[0].join()
        (file,) = on_disk(service)
        assert file.name == key
        assert file.read_bytes() == large.read_bytes()
        assert told == sorted(set(told))
        assert told[-1] == 9 * MIB
        with pytest.raises(ClientProblem, match=r"study\.yaml"):
            opened.study_of_uploads([key], ["large.bin"])


def test_a_foreign_log_is_looked_at_mapped_and_kept_with_its_robot(service, study_folder, tmp_path):
    table = tmp_path / "vendor.csv"
    rows = (f"{5 * k},{10 * (k % 9)},{k % 5}" for k in range(100))
    table.write_text("\n".join(["time_ms,elbow_pos_deg,elbow_torque_Nm", *rows]) + "\n")
    with Client(service.url) as opened:
        robot = opened.upload_robot(study_folder / "robot.yaml")
        key = opened.upload(table)
        mapping = opened.preview_log(key, robot)["mapping"]
        assert opened.preview_log(key, robot, mapping)["complete"]
        assert opened.keep_mapping(robot, mapping)["mapping"] == opened.robot_mapping(robot)["mapping"] == mapping
        log = opened.log_of_upload(key, mapping, robot)
        assert (log.name, log.summary["channels"]) == ("vendor.csv", ["q.elbow", "tau.elbow"])
        assert opened.models(opened.upload_study(study_folder)) == []


def test_a_large_study_goes_up_in_pieces_and_is_the_same_study(service, study_folder, monkeypatch):
    with Client(service.url) as opened:
        whole = opened.upload_study(study_folder)
        monkeypatch.setattr(uploading, "LARGE", 1)
        monkeypatch.setattr(uploading, "PIECE", 1000)
        assert opened.upload_study(study_folder) == whole
    assert on_disk(service) == []
