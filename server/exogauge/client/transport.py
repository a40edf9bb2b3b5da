"""What the service answers when it cannot do what was asked, in words a person can act on.

HTTP with patience: every POST carries an idempotency key, so that it may be sent again.

A request is sent again when the connection broke, or when the service says that it cannot serve *now*
(429, 502, 503, 504), at most `ATTEMPTS` times with growing pauses. The key makes a repeated POST harmless: the
service answers the second one with what it answered to the first.
"""

from __future__ import annotations

import hashlib
import hmac
import os
import re
import time
import uuid
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Any, BinaryIO, final

import httpx

from exogauge.client.things import Job
from exogauge.errors import BadInput, ExogaugeError, Fault

ATTEMPTS = 7  # in 13 s: a key of a server that was killed is free after 10 s
FIRST_PAUSE_S, LONGEST_PAUSE_S = 0.2, 10.0
BUSY = {429, 502, 503, 504}
CHUNK = 1 << 20
QUOTED = 200  # letters of an answer that is none of ours


class ClientProblem(ExogaugeError):
    """An RFC 9457 answer. `status`, `title`, `detail`, and `errors` with file, row, column, value where known."""

    def __init__(self, status: int, title: str, detail: str = "", errors: list[dict[str, Any]] | None = None) -> None:
        self.status, self.title, self.detail, self.errors = status, title, detail, errors or []
        lines = [f"{title} ({status})" if status else title]
        if detail and detail != title:
            lines[0] += f": {detail}"
        told = [readable(error) for error in self.errors]
        super().__init__("\n".join(lines + [f"  - {text}" for text in told if text != detail]))

    @property
    def later(self) -> bool:
        """Whether the same may do, asked again later."""
        return self.status in BUSY


@final
class NotNow(ClientProblem):
    """No answer, or none in the time given."""

    @property
    def later(self) -> bool:
        return True


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
    """The problem in a 4xx or 5xx answer; an answer that is no problem document is told as one of somebody else."""
    try:
        body = response.json()
    except ValueError:
        body = None
    if not isinstance(body, dict):
        return foreign(response)
    return ClientProblem(
        response.status_code,
        str(body.get("title", response.reason_phrase)),
        str(body.get("detail") or ""),
        [error for error in body.get("errors") or [] if isinstance(error, dict)],
    )


def foreign(response: httpx.Response) -> ClientProblem:
    """An answer that exogauge does not give: of a proxy before it, or of whatever else is at the address."""
    status, kind = response.status_code, response.headers.get("content-type", "").partition(";")[0]
    if response.is_redirect:
        there = plain(response.headers.get("location", ""))
        advice = "Give the address that it leads to; where that asks to sign in, a proxy does not let programs pass"
        return ClientProblem(status, f"{response.url.host} leads elsewhere", f"to {there}. {advice}")
    said = plain(response.text)
    told = f"{kind or 'nothing'}{f', {said!r}' if said else ''}"
    if response.is_success:
        advice = "Is it the address of the service, and does a proxy before it ask to sign in?"
        return ClientProblem(status, f"{response.url.host} does not answer as exogauge does", f"{told}. {advice}")
    return ClientProblem(status, response.reason_phrase or "error", f"not by exogauge: {told}")


def plain(text: str) -> str:
    """The first words of a page, without what a terminal would act on."""
    words = re.sub(r"(?is)<(script|style)\b.*?</\1>|<[^>]*>|\x1b\[[0-9;]*[a-z]", " ", text[: 50 * QUOTED]).split()
    return "".join(each for each in " ".join(words) if each.isprintable())[:QUOTED]


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
        self._token = token or ""
        base = url.rstrip("/") + "/api/v1/"
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
