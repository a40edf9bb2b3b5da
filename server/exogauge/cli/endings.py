"""How a command ends, and where it may write."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TypeAlias

from exogauge.errors import BadInput, Fault

INCOMPLETE, BAD_INPUT = 1, 2
Commands: TypeAlias = "argparse._SubParsersAction[argparse.ArgumentParser]"


def refuse_what_is_there(folder: Path, force: bool) -> None:
    """Nothing that somebody has written is written over unasked."""
    if not force and folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        advice = "Name a new folder, or add --force to write over what is in it."
        raise BadInput(Fault("it exists and is not an empty folder", "folder_not_empty", advice, str(folder)))
