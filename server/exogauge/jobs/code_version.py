"""Which code a process runs: the release and a hash of its source, so that a changed program never hands out old
results. A server and a worker may differ while an installation is upgraded; a job names both."""

from __future__ import annotations

import hashlib
from functools import cache
from pathlib import Path

from exogauge import __version__


@cache
def code_version() -> str:
    """`0.1.0+1f3a…`: 12 hex digits over the names and bytes of the package's files."""
    package = Path(__file__).resolve().parents[1]
    digest = hashlib.sha256()
    for path in sorted(path for path in package.rglob("*") if path.suffix in (".py", ".html", ".j2")):
        if "_packaged" not in path.parts:
            digest.update(path.relative_to(package).as_posix().encode() + b"\0" + path.read_bytes() + b"\0")
    return f"{__version__}+{digest.hexdigest()[:12]}"
