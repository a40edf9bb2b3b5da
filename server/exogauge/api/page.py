"""The web app: one document for every page's address, and the files that it loads.

The document is the same everywhere but for three things: the base that its relative addresses start from, found from
the depth of the address asked for, so that it works below any path of a proxy; a key for the style elements that
scripts make; and the sizes that this installation takes.
"""

from __future__ import annotations

import html
import json
import secrets
from pathlib import Path
from typing import Annotated

from fastapi import Path as PathParameter
from fastapi import Request
from fastapi.responses import FileResponse, HTMLResponse, Response
from starlette.convertors import Convertor, register_url_convertor
from starlette.exceptions import HTTPException

from exogauge.api.dependencies import SettingsDep
from exogauge.api.routing import Router
from exogauge.settings import Settings, packaged_folder

router = Router(root="", include_in_schema=False)

PLACES = (  # the first part of a page's address
    "", "studies", "import", "robots", "devices", "payloads", "motions", "plans", "compare",
    "sign-in", "set-up", "invited", "account", "lab", "published",
)  # fmt: skip
BASE, NONCE, LIMITS = '<base href="/" />', 'nonce=""', 'name="limits" content=""'
FOREVER = "public, max-age=31536000, immutable"  # names hold a hash of the content
MEDIA_TYPES = {
    ".js": "text/javascript",
    ".css": "text/css",
    ".svg": "image/svg+xml",
    ".png": "image/png",
    ".woff2": "font/woff2",
    ".json": "application/json",
    ".wasm": "application/wasm",
}
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self' 'nonce-{nonce}'; img-src 'self' data: blob:; "
    "connect-src 'self'; frame-src 'self'; font-src 'self'; base-uri 'self'; form-action 'none'; "
    "frame-ancestors 'none'"
)
MISSING = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>exogauge: no web app</title></head>
<body><h1>The web app is not built</h1>
<p>The service runs, and its API answers under <a href="{base}api/v1/openapi.json">api/v1</a>.
Only the pages are missing.</p>
<ul><li>In a checkout of the source, run <code>make web</code> and load this page again.</li>
<li>An installation made with <code>EXOGAUGE_WITHOUT_WEB</code> set has no pages: install it again without.</li></ul>
</body></html>
"""


class PagePath(Convertor[str]):
    """Any path that is not the API's."""

    regex = r"(?!/*api(?:/|$)).*"

    def convert(self, value: str) -> str:
        return value

    def to_string(self, value: str) -> str:
        return value


register_url_convertor("page", PagePath())


@router.get("/assets/{name}")
def get_asset(name: Annotated[str, PathParameter(pattern=r"^[\w.-]+$")]) -> FileResponse:
    """A file that the build made; its name changes with its content."""
    return built_file(f"assets/{name}", FOREVER)


@router.get("/icon.svg")
def get_icon() -> FileResponse:
    return built_file("icon.svg", "no-cache")


@router.get("/{path:page}")
def get_page(path: str, request: Request, settings: SettingsDep) -> Response:
    """The document: 200 for a page, 404 for what is none; who asks for something else than a page gets a problem."""
    known = path.split("/")[0] in PLACES and not path.startswith("/")
    if not known and "text/html" not in request.headers.get("accept", ""):
        raise HTTPException(404)
    base = "../" * path.count("/") or "./"
    nonce = secrets.token_urlsafe(16)
    headers = {"Content-Security-Policy": POLICY.format(nonce=nonce), "Cache-Control": "no-cache"}
    folder = built()
    if folder is None:
        return HTMLResponse(MISSING.format(base=base), 503, headers)
    text = (folder / "index.html").read_text(encoding="utf-8")
    for before, after in (
        (BASE, f'<base href="{base}" />'),
        (NONCE, f'nonce="{nonce}"'),
        (LIMITS, f'name="limits" content="{html.escape(json.dumps(limits(settings)))}"'),
    ):
        text = text.replace(before, after, 1)
    return HTMLResponse(text, 200 if known else 404, headers)


def limits(settings: Settings) -> dict[str, int]:
    """What a page says before anything is sent."""
    return {
        "upload_bytes": settings.max_upload_bytes,
        "bundle_bytes": settings.max_bundle_bytes,
        "bundle_files": settings.max_bundle_files,
    }


def built_file(name: str, caching: str) -> FileResponse:
    folder = built()
    media_type = MEDIA_TYPES.get(Path(name).suffix)
    if folder is None or media_type is None or not (folder / name).is_file():
        raise HTTPException(404)
    return FileResponse(folder / name, media_type=media_type, headers={"Cache-Control": caching})


def built() -> Path | None:
    """The folder of the built web app; None where it was left out."""
    try:
        folder = packaged_folder("web")
    except FileNotFoundError:
        return None
    return folder if (folder / "index.html").is_file() else None
