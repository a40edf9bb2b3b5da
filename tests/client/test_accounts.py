"""A real server with accounts that encrypts, the commands beside its database, and a client that signed in."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx
import pytest

from exogauge.client import Client, ClientProblem
from exogauge.client.tokens import refuse_open_line

pytestmark = pytest.mark.slow
WORDS = "three old lamps glow"


@pytest.fixture(scope="module")
def certificate(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    if shutil.which("openssl") is None:
        pytest.skip("there is no openssl here")
    folder = tmp_path_factory.mktemp("tls")
    made, key = folder / "cert.pem", folder / "key.pem"
    name = ["-subj", "/CN=localhost", "-addext", "subjectAltName=IP:127.0.0.1"]
    command = ["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-keyout", key, "-out", made]
    subprocess.run([*command, *name], check=True, capture_output=True)
    return {"EXOGAUGE_TLS_CERTIFICATE": str(made), "EXOGAUGE_TLS_KEY": str(key)}


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory, service_of: Any, certificate: dict[str, str]) -> Iterator[Any]:
    made = service_of(tmp_path_factory.mktemp("accounts"), workers=0, EXOGAUGE_ACCOUNTS="1", **certificate)
    made.url = made.start()
    yield made
    made.stop()


def exogauge(
    service: Any, *arguments: str, typed: str = "", home: Path | None = None
) -> subprocess.CompletedProcess[str]:
    environment = {**service.environment, "SSL_CERT_FILE": service.environment["EXOGAUGE_TLS_CERTIFICATE"]}
    environment |= {} if home is None else {"XDG_CONFIG_HOME": str(home)}
    command = [sys.executable, "-m", "exogauge.cli", *arguments]
    return subprocess.run(command, env=environment, input=typed, capture_output=True, text=True, timeout=120)


def test_from_the_first_account_at_a_terminal_to_a_token_in_a_client(
    service: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert service.url.startswith("https://")
    assert "/set-up takes the code" in (service.folder / "server.log").read_text()
    add = ("account", "add", "ada@example.org", "--name", "Ada", "--lab", "North", "--role", "admin")
    refused = exogauge(service, *add, typed="short\n")
    assert (refused.returncode, "15 to 256 letters" in refused.stderr) == (2, True)
    assert exogauge(service, *add, typed=f"{WORDS}\n").returncode == 0
    listed = exogauge(service, "account").stdout
    assert "ada@example.org" in listed
    assert "North (admin)" in listed

    monkeypatch.setenv("SSL_CERT_FILE", service.environment["EXOGAUGE_TLS_CERTIFICATE"])
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    with Client(service.url) as nobody, pytest.raises(ClientProblem, match="Not signed in"):
        list(nobody.studies())
    login = ("login", service.url, "--email", "ada@example.org", "--read-only")
    wrong = exogauge(service, *login, typed="wrong\n", home=tmp_path)
    assert (wrong.returncode, "address or the password is wrong" in wrong.stderr) == (2, True)
    done = exogauge(service, *login, typed=f"{WORDS}\n", home=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "lab North" in done.stdout
    kept = tmp_path / "exogauge" / "tokens.json"
    assert kept.stat().st_mode & 0o777 == 0o600
    with Client(service.url) as client:
        assert client.session()["lab"]["role"] == "viewer"
        assert list(client.studies()) == []
        with pytest.raises(ClientProblem, match="takes the role member"):
            client.submit("0" * 36)
    with Client("https://127.0.0.2:1") as other:
        assert other._token is None  # kept for that address alone
    answer = httpx.post(f"{service.url}/api/v1/session", json={"email": "ada@example.org", "password": WORDS})
    assert answer.headers["set-cookie"].startswith("__Host-exogauge=")

    assert exogauge(service, "account", "lock", "ada@example.org").returncode == 0
    with Client(service.url) as client, pytest.raises(ClientProblem, match="Not signed in"):
        list(client.studies())
    assert exogauge(service, "account", "unlock", "ada@example.org").returncode == 0
    assert exogauge(service, "logout", service.url, home=tmp_path).returncode == 0
    with Client(service.url) as nobody, pytest.raises(ClientProblem, match="Not signed in"):
        list(nobody.studies())
    assert "EXOGAUGE_TOKEN" not in os.environ


def test_a_password_stays_on_this_machine_or_goes_encrypted() -> None:
    for url in ("https://exo.example", "http://127.0.0.1:8765", "http://localhost:8765", "http://[::1]:1"):
        refuse_open_line(url)
    for url in ("http://exo.example", "http://10.0.0.1", "http://localhost.evil.example"):
        with pytest.raises(ClientProblem, match="not encrypted"):
            refuse_open_line(url)
