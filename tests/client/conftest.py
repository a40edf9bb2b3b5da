"""A real service: `burning.py serve` with its workers, as a user would start it."""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from exogauge.client import Client, Study

TESTS = Path(__file__).parents[1]
PROGRAM = TESTS / "jobs" / "burning.py"
ANNOUNCED = "exogauge serves on "


class Service:
    """Started on a free port; `start` again after a kill finds the same data."""

    def __init__(self, folder: Path, database_url: str = "", workers: int = 1, **more: str) -> None:
        self.folder = folder
        self.environment = {
            **os.environ,
            "EXOGAUGE_DATA_DIR": str(folder / "data"),
            "EXOGAUGE_DATABASE_URL": database_url,
            "EXOGAUGE_PORT": "0",
            "EXOGAUGE_WORKERS": str(workers),
            "PYTHONPATH": str(PROGRAM.parent),
            **more,
        }
        self.process: subprocess.Popen[bytes] | None = None
        self.url = ""

    def start(self) -> str:
        """The service's address."""
        log = self.folder / "server.log"
        with log.open("wb") as sink:
            self.process = subprocess.Popen(
                [sys.executable, str(PROGRAM), "serve"],
                env=self.environment,
                stdin=subprocess.DEVNULL,
                stdout=sink,
                stderr=sink,
            )
        end = time.monotonic() + 60.0
        while time.monotonic() < end and self.process.poll() is None:
            for line in log.read_text().splitlines():
                if line.startswith(ANNOUNCED):
                    self.url = line.removeprefix(ANNOUNCED)
                    return self.url
            time.sleep(0.05)
        pytest.fail(f"the service did not start:\n{log.read_text()[-3000:]}")

    def stop(self) -> None:
        if self.process is not None and self.process.poll() is None:
            self.process.terminate()
            assert self.process.wait(timeout=30) in (0, -15)


SHARED = pytest.StashKey[Service]()


@pytest.fixture(scope="session")
def service(tmp_path_factory: pytest.TempPathFactory, pytestconfig: pytest.Config) -> Iterator[Service]:
    """One for all who leave it as it is."""
    made = Service(tmp_path_factory.mktemp("service"))
    made.start()
    pytestconfig.stash[SHARED] = made
    yield made
    made.stop()


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    made = item.config.stash.get(SHARED, None)
    if made is not None and made.process is not None and made.process.poll() is not None:
        made.start()


@pytest.hookimpl(trylast=True)
def pytest_runtest_teardown(item: pytest.Item, nextitem: pytest.Item | None) -> None:
    """It does not look for jobs ten times a second while tests of other folders run."""
    made = item.config.stash.get(SHARED, None)
    if made is not None and (nextitem is None or Path(__file__).parent not in nextitem.path.parents):
        made.stop()


@pytest.fixture(scope="session")
def service_of() -> type[Service]:
    """For modules with services of their own."""
    return Service


@pytest.fixture
def client(service: Service) -> Iterator[Client]:
    with Client(service.url) as opened:
        yield opened


@pytest.fixture
def make_service(tmp_path: Path) -> Iterator[Callable[..., Service]]:
    """Services of one test's own."""
    made = []

    def make(**more: Any) -> Service:
        made.append(Service(tmp_path, **more))
        return made[-1]

    yield make
    for service in made:
        service.stop()


@pytest.fixture
def study_folder(tmp_path: Path) -> Path:
    """A one-joint study on disk, right in every way."""
    return write_study(tmp_path / "study")


@pytest.fixture(scope="module")
def study(service: Service, tmp_path_factory: pytest.TempPathFactory) -> Study:
    """That study, uploaded."""
    with Client(service.url) as opened:
        return opened.upload_study(write_study(tmp_path_factory.mktemp("uploaded") / "study"))


@pytest.fixture
def worn_study(tmp_path: Path) -> Callable[[bool], Path]:
    """worn_study(same_motion): the folder of a study of that joint with and without a strap."""
    small, arm = module(TESTS / "api" / "conftest.py"), module(TESTS / "client" / "worn_arm.py")

    def write(same_motion: bool) -> Path:
        folder = tmp_path / f"worn_{same_motion}"
        written: Path = arm.write_worn_study(folder, small.ROBOT, small.URDF, same_motion=same_motion)
        return written

    return write


def module(path: Path) -> ModuleType:
    """The module in a file beside the tests, which are no package."""
    found = importlib.util.spec_from_file_location(path.stem, path)
    assert found is not None
    assert found.loader is not None
    made = importlib.util.module_from_spec(found)
    found.loader.exec_module(made)
    return made


def write_study(folder: Path) -> Path:
    small = module(TESTS / "api" / "conftest.py")
    texts = {
        "study.yaml": small.STUDY,
        "robot.yaml": small.ROBOT,
        "robot.urdf": small.URDF,
        "logs/id.csv": small.table(0.0),
        "logs/val.csv": small.table(0.7),
        "truth.json": "{}",
    }
    for path, text in texts.items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_text(text)
    return folder
