"""What was fetched in the place of a file: a pointer of Git LFS, a web page."""

from __future__ import annotations

import re


def stands_in(head: bytes) -> tuple[str, str] | None:
    """What it is and what to do, from its first bytes; None where it may be the file itself."""
    if head.startswith(b"version https://git-lfs"):
        return "a pointer of Git LFS", "`git lfs pull` fetches the file"
    if re.match(rb"\s*(<!doctype html|<html)", head.removeprefix(b"\xef\xbb\xbf")[:500], re.IGNORECASE):
        return "a web page", "Download the file itself, not the page that shows it"
    return None
