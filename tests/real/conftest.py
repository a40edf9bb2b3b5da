"""Real recordings, kept beside the repository; without them these tests skip and say so."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import pytest

DATA = Path(__file__).parents[2] / ".." / "shared" / "data"


@pytest.fixture(scope="session")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Path]:
    """recording(name, files): a new study folder that holds those files of a recording."""

    def place(name: str, files: tuple[str, ...]) -> Path:
        source = Path(os.path.normpath(DATA)) / name
        if not source.is_dir():
            pytest.skip(f"the recording {name!r} is not beside the repository (../shared/data/{name})")
        folder = tmp_path_factory.mktemp(name)
        for file in files:
            (folder / file).write_bytes((source / file).read_bytes())
        return folder

    return place
