"""Two servers, processes of their own, on one database: a request under a key is answered by one of them."""

from __future__ import annotations

import os
import signal
import socket
import time
from urllib.parse import urlsplit

import httpx
import pytest

from exogauge.api.idempotency import LEASE

KEY = {"Idempotency-Key": "k1", "Content-Type": "multipart/form-data; boundary=BOUND"}


@pytest.mark.slow
def test_a_key_is_the_first_server_s_while_it_serves_and_free_after_it_was_killed(
    make_service, database_url, study_folder
):
    body = b"".join(
        b'--BOUND\r\nContent-Disposition: form-data; name="files"; filename="%s"\r\n\r\n' % name.encode()
        + (study_folder / name).read_bytes()
        + b"\r\n"
        for name in ("robot.yaml", "robot.urdf")
    )
    body += b"--BOUND--\r\n"
    first, second = (make_service(database_url=database_url, workers=0) for _ in range(2))
    place, url = urlsplit(first.start()), second.start()
    with socket.create_connection((place.hostname, place.port)) as line:
        head = [f"POST /api/v1/robots HTTP/1.1\r\nHost: {place.netloc}\r\nContent-Length: {len(body)}"]
        head += [f"{name}: {value}" for name, value in KEY.items()]
        line.sendall("\r\n".join(head).encode() + b"\r\n\r\n" + body[:100])
        time.sleep(2.0)
        asked, held_until = time.monotonic(), time.monotonic() + 1.2 * LEASE.total_seconds()
        while time.monotonic() < held_until:  # longer than the lease, which is put off
            answer = httpx.post(f"{url}/api/v1/robots", content=body, headers=KEY)
            assert answer.status_code == 409, answer.text
            time.sleep(1.0)
        assert time.monotonic() - asked > LEASE.total_seconds()
        os.kill(first.process.pid, signal.SIGKILL)
        first.process.wait()
        killed = time.monotonic()
        while (answer := httpx.post(f"{url}/api/v1/robots", content=body, headers=KEY, timeout=30)).status_code == 409:
            assert time.monotonic() - killed < LEASE.total_seconds() + 5.0
            time.sleep(0.5)
    assert answer.status_code == 201, answer.text
    again = httpx.post(f"{url}/api/v1/robots", content=body, headers=KEY)
    assert again.headers["Idempotency-Replayed"] == "true"
    assert again.json() == answer.json()
