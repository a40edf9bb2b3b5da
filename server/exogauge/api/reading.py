"""What a request says, read strictly: of two meanings none is taken, and what nobody would read is refused.

JSON twice under one key, NaN and numbers beyond any float have no one meaning (RFC 8259, 4 and 6). A form that ends
before its last boundary lost files on its way. A misspelt parameter would list everything, and an `If-Match` that
nothing is compared with would delete what its sender had not seen.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import AsyncGenerator, Callable, Coroutine, Iterable
from email.message import Message
from email.utils import collapse_rfc2231_value
from typing import Any, NoReturn, final

from fastapi import Request, Response, params
from fastapi.dependencies.utils import get_flat_params
from fastapi.exceptions import RequestValidationError
from fastapi.routing import APIRoute
from starlette.datastructures import FormData
from starlette.exceptions import HTTPException
from starlette.formparsers import MultiPartException, MultiPartParser

FORM, ENCODED = "multipart/form-data", "application/x-www-form-urlencoded"
JSON = re.compile(r"application/([^/]+\+)?json")
IF_MATCH = "if-match"
UNSAFE = {"POST", "PUT", "PATCH", "DELETE"}
IN_TEXT = ("base64", "quoted-printable")  # ways of a mail to send bytes, which no form of HTTP has (RFC 7578, 4.7)


@final
class Asked(Request):
    """A request whose JSON and forms are read as told above."""

    async def json(self) -> Any:
        if not hasattr(self, "_json"):
            self._json = json_in(await self.body())
        return self._json

    async def _get_form(self, **limits: Any) -> FormData:
        if self._form is None and media_type(self) == FORM:
            try:
                self._form = await Parts(self.headers, self.stream(), **limits).parse()
            except MultiPartException as error:
                raise HTTPException(400, f"the form cannot be read: {error.message}") from error
        return await super()._get_form(**limits)


class Route(APIRoute):
    """One that refuses what it would not read. asks_anything: any query."""

    asks_anything = False

    def get_route_handler(self) -> Callable[[Request], Coroutine[Any, Any, Response]]:
        answer, taken = super().get_route_handler(), get_flat_params(self.dependant)
        known = [field.alias for field in taken if isinstance(field.field_info, params.Query)]
        compares = any(field.alias.lower() == IF_MATCH for field in taken)
        body = self.body_field
        takes = None if body is None else ENCODED if isinstance(body.field_info, params.Form) else "JSON"

        async def read(request: Request) -> Response:
            if not self.asks_anything:
                refuse_unknown(request, known)
            if not compares and request.method in UNSAFE and request.headers.get(IF_MATCH, "*").strip() != "*":
                raise HTTPException(412, "nothing here has an ETag that If-Match could name; leave it away")
            if takes is not None:
                refuse_other_kind(request, takes)
            return await answer(Asked(request.scope, request.receive, request._send))

        return read


@final
class AnyQuery(Route):
    """What others append something to: the addresses of pages and publications, a provider's word."""

    asks_anything = True


def refuse_unknown(request: Request, known: Iterable[str]) -> None:
    """422 for query parameters that nobody reads."""
    unknown = sorted(set(request.query_params) - set(known))
    if unknown:
        told = f"no such parameter; there are {', '.join(sorted(known))}" if known else "no parameter is taken here"
        raise RequestValidationError(
            [{"type": "unknown_parameter", "loc": ("query", name[:80]), "msg": told} for name in unknown]
        )


def refuse_other_kind(request: Request, takes: str) -> None:
    """415 where the body says that it is something else than what is read; takes: `JSON` or a kind of form."""
    headers, kind = request.headers, media_type(request)
    if headers.get("content-length", "0") == "0" and "transfer-encoding" not in headers:
        return
    if takes == "JSON" and not JSON.fullmatch(kind):
        raise HTTPException(415, f"send JSON as `Content-Type: application/json`; this came {said(kind)}")
    if takes != "JSON" and kind not in (FORM, ENCODED):
        raise HTTPException(415, f"send the file as {FORM}; this came {said(kind)}")


def said(kind: str) -> str:
    return f"as {kind[:80]}" if kind else "without one"


def media_type(request: Request) -> str:
    return request.headers.get("content-type", "").partition(";")[0].strip().lower()


def json_in(body: bytes) -> Any:
    """UTF-8, UTF-16 or UTF-32, with a byte order mark or without. Raises JSONDecodeError."""
    encoding = json.detect_encoding(body)
    try:
        text = body.decode(encoding)
    except UnicodeDecodeError as error:
        raise json.JSONDecodeError(f"byte {error.start} is no {encoding.upper()}", "", 0) from None
    try:
        return json.loads(text, object_pairs_hook=once, parse_constant=refuse_constant, parse_float=finite)
    except RecursionError:
        raise json.JSONDecodeError("too deeply nested", "", 0) from None
    except json.JSONDecodeError:
        raise
    except ValueError:  # Python's limit of the digits of an integer
        raise json.JSONDecodeError("a number has too many digits", "", 0) from None


def once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) < len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for name in names if names.count(name) > 1)
        raise json.JSONDecodeError(f"{twice[:80]!a} stands twice in one object", "", 0)
    return found


def refuse_constant(name: str) -> NoReturn:
    raise json.JSONDecodeError(f"{name} stands in it; null says that there is no number", "", 0)


def finite(text: str) -> float:
    value = float(text)
    if math.isinf(value):
        raise json.JSONDecodeError(f"{text[:80]} is too large for a number", "", 0)
    return value


@final
class Parts(MultiPartParser):
    """A form that is whole or refused. A file's name may also come as older clients write what is not ASCII
    (`filename*`, RFC 5987), which RFC 7578 asks senders not to do, and .NET does beside a `filename` that is none."""

    whole = False

    def __init__(self, headers: Any, stream: AsyncGenerator[bytes, None], **limits: Any) -> None:
        super().__init__(headers, stream, **limits)

    def on_headers_finished(self) -> None:
        part = self._current_part
        encoding = dict(part.item_headers).get(b"content-transfer-encoding", b"").strip().lower().decode("latin-1")
        if encoding in IN_TEXT:
            raise MultiPartException(f"a part came as {encoding}; send its bytes as they are")
        name = extended_name((part.content_disposition or b"").decode("latin-1"))
        if name is not None:  # the last one counts
            quoted = name.replace("\\", "\\\\").replace('"', '\\"').encode(self._charset, "replace")
            part.content_disposition = (part.content_disposition or b"") + b'; filename="' + quoted + b'"'
        super().on_headers_finished()

    def on_end(self) -> None:
        self.whole = True

    async def parse(self) -> FormData:
        try:
            found = await super().parse()
        except MultiPartException as error:
            if error.__cause__ is None:
                raise
            raise MultiPartException(f"{error.__cause__}; is its boundary that of its Content-Type?") from error
        if not self.whole:
            for file in self._files_to_close_on_error:
                file.close()
            raise MultiPartException("it ends before its last boundary, so it did not arrive whole; send it again")
        return found


def extended_name(disposition: str) -> str | None:
    header = Message()
    header["content-disposition"] = disposition
    found = header.get_params(header="content-disposition") or []
    return next(
        (collapse_rfc2231_value(value) for name, value in found if name == "filename" and isinstance(value, tuple)),
        None,
    )
