"""HTTP with patience: every POST carries an idempotency key, so that it may be sent again.

A request is sent again when the connection broke, or when the service says that it cannot serve *now*
(429, 502, 503, 504), at most `ATTEMPTS` times with growing pauses. The key makes a repeated POST harmless: the
service answers the second one with what it answered to the first.
"""

from __future__ import annotations

import time
import uuid
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, final

import httpx

from exogauge.client.problem import ClientProblem, problem_of

ATTEMPTS = 6
FIRST_PAUSE_S = 0.2
BUSY = {429, 502, 503, 504}
CHUNK = 1 << 20

FormFiles = Callable[[], list[tuple[str, tuple[str, Any, str]]]]


@final
class Transport:
    """Sends requests below one base address and returns answers that are not problems."""

    def __init__(self, url: str, timeout_s: float = 60.0, transport: httpx.BaseTransport | None = None) -> None:
        self._http = httpx.Client(
            base_url=url.rstrip("/") + "/api/v1/", timeout=timeout_s, transport=transport, follow_redirects=False
        )

    def get(self, path: str, params: Mapping[str, Any] | None = None) -> Any:
        """GET, as JSON."""
        return self._send("GET", path, params=dict(params or {})).json()

    def post(self, path: str, body: Any = None, files: FormFiles | None = None, form: Any = None) -> Any:
        """POST JSON, or a form with files (`files()` opens them anew for each attempt); one key for all attempts."""
        headers = {"Idempotency-Key": str(uuid.uuid4())}
        return self._send("POST", path, headers=headers, json=body, files=files, data=form).json()

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

    def _send(self, method: str, path: str, files: FormFiles | None = None, **request: Any) -> httpx.Response:
        pause = FIRST_PAUSE_S
        for attempt in range(1, ATTEMPTS + 1):
            try:
                response = self._http.request(method, path, files=files() if files else None, **request)
            except httpx.TransportError as error:
                if attempt == ATTEMPTS:
                    address = self._http.base_url
                    raise ClientProblem(0, f"no answer from {address}", str(error) or type(error).__name__) from error
            else:
                if response.is_success:
                    return response
                if response.status_code not in BUSY or attempt == ATTEMPTS:
                    raise problem_of(response)
            time.sleep(pause)
            pause *= 2
        raise AssertionError("unreachable")

    def close(self) -> None:
        self._http.close()
