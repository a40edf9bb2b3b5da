"""Webhooks: told once each, signed, only over https to where they may go, again and again, and no more where nobody
listens."""

from __future__ import annotations

import contextlib
import json
import shutil
import ssl
import subprocess
import threading
import time
from collections.abc import Iterator
from datetime import UTC, datetime, timedelta
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import pytest
import sqlalchemy as sa
from standardwebhooks import Webhook as Verifier

from exogauge.jobs import claims
from exogauge.settings import Settings
from exogauge.storage import webhooks
from exogauge.storage.files import PinnedFile
from exogauge.storage.store import Installation, Storage
from exogauge.storage.tables import AuditEntry, Delivery, Job, Webhook, WorkerLease, utc_now
from exogauge.storage.webhooks import AGAIN
from exogauge.upkeep import public_line
from exogauge.upkeep.postman import Postman
from exogauge.upkeep.public_line import NoAnswer, Refused, checked, is_public, post

SECOND = timedelta(seconds=1)


class Listener:
    """An https server on this machine. status: what it answers; came: (headers, body) of each POST."""

    def __init__(self, certificate: Path, key: Path) -> None:
        self.status, self.came, self.says_slowly = 204, list[tuple[dict[str, str], bytes]](), False
        listener = self

        class Handler(BaseHTTPRequestHandler):
            def do_POST(self) -> None:
                body = self.rfile.read(int(self.headers["Content-Length"]))
                listener.came.append(({name.lower(): value for name, value in self.headers.items()}, body))
                if listener.says_slowly:
                    with contextlib.suppress(OSError):
                        for letter in b"HTTP/1.1 204 No Content" * 10:
                            self.wfile.write(bytes([letter]))
                            time.sleep(0.1)
                    return
                self.send_response(listener.status)
                self.send_header("Location", f"https://localhost:{self.server.server_port}/elsewhere")  # type: ignore[attr-defined]
                self.send_header("Content-Length", "0")
                self.end_headers()

            def log_message(self, format: str, *args: object) -> None:
                pass

        self.server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        context.load_cert_chain(certificate, key)
        self.server.socket = context.wrap_socket(self.server.socket, server_side=True)
        self.url = f"https://localhost:{self.server.server_port}/hook"
        self._thread = threading.Thread(target=self.server.serve_forever)
        self._thread.start()

    def close(self) -> None:
        self.server.shutdown()
        self._thread.join()
        self.server.server_close()


@pytest.fixture(scope="session")
def certificate(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    if shutil.which("openssl") is None:
        pytest.skip("there is no openssl here")
    folder = tmp_path_factory.mktemp("tls")
    made, key = folder / "cert.pem", folder / "key.pem"
    command = ["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes"]
    name = ["-days", "2", "-subj", "/CN=localhost", "-addext", "subjectAltName=DNS:localhost"]
    subprocess.run([*command, *name, "-keyout", key, "-out", made], check=True, capture_output=True)
    return made, key


@pytest.fixture
def listener(certificate: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch) -> Iterator[Listener]:
    monkeypatch.setenv("SSL_CERT_FILE", str(certificate[0]))
    made = Listener(*certificate)
    yield made
    made.close()


@pytest.fixture
def installation(storage: Storage) -> Installation:
    return Installation(storage.engine, storage.blobs)


@pytest.fixture
def north(installation: Installation) -> Storage:
    return installation.of_lab("north")


@pytest.fixture
def postman(installation: Installation, settings: Settings) -> Postman:
    return Postman(installation, settings.model_copy(update={"webhook_private_hosts": "localhost"}))


def add(north: Storage, url: str) -> tuple[str, str]:
    with north.transaction() as store:
        made, secret = store.webhooks.add(url, ["job.ended", "publication.published"])
    return made.id, secret


def only(installation: Installation, table: type[Any] = Delivery) -> Any:
    with installation.session() as session:
        row = session.scalars(sa.select(table)).one()
        session.expunge(row)
    return row


def make_due(installation: Installation) -> None:
    with installation.session() as session:
        session.execute(sa.update(Delivery).values(due_at=utc_now() - SECOND))


def test_a_delivery_arrives_once_with_a_signature_that_others_verify(
    north: Storage, installation: Installation, postman: Postman, listener: Listener
) -> None:
    key, secret = add(north, listener.url)
    with north.transaction() as store:
        store.webhooks.tell("publication.published", {"url": "https://exo.example/published/x"})
        store.webhooks.tell("publication.revoked", {"url": "not asked for"})
    assert postman.round() == 1
    assert postman.round() == 0
    ((headers, body),) = listener.came
    told = Verifier(secret).verify(body, headers)
    assert told["type"] == "publication.published"
    assert told["data"] == {"url": "https://exo.example/published/x"}
    assert datetime.fromisoformat(told["timestamp"]).tzinfo is not None
    with pytest.raises(Exception, match="No matching signature"):
        Verifier(secret).verify(body.replace(b"exo", b"evil"), headers)
    row = only(installation)
    assert (row.state, row.status, row.webhook_id, headers["webhook-id"]) == ("delivered", 204, key, row.id)
    assert secret not in json.dumps([str(each) for each in vars(row).values()])


def test_what_is_rolled_back_is_not_told(north: Storage, installation: Installation, listener: Listener) -> None:
    add(north, listener.url)
    with contextlib.suppress(RuntimeError), north.transaction() as store:
        store.webhooks.tell("job.ended", {})
        raise RuntimeError
    with installation.session() as session:
        assert session.scalar(sa.select(sa.func.count(Delivery.id))) == 0


@pytest.mark.parametrize("status", [500, 404, 302, 307])
def test_what_is_not_taken_comes_again_later_and_a_redirect_leads_nowhere(
    north: Storage, installation: Installation, postman: Postman, listener: Listener, status: int
) -> None:
    add(north, listener.url)
    with north.transaction() as store:
        store.webhooks.tell("job.ended", {"job_id": "x"})
    listener.status = status
    before = datetime.now(UTC)
    postman.round()
    row = only(installation)
    assert (row.state, row.attempts, row.status) == ("waiting", 1, status)
    assert timedelta(0) < row.due_at - before < 2 * AGAIN[0] + timedelta(minutes=1)
    assert len(listener.came) == 1, "nobody followed"
    make_due(installation)
    listener.status = 200
    postman.round()
    assert only(installation).state == "delivered"
    ids = [headers["webhook-id"] for headers, _ in listener.came]
    assert ids[0] == ids[1], "one id, however often it is tried"


def test_an_address_that_takes_nothing_is_told_no_more_until_it_is_enabled(
    north: Storage, installation: Installation, postman: Postman, listener: Listener
) -> None:
    key, _ = add(north, listener.url)
    with north.transaction() as store:
        store.webhooks.tell("job.ended", {"job_id": "x"})
    listener.status = 503
    for attempt in range(1, len(AGAIN) + 2):
        make_due(installation)
        assert postman.round() == 1
        row = only(installation)
        assert row.attempts == attempt
        assert (row.state == "failed") == (attempt == len(AGAIN) + 1)
    make_due(installation)
    assert postman.round() == 0
    hook = only(installation, Webhook)
    assert "503" in hook.disabled_because
    with installation.session() as session:
        assert session.scalars(sa.select(AuditEntry.action).where(AuditEntry.actor == "postman")).all() == ["disable"]
    with north.transaction() as store:
        store.webhooks.tell("job.ended", {"job_id": "y"})
        assert len(store.webhooks.deliveries(key, None, 10).items) == 1
        store.webhooks.enable(key)
        store.webhooks.ping(key)
    listener.status = 200
    assert postman.round() == 1


def test_an_address_that_says_it_is_gone_is_told_no_more_at_once(
    north: Storage, installation: Installation, postman: Postman, listener: Listener
) -> None:
    add(north, listener.url)
    with north.transaction() as store:
        store.webhooks.tell("job.ended", {"job_id": "x"})
        store.webhooks.tell("job.ended", {"job_id": "y"})
    listener.status = 410
    postman.round()
    assert only(installation, Webhook).disabled_at is not None
    assert postman.round() == 0
    assert len(listener.came) == 1


def test_a_name_with_a_private_address_gets_nothing(
    north: Storage, installation: Installation, settings: Settings, listener: Listener
) -> None:
    add(north, listener.url)
    with north.transaction() as store:
        store.webhooks.tell("job.ended", {"job_id": "x"})
    Postman(installation, settings).round()
    row = only(installation)
    assert (row.state, row.status, listener.came) == ("waiting", None, [])
    assert "private address" in row.said
    for url in ("https://127.0.0.1/x", "https://[::1]/x", "https://169.254.169.254/latest/meta-data"):
        with pytest.raises(Refused, match="private address"):
            post(url, b"", {})


def test_who_says_a_letter_now_and_then_holds_up_nobody(listener: Listener, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(public_line, "WHOLE_S", 1.0)
    listener.says_slowly = True
    began = time.monotonic()
    with pytest.raises(NoAnswer, match="ReadTimeout"):
        post(listener.url, b"{}", {}, ["localhost"])
    assert time.monotonic() - began < 5.0  # each letter comes well within the time of a step


def test_a_certificate_of_another_name_gets_nothing(listener: Listener) -> None:
    with pytest.raises(Exception, match=r"CERTIFICATE_VERIFY_FAILED|IP address mismatch"):
        post(listener.url.replace("localhost", "127.0.0.1"), b"{}", {}, ["127.0.0.1"])
    assert listener.came == []


@pytest.mark.parametrize(
    "address",
    [
        "127.0.0.1", "10.0.0.1", "172.16.5.4", "192.168.1.1", "169.254.169.254", "100.64.0.1", "0.0.0.0", "224.0.0.1",
        "255.255.255.255", "192.0.2.1", "::1", "::", "fe80::1%eth0", "fc00::1", "::ffff:127.0.0.1", "::ffff:10.0.0.1",
        "64:ff9b::7f00:1", "2002:7f00:1::", "2001:0:1::", "ff02::1", "2001:db8::1", "::127.0.0.1", "::ffff:0:10.0.0.1",
        "fec0::1", "5f00::1", "3fff::1", "4000::1",
    ],
)  # fmt: skip
def test_addresses_that_are_not_of_the_internet(address: str) -> None:
    assert not is_public(address)


@pytest.mark.parametrize("address", ["1.1.1.1", "93.184.216.34", "2606:4700::1111", "::ffff:1.1.1.1"])
def test_addresses_that_are(address: str) -> None:
    assert is_public(address)


@pytest.mark.parametrize(
    "url",
    ["http://exo.example", "ftp://exo.example", "https://", "https://a:b@exo.example", "https://exo.example/#x",
     "https://[exo.example", "https://[10.0.0.1]", "https://exo.example:0", "https://exo.example:99999",
     f"https://exo.example/{'x' * 2000}"],
)  # fmt: skip
def test_addresses_that_are_no_webhook(url: str) -> None:
    with pytest.raises(Refused):
        checked(url)


@pytest.mark.parametrize("state", ["succeeded", "failed", "cancelled"])
def test_the_end_of_a_job_is_told_once_in_its_own_lab(installation: Installation, north: Storage, state: str) -> None:
    add(north, "https://north.example")
    with installation.of_lab("south").transaction() as store:
        store.webhooks.add("https://south.example", ["job.ended"])
    with north.transaction() as store:
        sha = store.blobs.put(b"{}")
        study, _ = store.studies.add("s", [PinnedFile("study.yaml", sha, 2)], {})
        job = Job(kind="evaluate", study_id=study.id, request_hash="h", state="running", worker="w")
        store.session.add(job)
        store.session.flush()
        store.session.add(WorkerLease(worker_id="w", beat_at=utc_now(), started_at=utc_now(), host="h", pid=1))
        record = store.jobs.get(job.id)
    for expected in (True, False):
        with north.transaction() as store:
            done = {
                "succeeded": lambda s=store: claims.succeed(
                    s.session, record, "w", (PinnedFile("results.json", sha, 2),)
                ),
                "failed": lambda s=store: claims.fail(s.session, record.id, "w", "why"),
                "cancelled": lambda s=store: claims.end_cancelled(s.session, record.id, "w"),
            }[state]()
            assert done == expected
    row = only(installation)
    said = {"job_id": record.id, "kind": "evaluate", "state": state, "study_id": study.id}
    assert (row.lab_id, row.event, row.data) == ("north", "job.ended", said)


def test_a_delivery_is_held_by_one_postman_and_comes_again_when_that_one_died(
    north: Storage, installation: Installation
) -> None:
    add(north, "https://north.example")
    with north.transaction() as store:
        store.webhooks.tell("job.ended", {})
    with installation.session() as session:
        assert len(webhooks.take_due(session, 10)) == 1
    with installation.session() as session:
        assert webhooks.take_due(session, 10) == []
    make_due(installation)
    with installation.session() as session:
        (again,) = webhooks.take_due(session, 10)
    assert again.attempts == 2
