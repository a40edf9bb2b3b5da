"""The token that a service wants: given, from EXOGAUGE_TOKEN, or kept by `exogauge login` for that service alone."""

from __future__ import annotations

import json
import os
import socket
from ipaddress import ip_address
from pathlib import Path
from urllib.parse import urlsplit

import httpx

from exogauge.client.problems import ClientProblem, NotNow, problem_of
from exogauge.client.transport import address, document
from exogauge.errors import BadInput, Fault

VARIABLE = "EXOGAUGE_TOKEN"


def token_for(url: str) -> str | None:
    return os.environ.get(VARIABLE) or kept().get(url.rstrip("/"))


def file() -> Path:
    base = os.environ.get("XDG_CONFIG_HOME")
    return (Path(base) if base else Path.home() / ".config") / "exogauge" / "tokens.json"


def kept() -> dict[str, str]:
    """address -> token. BadInput where others may read them."""
    try:
        with file().open(encoding="utf-8") as opened:
            mode = os.fstat(opened.fileno()).st_mode
            found = json.load(opened)
    except (OSError, ValueError, RuntimeError):  # RuntimeError: there is no home
        return {}
    if mode & 0o077 and os.name == "posix":
        detail = f"others may read the tokens in it (mode {mode & 0o777:o})"
        raise BadInput(Fault(detail, "open_tokens", f"chmod 600 {file()}, and revoke them if others did.", str(file())))
    return found if isinstance(found, dict) else {}


def keep(url: str, token: str | None) -> Path:
    """Readable by its owner alone, from its first byte; None forgets it."""
    tokens = {key: value for key, value in kept().items() if key != url.rstrip("/")}
    tokens |= {} if token is None else {url.rstrip("/"): token}
    path = file()
    path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
    new = path.with_name(f".{path.name}.{os.getpid()}")
    with os.fdopen(os.open(new, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600), "w", encoding="utf-8") as out:
        json.dump(tokens, out, indent=1)
    return new.replace(path)


def token_by_password(url: str, email: str, password: str, scope: str, lab: str | None, days: int | None) -> str:
    """A new token of the account, for this machine; the session that made it ends. lab: its name, where the account is
    of several."""
    url = address(url)
    refuse_open_line(url)
    page = {"Origin": "{0.scheme}://{0.netloc}".format(urlsplit(url))}
    with httpx.Client(base_url=f"{url}/api/v1/", headers=page, timeout=30.0) as http:

        def ask(method: str, path: str, body: object = None) -> httpx.Response:
            try:
                answer = http.request(method, path, json=body)
            except httpx.TransportError as error:
                raise NotNow(0, f"no answer from {url}", str(error)) from error
            if not answer.is_success:
                raise problem_of(answer)
            return answer

        ask("POST", "session", {"email": email, "password": password})
        try:
            found = document(ask("GET", "session"))
            if lab is not None:
                key = next((each["id"] for each in found["labs"] if each["name"] == lab), None)
                if key is None:
                    names = ", ".join(each["name"] for each in found["labs"]) or "none"
                    raise ClientProblem(0, f"you are of no lab {lab!r}", f"your labs: {names}")
                ask("PUT", "session/lab", {"lab_id": key})
            wanted = {"name": f"exogauge on {socket.gethostname()}"[:200], "scope": scope, "days": days}
            secret: str = document(ask("POST", "tokens", wanted))["secret"]
        finally:
            ask("DELETE", "session")
    return secret


def refuse_open_line(url: str) -> None:
    """A password leaves this machine over an encrypted line."""
    parts = urlsplit(url)
    if parts.scheme == "https":
        return
    name = parts.hostname or ""
    try:
        here = ip_address(name).is_loopback
    except ValueError:
        here = name == "localhost"
    if not here:
        raise ClientProblem(0, f"{url} is not encrypted", "a password goes over https, or stays on this machine")
