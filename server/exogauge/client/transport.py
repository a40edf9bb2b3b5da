"""HTTP with patience: every POST carries an idempotency key, so that it may be sent again.

A request is sent again when the connection broke, or when the service says that it cannot serve *now*
(429, 502, 503, 504), at most `ATTEMPTS` times with growing pauses. The key makes a repeated POST harmless: the
service answers the second one with what it answered to the first.
"""

from __future__ import annotations

import hashlib
import hmac
import os
import time
import uuid
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Any, BinaryIO, final
from urllib.parse import urlsplit

import httpx

from exogauge.client.problems import BUSY, ClientProblem, NotNow, foreign, problem_of
from exogauge.errors import BadInput, Fault

ATTEMPTS = 7  # in 13 s: a key of a server that was killed is free after 10 s
FIRST_PAUSE_S, LONGEST_PAUSE_S = 0.2, 10.0
CHUNK = 1 << 20


@final
class Transport:
    """Sends requests below one base address and returns answers that are not problems."""

    def __init__(
        self,
        url: str,
        timeout_s: float = 60.0,
        transport: httpx.BaseTransport | None = None,
        token: str | None = None,
    ) -> None:
        self._token = sendable(token)
        headers = {"Authorization": f"Bearer {self._token}"} if self._token else {}
        base = address(url) + "/api/v1/"
        self._http = httpx.Client(
            base_url=base, headers=headers, timeout=timeout_s, transport=transport, follow_redirects=False
        )

    def get(self, path: str, params: Mapping[str, Any] | None = None) -> Any:
        """GET, as JSON."""
        return document(self._send("GET", path, params=dict(params or {})))

    def text(self, path: str, params: Mapping[str, Any] | None = None) -> str:
        """GET, as text that is no page."""
        response = self._send("GET", path, params=dict(params or {}))
        if is_page(response):
            raise foreign(response)
        return response.text

    def post(
        self,
        path: str,
        body: Any = None,
        files: Mapping[str, Path] | None = None,
        form: Mapping[str, str] | None = None,
    ) -> Any:
        """POST JSON, or a form with files (field -> path); one idempotency key for all attempts."""
        headers = {"Idempotency-Key": str(uuid.uuid4())}
        content = {"data": form, "files": files} if files else {"json": body}
        return document(self._send("POST", path, headers=headers, **content))

    def put(self, path: str, body: Any) -> Any:
        """PUT JSON, which may be sent again as it is."""
        return document(self._send("PUT", path, json=body))

    def delete(self, path: str) -> None:
        """DELETE; what an attempt whose answer was lost has deleted is not there any more."""
        self._send("DELETE", path)

    def begin(self, path: str, headers: Mapping[str, str], key: str | None = None) -> str:
        """The id of what a POST makes that says all in its headers; one idempotency key for all attempts."""
        response = self._send("POST", path, headers={**headers, "Idempotency-Key": key or str(uuid.uuid4())})
        if "id" not in (made := document(response)):
            raise foreign(response)
        return str(made["id"])

    def own_key(self, text: str) -> str:
        """An idempotency key that whoever has our token says for `text` each time, and nobody else can guess."""
        return hmac.new(self._token.encode(), text.encode(), hashlib.sha256).hexdigest()

    def once(self, method: str, path: str, **request: Any) -> httpx.Response:
        """One attempt; the caller judges what comes back, and catches httpx.TransportError."""
        return self._once(method, path, **request)

    def ask(self, path: str, body: Any) -> Any:
        """POST of a question that changes nothing: no key, for the answer need not be kept; sent again all the same."""
        return document(self._send("POST", path, json=body))

    def download(self, path: str, target: Path, sha256: str | None = None) -> Path:
        """GET to a file, written beside it first, so that `target` is whole or absent.

        sha256: of its bytes, where it is known; then a file that has them is left as it is, and others are refused.
        """
        if has(target, sha256):
            return target
        partial = target.with_name(f".{target.name}.{os.getpid()}")
        try:
            target.parent.mkdir(parents=True, exist_ok=True)
            response = self._patiently(lambda: self._to_file(path, partial, page=target.suffix == ".html"))
            if not partial.is_file():
                raise foreign(response)
            if sha256 is not None and not has(partial, sha256):
                raise NotNow(0, f"{target.name} did not arrive as the service has it", "its SHA-256 is another")
            return partial.replace(target)
        except OSError as error:
            advice = "Name another place, or make room there."
            detail = f"it cannot be written: {error.strerror}"
            raise BadInput(Fault(detail, "cannot_write", advice, str(target))) from error
        finally:
            if partial.is_file():
                partial.unlink()

    def _to_file(self, path: str, target: Path, page: bool) -> httpx.Response:
        """page: whether HTML is what is asked for."""
        with self._http.stream("GET", path) as response:
            if not response.is_success or (is_page(response) and not page):
                response.read()
                return response
            with target.open("wb") as file:
                for chunk in response.iter_bytes(CHUNK):
                    file.write(chunk)
        return response

    def _send(self, method: str, path: str, **request: Any) -> httpx.Response:
        return self._patiently(lambda: self._once(method, path, **request), deletes=method == "DELETE")

    def _patiently(self, send: Callable[[], httpx.Response], deletes: bool = False) -> httpx.Response:
        pause = FIRST_PAUSE_S
        for attempt in range(1, ATTEMPTS + 1):
            try:
                response = send()
            except httpx.TransportError as error:
                if attempt == ATTEMPTS:
                    detail = f"{error or type(error).__name__}. Does the service run, and is that its address?"
                    raise NotNow(0, f"no answer from {self._http.base_url}", detail) from error
                asked = 0.0
            else:
                gone = deletes and response.status_code == 404 and attempt > 1
                if response.is_success or gone:
                    return response
                if not (response.status_code in BUSY or in_flight(response)) or attempt == ATTEMPTS:
                    raise problem_of(response)
                asked = retry_after(response)
            time.sleep(max(pause, asked))
            pause *= 2
        raise AssertionError("unreachable")

    def _once(self, method: str, path: str, files: Mapping[str, Path] | None = None, **request: Any) -> httpx.Response:
        """One attempt; files are opened anew for each."""
        with ExitStack() as stack:
            if files:
                opened = {field: (file.name, stack.enter_context(opened_file(file))) for field, file in files.items()}
                request["files"] = opened
            return self._http.request(method, path, **request)

    def close(self) -> None:
        self._http.close()


def address(url: str) -> str:
    """Of a service, without a slash at its end. Raises BadInput where it is none."""
    try:
        parts = urlsplit(url)
        fits = parts.scheme in ("http", "https") and bool(parts.hostname) and (parts.port or 1) > 0
    except ValueError:
        fits = False
    if not fits or not url.isprintable() or " " in url:
        advice = "Write http:// or https://, a host, and its port where it has one of its own."
        raise BadInput(Fault("this is no address of a service", "no_address", advice, value=url[:200]))
    return url.rstrip("/")


def sendable(token: str | None) -> str:
    """Without the line's end that a file leaves behind it. Raises ClientProblem for what is no token."""
    token = (token or "").strip()
    if not (token.isascii() and token.isprintable()):
        raise ClientProblem(401, "the token is none", "it holds letters that no token has; make a new one")
    return token


def in_flight(response: httpx.Response) -> bool:
    """The first request with this key is still being served (its connection broke, the work did not)."""
    return response.status_code == 409 and "Retry-After" in response.headers


def retry_after(response: httpx.Response) -> float:
    """Seconds that the answer asks for, within reason."""
    told = response.headers.get("Retry-After", "")
    return min(float(told), LONGEST_PAUSE_S) if told.isdecimal() else 0.0


def document(response: httpx.Response) -> Any:
    """The JSON of an answer. Raises ClientProblem where something else has answered in the service's place."""
    try:
        found = response.json()
    except ValueError:
        found = None
    if not isinstance(found, dict):
        raise foreign(response)
    return found


def is_page(response: httpx.Response) -> bool:
    return bool(response.headers.get("content-type", "").startswith("text/html"))


def digest(file: Path) -> str:
    """SHA-256 of its bytes."""
    with file.open("rb") as source:
        return hashlib.file_digest(source, "sha256").hexdigest()


def has(file: Path, sha256: str | None) -> bool:
    """Whether it is there, with these bytes."""
    return sha256 is not None and file.is_file() and digest(file) == sha256


def opened_file(file: Path) -> BinaryIO:
    try:
        return file.open("rb")
    except OSError as error:
        advice = "Name a file that can be read, or a folder that holds what is handed in."
        raise BadInput(Fault(f"it cannot be read: {error.strerror}", "no_file", advice, str(file))) from error
