"""A command loads what it uses: each in a process of its own, which tells what it has loaded."""

from __future__ import annotations

import subprocess
import sys

import pytest

SHELL = {"fastapi", "starlette", "uvicorn", "sqlalchemy", "alembic", "dbos", "httpx", "viser", "mujoco"}
PAGES = {"matplotlib", "fpdf", "jinja2"}
DOCTOR = """
import exogauge.studies.intake.admit, exogauge.studies.intake.open
import exogauge.studies.results.examine_logs, exogauge.studies.words.notices
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


def loaded(script: str) -> set[str]:
    """Top-level modules behind a script."""
    told = subprocess.run(
        [sys.executable, "-c", f"{script}\nimport sys\nprint(*sys.modules)"], capture_output=True, text=True, check=True
    )
    return {name.partition(".")[0] for name in told.stdout.splitlines()[-1].split()}


@pytest.mark.parametrize(
    ("script", "not_needed"),
    [
        (HELP, {*SHELL, *PAGES, "numba", "numpy", "scipy", "pinocchio", "pyarrow"}),
        (DOCTOR, {*SHELL, *PAGES, "numba", "h5py", "rosbags"}),
        (EFFECTS, {*SHELL, *PAGES, "numba", "pyarrow"}),
        ("import exogauge.studies.evaluate", {*SHELL, "numba", "h5py", "rosbags"}),
        ("import exogauge.api.app", {"mujoco", "numba"}),
    ],
    ids=["help", "doctor", "effects", "evaluate", "service"],
)
def test_what_a_command_does_not_use_is_not_loaded(script: str, not_needed: set[str]) -> None:
    assert not loaded(script) & not_needed
