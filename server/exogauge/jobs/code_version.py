"""Which code a process runs: the release and a hash of its source, so that a changed program never hands out old
results. A server and a worker may differ while an installation is upgraded; a job names both.

Files are hashed when this module is imported, which programs that serve or compute do first. What they import later may
have been replaced by then: `hold_to` ends a process that is about to import such a file.
"""

from __future__ import annotations

import hashlib
import os
import sys
from collections.abc import Mapping, Sequence
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec, PathFinder
from pathlib import Path
from types import ModuleType
from typing import final

from exogauge import __version__

PACKAGE = Path(__file__).resolve().parents[1]
SOURCE = (".py", ".html", ".j2")
OUTDATED = 75  # exit code of a process whose files have changed (EX_TEMPFAIL: asked again, it may work)


def hashed() -> dict[str, str]:
    """SHA-256 of each of the package's files as it is now, by its path within the package."""
    found = dict[str, str]()
    for folder, below, names in os.walk(PACKAGE):
        below[:] = sorted(name for name in below if name not in ("_packaged", "__pycache__"))
        for name in sorted(names):
            if name.endswith(SOURCE):
                path = Path(folder, name)
                try:
                    found[path.relative_to(PACKAGE).as_posix()] = hashlib.sha256(path.read_bytes()).hexdigest()
                except OSError:  # while they are replaced
                    continue
    return found


def version_of(files: Mapping[str, str]) -> str:
    digest = hashlib.sha256("".join(f"{path}\0{files[path]}\0" for path in sorted(files)).encode())
    return f"{__version__}+{digest.hexdigest()[:12]}"


AT_START = hashed()


def code_version() -> str:
    """`0.1.0+1f3a…`: 12 hex digits over the names and bytes of the package's files when this process started."""
    return version_of(AT_START)


def outdated() -> bool:
    """Whether the files are others by now: what starts from here on would be of two versions."""
    return hashed() != AT_START


@final
class OnlyThisCode(MetaPathFinder):
    """Ends the process where a module of this package would come from a file that is not the one of the start; no
    exception does, as what computes may catch it and go on."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        if not fullname.startswith("exogauge."):
            return None
        found = PathFinder.find_spec(fullname, path, target)
        inside = fullname.partition(".")[2].replace(".", "/")
        was = AT_START.get(f"{inside}.py") or AT_START.get(f"{inside}/__init__.py")
        if was is not None and (found is None or found.origin is None or digest_of(found.origin) != was):
            print(f"{fullname} is not what it was when this process started", file=sys.stderr, flush=True)
            os._exit(OUTDATED)
        return found


def digest_of(file: str) -> str | None:
    try:
        return hashlib.sha256(Path(file).read_bytes()).hexdigest()
    except OSError:
        return None


def hold_to(version: str) -> None:
    """From now on this process imports files of that version and no others, and ends with `OUTDATED` instead."""
    if code_version() != version:
        sys.exit(OUTDATED)
    sys.meta_path.insert(0, OnlyThisCode())
