"""A real server with accounts that encrypts, the commands beside its database, and a client that signed in."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx
import pytest

from exogauge.cli import main
from exogauge.client import Client, ClientProblem
from exogauge.client.tokens import keep, refuse_open_line, token_by_password

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
    made.start()
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
    assert (wrong.returncode, "address or the password is wrong" in wrong.stderr) == (4, True)
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


def test_commands_do_what_their_token_may_and_show_it_to_nobody(
    service: Any, study_folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("SSL_CERT_FILE", service.environment["EXOGAUGE_TLS_CERTIFICATE"])
    monkeypatch.setenv("EXOGAUGE_URL", service.url)
    secrets = {}
    for name in ("eve", "bob"):
        who = f"{name}@example.org"
        add = ("account", "add", who, "--lab", f"Lab of {name}", "--role", "member")
        assert exogauge(service, *add, typed=f"{WORDS}\n").returncode == 0
        secrets[name] = token_by_password(service.url, who, WORDS, "write", None, 1)
    viewer = token_by_password(service.url, "bob@example.org", WORDS, "read", None, 1)

    def ended(token: str, *arguments: str) -> tuple[int, str]:
        monkeypatch.setenv("EXOGAUGE_TOKEN", token)
        code = main(["-v", *arguments])
        out, err = capfd.readouterr()
        assert not any(each in out + err for each in (*secrets.values(), viewer))
        assert "Traceback" not in err
        return code, out + err

    code, said = ended(secrets["bob"], "upload", str(study_folder), "--json")
    study = json.loads(said[said.index("{") : said.rindex("}") + 1])["id"]
    assert (code, ended(secrets["bob"], "studies")[1].count(study)) == (0, 1)
    assert ended(secrets["eve"], "studies")[1].count(study) == 0
    for command in (("results", study), ("run", study, "--server", service.url), ("share", study, "--all")):
        code, said = ended(secrets["eve"], *command)
        assert (code, "Not found (404)" in said) == (2, True), command
    code, said = ended(viewer, "upload", str(study_folder))
    assert (code, "role member" in said) == (4, True)
    assert ended("exo_none_such", "studies")[0] == 4
    assert ended(secrets["bob"], "share", study, "--lab", "Lab of eve")[1].startswith("Lab of eve\n")
    assert ended(secrets["eve"], "run", study, "--server", service.url)[0] in (2, 4)  # reads it, and no more
    assert ended(secrets["bob"], "share", study, "--end")[1].startswith("nobody else\n")

    page = {"Origin": service.url}
    with httpx.Client(base_url=f"{service.url}/api/v1/", headers=page) as browser:
        browser.post("session", json={"email": "bob@example.org", "password": WORDS}).raise_for_status()
        for each in browser.get("tokens").json()["items"]:
            browser.delete(f"tokens/{each['id']}").raise_for_status()
    code, said = ended(secrets["bob"], "studies")
    assert (code, "Not signed in (401)" in said) == (4, True)

    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    keep(service.url, secrets["eve"])
    monkeypatch.delenv("EXOGAUGE_TOKEN")
    assert main(["studies"]) == 0
    (tmp_path / "exogauge" / "tokens.json").chmod(0o644)
    assert main(["studies"]) == 2
    assert "others may read the tokens" in capfd.readouterr().err


def test_a_password_stays_on_this_machine_or_goes_encrypted() -> None:
    for url in ("https://exo.example", "http://127.0.0.1:8765", "http://localhost:8765", "http://[::1]:1"):
        refuse_open_line(url)
    for url in ("http://exo.example", "http://10.0.0.1", "http://localhost.evil.example"):
        with pytest.raises(ClientProblem, match="not encrypted"):
            refuse_open_line(url)
