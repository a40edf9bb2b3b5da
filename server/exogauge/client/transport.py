"""What the service answers when it cannot do what was asked, in words a person can act on.

HTTP with patience: every POST carries an idempotency key, so that it may be sent again.

A request is sent again when the connection broke, or when the service says that it cannot serve *now*
(429, 502, 503, 504), at most `ATTEMPTS` times with growing pauses. The key makes a repeated POST harmless: the
service answers the second one with what it answered to the first.
"""

from __future__ import annotations

import time
import uuid
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Any, final

import httpx

from exogauge.client.things import Job
from exogauge.errors import ExogaugeError


class ClientProblem(ExogaugeError):
    """An RFC 9457 answer. `status`, `title`, `detail`, and `errors` with file, row, column, value where known."""

    def __init__(self, status: int, title: str, detail: str = "", errors: list[dict[str, Any]] | None = None) -> None:
        self.status, self.title, self.detail, self.errors = status, title, detail, errors or []
        lines = [f"{title} ({status})" if status else title]
        if detail and detail != title:
            lines[0] += f": {detail}"
        told = [readable(error) for error in self.errors]
        super().__init__("\n".join(lines + [f"  - {text}" for text in told if text != detail]))


def problem_of_job(job: Job) -> ClientProblem:
    """Why a job that has ended did not succeed."""
    told = job.problem or {}
    detail = str(told.get("detail") or job.reason or "")
    return ClientProblem(0, f"the job {job.state}", detail, list(told.get("errors") or []))


def readable(error: dict[str, Any]) -> str:
    """One entry of `errors` as a sentence: where, what, with which value, what to do."""
    place = [str(error["file"])] if error.get("file") else []
    if error.get("row") is not None:
        place.append(f"row {error['row']}")
    if error.get("column"):
        place.append(f"column {error['column']!r}")
    if not place and error.get("pointer"):
        place.append(str(error["pointer"]))
    text = ": ".join([", ".join(place), str(error.get("detail", ""))] if place else [str(error.get("detail", ""))])
    if error.get("value") is not None:
        text += f" (value: {error['value']})"
    return f"{text}. {error['advice']}" if error.get("advice") else text


def problem_of(response: httpx.Response) -> ClientProblem:
    """The problem in a 4xx or 5xx answer; an answer that is no problem document is quoted."""
    try:
        body = response.json()
    except ValueError:
        body = None
    if not isinstance(body, dict):
        return ClientProblem(response.status_code, response.reason_phrase or "error", response.text[:500])
    return ClientProblem(
        response.status_code,
        str(body.get("title", response.reason_phrase)),
        str(body.get("detail") or ""),
        [error for error in body.get("errors") or [] if isinstance(error, dict)],
    )


ATTEMPTS = 7  # in 13 s: a key of a server that was killed is free after 10 s
FIRST_PAUSE_S = 0.2
BUSY = {429, 502, 503, 504}
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
        headers = {} if token is None else {"Authorization": f"Bearer {token}"}
        base = url.rstrip("/") + "/api/v1/"
        self._http = httpx.Client(
            base_url=base, headers=headers, timeout=timeout_s, transport=transport, follow_redirects=False
        )

    def get(self, path: str, params: Mapping[str, Any] | None = None) -> Any:
        """GET, as JSON."""
        return self._send("GET", path, params=dict(params or {})).json()

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
        return self._send("POST", path, headers=headers, **content).json()

    def put(self, path: str, body: Any) -> Any:
        """PUT JSON, which may be sent again as it is."""
        return self._send("PUT", path, json=body).json()

    def delete(self, path: str) -> None:
        """DELETE; what an attempt whose answer was lost has deleted is not there any more."""
        self._send("DELETE", path)

    def begin(self, path: str, headers: Mapping[str, str]) -> Any:
        """POST that says all in its headers; one idempotency key for all attempts."""
        return self._send("POST", path, headers={**headers, "Idempotency-Key": str(uuid.uuid4())}).json()

    def once(self, method: str, path: str, **request: Any) -> httpx.Response:
        """One attempt; the caller judges what comes back, and catches httpx.TransportError."""
        return self._once(method, path, **request)

    def ask(self, path: str, body: Any) -> Any:
        """POST of a question that changes nothing: no key, for the answer need not be kept; sent again all the same."""
        return self._send("POST", path, json=body).json()

    def download(self, path: str, target: Path) -> Path:
        """GET to a file, written beside it first, so that `target` is whole or absent."""
        partial = target.with_name(target.name + ".partial")
        with self._http.stream("GET", path) as response:
            if response.is_error:
                response.read()
                raise problem_of(response)
            with partial.open("wb") as file:
                for chunk in response.iter_bytes(CHUNK):
                    file.write(chunk)
        return partial.replace(target)

    def _send(self, method: str, path: str, **request: Any) -> httpx.Response:
        pause = FIRST_PAUSE_S
        for attempt in range(1, ATTEMPTS + 1):
            try:
                response = self._once(method, path, **request)
            except httpx.TransportError as error:
                if attempt == ATTEMPTS:
                    address = self._http.base_url
                    raise ClientProblem(0, f"no answer from {address}", str(error) or type(error).__name__) from error
            else:
                gone = method == "DELETE" and response.status_code == 404 and attempt > 1
                if response.is_success or gone:
                    return response
                if not (response.status_code in BUSY or in_flight(response)) or attempt == ATTEMPTS:
                    raise problem_of(response)
            time.sleep(pause)
            pause *= 2
        raise AssertionError("unreachable")

    def _once(self, method: str, path: str, files: Mapping[str, Path] | None = None, **request: Any) -> httpx.Response:
        """One attempt; files are opened anew for each."""
        with ExitStack() as stack:
            if files:
                opened = {field: (file.name, stack.enter_context(file.open("rb"))) for field, file in files.items()}
                request["files"] = opened
            return self._http.request(method, path, **request)

    def close(self) -> None:
        self._http.close()


def in_flight(response: httpx.Response) -> bool:
    """The first request with this key is still being served (its connection broke, the work did not)."""
    return response.status_code == 409 and "Retry-After" in response.headers
