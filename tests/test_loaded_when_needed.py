"""A command loads what it uses: a process loads one after the other, and tells what it has loaded."""

from __future__ import annotations

import subprocess
import sys

import pytest

SHELL = {"fastapi", "starlette", "uvicorn", "sqlalchemy", "alembic", "dbos", "httpx", "viser", "mujoco"}
PAGES = {"matplotlib", "fpdf", "jinja2"}
BELOW_SCIPY = {"scipy.constants", "scipy.special", "scipy.linalg", "numpy.f2py"}  # each loads what all of scipy needs
SLOW = {"scipy.signal", "scipy.optimize", "scipy.stats", "scipy.interpolate", "scipy.spatial"}  # half a second or more
OPEN = """
import exogauge.payload.intake, exogauge.studies.intake.admit, exogauge.studies.intake.open
import exogauge.studies.series.recorded_motion
"""
UPLOAD = """
import exogauge.payload.intake, exogauge.studies.intake.open, exogauge.studies.intake.read_log
import numpy as np
from exogauge.logs.noise import quantisation_step
assert quantisation_step(0.5 * np.arange(30.0)) == 0.5
"""
DOCTOR = """
import exogauge.studies.intake.admit, exogauge.studies.intake.open
import exogauge.studies.results.examine_logs, exogauge.studies.words.notices
"""
PAYLOAD = """
import exogauge.payload.intake, exogauge.payload.planning.plan, exogauge.payload.live_process
"""
EFFECTS = """
from exogauge.effects import catalogue
from exogauge.effects.band_laws import all_laws
catalogue.missing_effects(), catalogue.all_effects(), all_laws()
"""
HELP = """
from exogauge.cli import main
try:
    main(["--help"])
except SystemExit:
    pass
"""


STEPS = {  # each loads what those before it do, and more; and what it does not
    "help": (HELP, {*SHELL, *PAGES, "numba", "numpy", "scipy", "pinocchio", "pyarrow"}),
    "effects": (EFFECTS, {*SHELL, *PAGES, *SLOW, "numba", "pyarrow"}),
    "upload": (UPLOAD, {*SHELL, *PAGES, *SLOW, *BELOW_SCIPY, "numba", "h5py", "rosbags"}),
    "open": (OPEN, {*SHELL, *PAGES, *SLOW, "numba", "h5py", "rosbags"}),
    "doctor": (DOCTOR, {*SHELL, *PAGES, "numba", "h5py", "rosbags"}),
    "evaluate": ("import exogauge.studies.evaluate", {*SHELL, "scipy.stats", "numba", "h5py", "rosbags"}),
}
SERVICE = {"mujoco", "numba", "scipy", "pinocchio", "pyarrow", *PAGES}


def loaded_after(*steps: str) -> list[set[str]]:
    """Modules after each of the steps."""
    script = "\n".join(f"{step}\nimport sys; print('loaded', *sys.modules)" for step in steps)
    told = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True).stdout
    return [set(line.split()[1:]) for line in told.splitlines() if line.startswith("loaded ")]


@pytest.fixture(scope="module")
def loaded() -> dict[str, set[str]]:
    return dict(zip(STEPS, loaded_after(*(step for step, _ in STEPS.values())), strict=True))


@pytest.mark.slow
@pytest.mark.parametrize("step", STEPS)
def test_what_a_command_does_not_use_is_not_loaded(step: str, loaded: dict[str, set[str]]) -> None:
    assert not loaded[step] & STEPS[step][1]


@pytest.mark.slow
def test_a_service_loads_no_numerics() -> None:
    by_command, loaded = loaded_after(
        "import exogauge.jobs.schema, exogauge.storage.accounts", "import exogauge.api.app"
    )
    assert not by_command & {"fastapi", "uvicorn", "viser"}, "of a command beside the database"
    assert not loaded & SERVICE


@pytest.mark.slow
def test_a_payload_is_opened_and_followed_without_what_makes_reports() -> None:
    (loaded,) = loaded_after(PAYLOAD)
    assert not loaded & {*SHELL, *PAGES, "scipy.signal", "scipy.stats", "h5py", "rosbags"}


@pytest.mark.slow
def test_words_and_urdfs_load_no_numerics_but_arrays_and_bodies() -> None:
    (loaded,) = loaded_after("import exogauge.studies.words.names, exogauge.robots.urdf")
    assert not loaded & {*SHELL, *PAGES, "scipy.linalg", "numba", "pyarrow"}
