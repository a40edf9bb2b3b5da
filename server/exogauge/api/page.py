"""The plain page at `/` and its two files; everything is relative, so it works under a sub-path too."""

from __future__ import annotations

from typing import Literal

from fastapi import APIRouter
from fastapi.responses import FileResponse

from exogauge.settings import packaged_folder

router = APIRouter(include_in_schema=False)
FILES = {"page.js": "text/javascript", "page.css": "text/css", "icon.svg": "image/svg+xml"}


@router.get("/")
def get_page() -> FileResponse:
    return FileResponse(packaged_folder("web") / "index.html", media_type="text/html")


@router.get("/web/{name}")
def get_page_file(name: Literal["page.js", "page.css", "icon.svg"]) -> FileResponse:
    return FileResponse(packaged_folder("web") / name, media_type=FILES[name])
