"""Real recordings, kept beside the repository; without them these tests skip and say so."""

from __future__ import annotations

import json
import os
import sysconfig
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest

from exogauge.studies.evaluate import evaluate

DATA = Path(__file__).parents[2] / ".." / "shared" / "data"
ROBOTS = Path(sysconfig.get_path("purelib")) / "cmeel.prefix/share/example-robot-data/robots"


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


@pytest.fixture(scope="session")
def fixed_arm() -> Callable[[Path, str, tuple[str, ...]], None]:
    """fixed_arm(folder, urdf, joints): writes robot.yaml and the URDF of a robot of `example-robot-data`."""

    def write(folder: Path, urdf: str, joints: tuple[str, ...]) -> None:
        (folder / "robot.urdf").write_bytes((ROBOTS / urdf).read_bytes())
        (folder / "robot.yaml").write_text(
            "version: 1\nurdf: robot.urdf\nbase: fixed\njoints:\n"
            + "".join(f"  - {{name: {joint}, actuation: torque}}\n" for joint in joints)
        )

    return write


@pytest.fixture(scope="session")
def answer() -> Callable[..., Mapping[str, Any]]:
    """answer(study file, settings): results.json of the study."""

    def run(study: Path, **settings: Any) -> Mapping[str, Any]:
        out = study.parent / f"results_{study.stem}"
        evaluate(study, out, lambda _fraction, _phrase: None, settings)
        found: Mapping[str, Any] = json.loads((out / "results.json").read_text())
        return found

    return run
