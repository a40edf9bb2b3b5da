"""Live streams through the real service: a server of its own, real websockets, real kills."""

from __future__ import annotations

import contextlib
import itertools
import json
import os
import signal
import socket
import struct
import subprocess
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest
import yaml
from numpy.typing import NDArray
from tests.api.small_payload import payload_files
from tests.client.conftest import Service
from tests.payload.conftest import generator
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import ClientConnection, connect

from exogauge.client import Client, ClientProblem
from exogauge.payload.evaluate import evaluate
from exogauge.payload.intake import open_payload
from exogauge.synthetic.payload import write_payload

pytestmark = pytest.mark.slow
Array = NDArray[np.float64]
SILENCE_S = 3.0
PATIENCE_S = 60.0  # a process that closes a stream has to be started, and the machine may be busy


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The sample, of which the postures alone identify."""
    out = tmp_path_factory.mktemp("payload") / "sample"
    write_payload(out, 3)
    plain = yaml.safe_load((out / "payload.yaml").read_text())
    plain["logs"] = [each for each in plain["logs"] if each["role"] == "postures"]
    (out / "payload.yaml").write_text(yaml.safe_dump(plain))
    return out


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    made = Service(tmp_path_factory.mktemp("service"), workers=0, EXOGAUGE_SILENCE_S=str(SILENCE_S))
    made.url = made.start()
    yield made
    made.stop()
    assert "Traceback" not in (made.folder / "server.log").read_text()


@pytest.fixture(scope="module")
def payload(service: Service, folder: Path) -> str:
    with Client(service.url) as client:
        return client.upload_payload(folder).id


@pytest.fixture
def client(service: Service) -> Iterator[Client]:
    with Client(service.url) as opened:
        yield opened


@pytest.fixture(scope="module")
def rows(folder: Path) -> Array:
    """(2500, 13) the contact log."""
    table = pq.read_table(folder / "logs" / "contact.parquet")
    names = ["t", *(f"q.{joint}" for joint in generator.JOINTS), "fx", "fy", "fz", "mx", "my", "mz"]
    return np.column_stack([table[name].to_numpy() for name in names])


def opened(service: Service, payload: str, query: str = "") -> ClientConnection:
    address = service.url.replace("http", "ws", 1)
    return connect(
        f"{address}/api/v1/live/payload/{payload}{query}", open_timeout=30, max_size=None, compression=None,
        ping_interval=None,
    )  # fmt: skip


def begun(service: Service, payload: str, query: str = "") -> tuple[ClientConnection, str, dict[str, Any]]:
    line = opened(service, payload, query)
    stream = json.loads(line.recv(30))
    return line, stream["stream"], until(line, "welcome")[-1]


def until(line: ClientConnection, kind: str, timeout_s: float = 30.0) -> list[dict[str, Any]]:
    """Messages up to the first of a kind."""
    found = []
    end = time.monotonic() + timeout_s
    while not found or found[-1]["type"] != kind:
        found.append(json.loads(line.recv(end - time.monotonic())))
    return found


def packed(first: int, rows: Array) -> bytes:
    return struct.pack("<Q", first) + np.ascontiguousarray(rows, "<f8").tobytes()


def to_the_end(line: ClientConnection) -> tuple[list[dict[str, Any]], int]:
    """What is said until the line is closed, and the code of that."""
    found = list[dict[str, Any]]()
    with pytest.raises(ConnectionClosed) as closed:
        found.extend(json.loads(each) for each in iter(lambda: line.recv(30), None))
    assert closed.value.rcvd is not None
    return found, closed.value.rcvd.code


def process_of(stream: str) -> int:
    found = subprocess.run(["pgrep", "-f", f"live_process.*{stream}"], capture_output=True, text=True, check=True)
    return int(found.stdout.split()[0])


@pytest.mark.slow
def test_a_push_is_seen_live_and_the_recording_is_a_log_that_can_be_evaluated(
    client: Client, payload: str, rows: Array, folder: Path, tmp_path: Path
) -> None:
    messages = []
    with client.live(payload) as stream:
        assert stream.delay_s == 0.1
        for k in range(0, len(rows), 50):
            stream.send(rows[k : k + 50])
            messages += stream.received()
        ended = stream.end()
        messages += stream.received()
        key = stream.stream
    told = [each for each in messages if each["type"] == "wrench"]
    time_, wrench, alarm = (np.concatenate([each[name] for each in told]) for name in ("t", "wrench", "alarm"))
    assert ended["samples"] == len(rows) == len(time_)
    begin, length, force, _ = generator.PUSHES[0]
    assert begin < time_[alarm][0] < begin + length
    middle = np.abs(time_ - begin - length / 2) < 0.01
    assert wrench[middle, :3].mean(axis=0) == pytest.approx(force, abs=3.0)
    states = [each["state"] for each in messages if each["type"] == "payload"]
    assert states[0] == "static"
    assert "converging" in states
    assert key is not None
    log = client.live_log(key, tmp_path / "logs" / "recorded.parquet" if (tmp_path / "logs").mkdir() is None else "")
    table = pq.read_table(log)
    assert np.array_equal(np.column_stack([table[name].to_numpy() for name in stream.columns]), rows)
    plain = yaml.safe_load((folder / "payload.yaml").read_text())
    for each in plain["logs"]:
        (tmp_path / each["file"]).write_bytes((folder / each["file"]).read_bytes())
    plain["logs"].append({"file": "logs/recorded.parquet", "role": "contact"})
    (tmp_path / "payload.yaml").write_text(yaml.safe_dump(plain))
    (tmp_path / "arm.urdf").write_bytes((folder / "arm.urdf").read_bytes())
    touches = evaluate(open_payload(tmp_path)).touches["recorded"]
    assert any(begin < touch.start < begin + length for touch in touches)
    listed = client._http.get(f"payloads/{payload}/streams")["items"]
    mine = next(each for each in listed if each["id"] == key)
    assert (mine["state"], mine["samples"], mine["last_sequence"]) == ("ended", 2500, 2499)


@pytest.mark.slow
def test_json_says_what_binary_says(service: Service, payload: str, rows: Array) -> None:
    found = []
    for binary in (True, False):
        line, _, _ = begun(service, payload)
        with line:
            text = {"type": "samples", "seq": 0, "rows": rows[:100].tolist()}
            line.send(packed(0, rows[:100]) if binary else json.dumps(text))
            line.send(json.dumps({"type": "end"}))
            told, code = to_the_end(line)
        assert code == 1000
        found.append(np.concatenate([each["wrench"] for each in told if each["type"] == "wrench"]))
    assert np.array_equal(*found)
    assert len(found[0]) == 100


@pytest.mark.slow
def test_missing_doubled_disordered_and_late_samples_are_counted_and_survived(
    service: Service, payload: str, rows: Array
) -> None:
    line, _, _ = begun(service, payload)
    with line:
        line.send(packed(0, rows[:100]))
        line.send(packed(110, rows[110:200]))
        line.send(packed(150, rows[150:160]))
        line.send(packed(105, rows[105:106]))
        until(line, "wrench")
        time.sleep(1.2)
        line.send(packed(200, rows[200:210]))
        bad = rows[210:220].copy()
        bad[3, 5] = np.nan
        line.send(packed(210, bad))
        line.send(packed(220, rows[220:400]))
        line.send(json.dumps({"type": "end"}))
        told, _ = to_the_end(line)
    ended = told[-1]
    counts = ended["counts"]
    assert ended["type"] == "ended"
    assert (counts["missing"], counts["doubled"], counts["out_of_order"], counts["refused"]) == (9 + 1, 10, 1, 1)
    assert counts["late"] >= 10
    assert counts["taken"] == ended["samples"] == 100 + 90 + 10 + 9 + 180
    fault = next(each for each in told if each["type"] == "error")
    assert (fault["rule"], fault["row"]) == ("not_finite", 213)
    seq = np.concatenate([each["seq"] for each in told if each["type"] == "wrench"])
    assert seq[-1] == 399
    assert np.all(np.diff(seq) > 0)


NO_SAMPLES = [
    ("no JSON", "not_json"),
    ("[" * 100_000, "not_json"),
    ('{"type": "dance"}', "unknown_message"),
    ("17", "unknown_message"),
    ('{"type": "samples", "seq": -1, "rows": [[1]]}', "no_number"),
    ('{"type": "samples", "seq": 0, "rows": [[1, 2]]}', "wrong_size"),
    ('{"type": "samples", "seq": 0, "rows": "many"}', "wrong_size"),
    ('{"type": "samples", "seq": 0, "rows": [[1, [2]]]}', "wrong_size"),
    ('{"type": "samples", "seq": 123456789012345678901234567890, "rows": [' + str([0.0] * 13) + "]}", "no_number"),
    (b"", "wrong_size"),
    (b"\x00" * 15, "wrong_size"),
    (b"\xff" * (8 + 13 * 8), "no_number"),
    (b"\x00" * 8 + b"\xff" * 13 * 8, "not_finite"),
    (packed(0, np.zeros((1025, 13))), "too_many"),
    (packed(0, np.full((1, 13), 1e3)), "angle_too_large"),
]


@pytest.mark.slow
def test_what_is_no_sample_is_answered_with_its_rule_and_the_stream_goes_on(
    service: Service, payload: str, rows: Array
) -> None:
    line, _, _ = begun(service, payload)
    with line:
        for sent, rule in NO_SAMPLES:
            line.send(sent)
            told = until(line, "error")[-1]
            assert (told["rule"], bool(told["detail"]), bool(told["advice"])) == (rule, True, True)
        line.send(packed(500, rows[:30]))
        assert until(line, "wrench")[-1]["seq"][0] == 500
        line.send(json.dumps({"type": "end"}))
        assert to_the_end(line)[0][-1]["samples"] == 30


@pytest.mark.slow
def test_faults_without_end_close_the_line_and_the_stream_can_be_taken_up(service: Service, payload: str) -> None:
    line, stream, _ = begun(service, payload)
    with line:
        for _ in range(25):
            line.send("no JSON")
        told, code = to_the_end(line)
    assert (code, len(told)) == (1008, 20)
    line, again, welcome = begun(service, payload, f"?stream={stream}")
    with line:
        assert (again, welcome["next"]) == (stream, 0)
        line.send(json.dumps({"type": "end"}))
        to_the_end(line)


def test_a_flood_is_answered_with_the_rule(service: Service, payload: str, rows: Array) -> None:
    """10 kHz where 250 Hz were stated: as single samples, and as many in one message."""
    for size in (1, 500):
        line, _, _ = begun(service, payload)
        with line:
            began, sent = time.monotonic(), 0
            try:
                while time.monotonic() - began < 10.0:
                    line.send(packed(sent, rows[np.arange(sent, sent + size) % 2500]))
                    sent += size
                    time.sleep(max(0.0, sent / 10_000 - (time.monotonic() - began)))
            except ConnectionClosed:
                pass
            told, code = to_the_end(line)
        assert code == 1008
        fault = next(each for each in told if each["type"] == "error" and each["rule"] == "too_fast")
        by_samples = "250 Hz" in fault["detail"]
        assert by_samples or (size == 1 and "2000 messages" in fault["detail"])  # a slow machine sends fewer


def test_a_message_that_is_too_large_is_told(service: Service, payload: str) -> None:
    line, _, _ = begun(service, payload)
    with line:
        line.send(b"\x00" * 300_000)
        told, code = to_the_end(line)
    assert (code, told[-1]["rule"]) == (1008, "too_large")


def test_a_second_writer_is_refused_and_the_first_goes_on(service: Service, payload: str, rows: Array) -> None:
    line, stream, _ = begun(service, payload)
    with line:
        with pytest.raises(InvalidStatus) as refused:
            opened(service, payload, f"?stream={stream}")
        told = json.loads(refused.value.response.body)
        assert (told["status"], told["type"]) == (409, "urn:exogauge:problem:conflict")
        assert "one at a time" in told["detail"]
        line.send(packed(0, rows[:100]))
        assert until(line, "payload")
        line.send(json.dumps({"type": "end"}))
        to_the_end(line)
    with pytest.raises(InvalidStatus) as refused:
        opened(service, payload, f"?stream={stream}")
    assert "has ended" in json.loads(refused.value.response.body)["detail"]


@pytest.mark.parametrize(
    ("path", "status"),
    [
        ("00000000-0000-0000-0000-000000000000", 404),
        ("no-id", 422),
        ("PAYLOAD?rate_hz=fast", 422),
        ("PAYLOAD?rate_hz=1e9", 422),
        ("PAYLOAD?rate_hz=nan", 422),
        ("PAYLOAD?stream=00000000-0000-0000-0000-000000000000", 404),
        ("PAYLOAD?stream=x", 422),
    ],
)
def test_what_cannot_begin_is_a_problem_document(service: Service, payload: str, path: str, status: int) -> None:
    with pytest.raises(InvalidStatus) as refused:
        opened(service, path.replace("PAYLOAD", payload))
    assert refused.value.response.status_code == status
    assert refused.value.response.headers["content-type"] == "application/problem+json"
    assert json.loads(refused.value.response.body)["detail"]


def test_another_sites_page_and_another_name_are_refused(service: Service, payload: str) -> None:
    address = f"{service.url.replace('http', 'ws', 1)}/api/v1/live/payload/{payload}"
    with pytest.raises(InvalidStatus) as refused:
        connect(address, origin="https://elsewhere.example")
    assert refused.value.response.status_code == 403
    with pytest.raises(InvalidStatus) as refused:
        connect(address, additional_headers={"Sec-Fetch-Site": "cross-site"})
    assert refused.value.response.status_code == 403


def test_silence_ends_the_stream(service: Service, client: Client, payload: str, rows: Array) -> None:
    line, stream, _ = begun(service, payload)
    with line:
        line.send(packed(0, rows[:100]))
        began = time.monotonic()
        told, code = to_the_end(line)
    assert SILENCE_S - 0.5 < time.monotonic() - began < SILENCE_S + 3.0
    assert (code, told[-1]["type"], told[-1]["samples"]) == (1000, "ended", 100)
    listed = client._http.get(f"payloads/{payload}/streams")["items"]
    assert next(each for each in listed if each["id"] == stream)["state"] == "ended"


def test_a_broken_line_is_taken_up_where_it_was(service: Service, payload: str, rows: Array) -> None:
    line, stream, _ = begun(service, payload)
    line.send(packed(0, rows[:200]))
    until(line, "payload")
    line.socket.shutdown(socket.SHUT_RDWR)
    time.sleep(0.5)
    line, _, welcome = begun(service, payload, f"?stream={stream}")
    with line:
        assert welcome["next"] == 200
        line.send(packed(200, rows[200:400]))
        line.send(json.dumps({"type": "end"}))
        told, _ = to_the_end(line)
    assert told[-1]["samples"] == 400
    settled = np.concatenate([each["settled"] for each in told if each["type"] == "wrench"])
    assert settled[:-30].all()  # nothing began anew


def test_a_process_that_is_killed_loses_nothing_that_was_written(
    service: Service, client: Client, payload: str, rows: Array, tmp_path: Path
) -> None:
    messages = []
    with client.live(payload) as stream:
        for k in range(0, 1000, 10):
            stream.send(rows[k : k + 10])
            messages += stream.received()
            if k == 500:
                time.sleep(0.5)
                assert stream.stream is not None
                os.kill(process_of(stream.stream), signal.SIGKILL)
                time.sleep(0.5)
        ended = stream.end()
        messages += stream.received()
        log = client.live_log(stream.stream, tmp_path / "log.parquet")
    died = [each for each in messages if each["type"] == "error"]
    assert [each["rule"] for each in died] == ["stream_died"]
    assert ended["samples"] == 1000
    table = pq.read_table(log)
    assert np.array_equal(table["seq"].to_numpy(), np.arange(1000))
    assert np.array_equal(table["fx"].to_numpy(), rows[:1000, 7])


def test_a_ping_that_finds_the_line_broken_is_no_traceback(client: Client, payload: str, monkeypatch, caplog) -> None:
    """`keepalive ping failed`, with its trace, on standard error of whatever the process did next."""

    def broken(**_: object) -> None:
        raise BrokenPipeError

    with client.live(payload) as stream:
        line = stream._line
        assert line is not None
        monkeypatch.setattr(line, "ping", broken)
        monkeypatch.setattr(line, "ping_interval", 0.0)
        line.keepalive()
        stream.end()
    assert "ping" not in caplog.text


@pytest.mark.parametrize("attempt", range(3))
def test_a_writer_in_mid_sentence_hears_why_it_is_over(
    service: Service, payload: str, rows: Array, attempt: int
) -> None:
    line, stream, _ = begun(service, payload)
    seen = threading.Event()

    def talk() -> None:
        with contextlib.suppress(ConnectionClosed):
            for k in itertools.count():
                line.send(packed(k, rows[k % len(rows)][None]))
                time.sleep(0.002)
                if k == 50:
                    seen.set()

    talking = threading.Thread(target=talk)
    talking.start()
    assert seen.wait(30)
    os.kill(process_of(stream), signal.SIGKILL)
    told, code = to_the_end(line)
    talking.join(30)
    assert (code, told[-1]["rule"]) == (1011, "stream_died")


def test_a_stream_to_which_nobody_comes_back_is_kept_as_lost(
    service: Service, client: Client, payload: str, rows: Array, tmp_path: Path
) -> None:
    line, stream, _ = begun(service, payload)
    line.send(packed(0, rows[:300]))
    until(line, "payload")
    time.sleep(0.3)
    os.kill(process_of(stream), signal.SIGKILL)
    told, code = to_the_end(line)
    assert (code, told[-1]["rule"]) == (1011, "stream_died")
    end = time.monotonic() + SILENCE_S + PATIENCE_S
    while time.monotonic() < end:
        listed = client._http.get(f"payloads/{payload}/streams")["items"]
        found = next(each for each in listed if each["id"] == stream)
        if found["state"] == "lost":
            break
        time.sleep(0.2)
    assert found["state"] == "lost"
    assert pq.read_table(client.live_log(stream, tmp_path / "lost.parquet")).num_rows == 300


def test_more_streams_than_may_be_are_refused(folder: Path, tmp_path: Path) -> None:
    made = Service(tmp_path, workers=0, EXOGAUGE_MAX_LIVE_STREAMS="1")
    made.url = made.start()
    try:
        with Client(made.url) as client:
            key = client.upload_payload(folder).id
        line, _, _ = begun(made, key)
        with line, pytest.raises(InvalidStatus) as refused:
            opened(made, key)
        assert refused.value.response.status_code == 503
        assert "EXOGAUGE_MAX_LIVE_STREAMS" in json.loads(refused.value.response.body)["detail"]
    finally:
        made.stop()


def test_a_server_that_was_killed_leaves_streams_that_can_be_taken_up(
    folder: Path, tmp_path: Path, rows: Array
) -> None:
    made = Service(tmp_path, workers=0)
    made.url = made.start()
    with Client(made.url) as client:
        key = client.upload_payload(folder).id
    line, stream, _ = begun(made, key)
    line.send(packed(0, rows[:300]))
    until(line, "payload")
    time.sleep(0.3)
    assert made.process is not None
    made.process.kill()
    made.process.wait()
    made.url = made.start()
    try:
        line, _, welcome = begun(made, key, f"?stream={stream}")
        with line:
            assert welcome["next"] == 300
            line.send(packed(300, rows[300:400]))
            line.send(json.dumps({"type": "end"}))
            told, _ = to_the_end(line)
        assert told[-1]["samples"] == 400
    finally:
        made.stop()


def test_a_payload_that_cannot_be_followed_says_why(service: Service, tmp_path: Path) -> None:
    """A rotation without a position."""
    for path, content in payload_files().items():
        (tmp_path / path).parent.mkdir(exist_ok=True)
        (tmp_path / path).write_bytes(content)
    with Client(service.url) as client:
        key = client.upload_payload(tmp_path).id
        with pytest.raises(ClientProblem, match="how the sensor accelerates"):
            client.live(key)
