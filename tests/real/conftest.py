"""Real recordings, kept beside the repository; without them these tests skip and say so."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from tests.real.recordings.placing import is_there, place

from exogauge.studies.evaluate import evaluate


@pytest.fixture(scope="session")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Path]:
    """recording(name, files): a new study folder that holds those files of a recording."""

    def placed(name: str, files: tuple[str, ...]) -> Path:
        if not is_there(name):
            pytest.skip(f"the recording {name!r} is not beside the repository (../shared/data/{name})")
        folder = tmp_path_factory.mktemp(name)
        place(name, files, folder)
        return folder

    return placed


@pytest.fixture(scope="session")
def answer() -> Callable[..., Mapping[str, Any]]:
    """answer(study file, settings): results.json of the study, evaluated once, however often it is asked for."""

    @cache
    def run(study: Path, **settings: Any) -> Mapping[str, Any]:
        out = study.parent / f"results_{study.stem}"
        evaluate(study, out, lambda *_: None, settings)
        found: Mapping[str, Any] = json.loads((out / "results.json").read_text())
        return found

    return run
