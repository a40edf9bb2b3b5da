"""Sight of the children that read files."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import pytest

Children = Callable[[], list[int]]


@pytest.fixture
def children() -> Children:
    """children(): process ids of the running readers of this process, which its fork server started."""
    if not Path("/proc/self/environ").exists():
        pytest.skip("needs /proc")
    return _running


def _running() -> list[int]:
    servers = [pid for pid in below(os.getpid()) if b"fork_server" in Path(f"/proc/{pid}/cmdline").read_bytes()]
    return [pid for server in servers for pid in below(server)]


def below(parent: int) -> list[int]:
    found = []
    for entry in Path("/proc").iterdir():
        try:
            state, its = (entry / "stat").read_text().rpartition(")")[2].split()[:2] if entry.name.isdigit() else "Z0"
        except OSError:
            continue
        if int(its) == parent and state != "Z":
            found.append(int(entry.name))
    return found
