"""How a command ends, and where it may write."""

from __future__ import annotations

import argparse
import os
from contextlib import suppress
from pathlib import Path
from typing import TypeAlias

from exogauge.errors import BadInput, ExogaugeError, Fault

INCOMPLETE, BAD_INPUT, NOT_NOW, NOT_YOU = 1, 2, 3, 4
Commands: TypeAlias = "argparse._SubParsersAction[argparse.ArgumentParser]"


def refuse_what_is_there(folder: Path, force: bool) -> None:
    """Nothing that somebody has written is written over unasked."""
    if not force and folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        advice = "Name a new folder, or add --force to write over what is in it."
        raise BadInput(Fault("it exists and is not an empty folder", "folder_not_empty", advice, str(folder)))
    refuse_no_folder(folder)


def refuse_no_place(out: Path | None) -> None:
    """Before what takes minutes: a file that is asked for can be written. Raises BadInput."""
    if out is None:
        return
    if out.is_dir():
        raise BadInput(Fault("this is a folder", "no_place", "Name a file in it with --out", str(out)))
    if not out.parent.is_dir() or not os.access(out.parent, os.W_OK):
        detail = "nothing may be written in its folder" if out.parent.is_dir() else "there is no such folder"
        raise BadInput(Fault(detail, "no_place", "Make it, or name another one with --out", str(out)))


def refuse_no_folder(out: Path | None) -> None:
    """The same for a folder, which is made and taken away again: nothing is left where a command refuses later. Raises
    BadInput."""
    if out is None:
        return
    missing = [each for each in (out, *out.parents) if not each.exists()]
    try:
        out.mkdir(parents=True, exist_ok=True)
        writable = os.access(out, os.W_OK)
    except FileExistsError:
        raise BadInput(Fault("this is a file", "no_place", "Name a folder with --out", str(out))) from None
    except OSError as error:
        advice = "Name another place with --out"
        raise BadInput(Fault(f"it cannot be made: {error.strerror}", "no_place", advice, str(out))) from error
    finally:
        for each in missing:
            with suppress(OSError):  # it was not made, or somebody has put something there
                each.rmdir()
    if not writable:
        raise BadInput(Fault("nothing may be written in it", "no_place", "Name another one with --out", str(out)))


def told_by_system(error: OSError) -> str:
    """What this machine does not let a command do: a full disk, a file that is a folder."""
    place = f"{error.filename}: " if error.filename is not None else ""
    return f"{place}{error.strerror or type(error).__name__}"


def ending_of(error: ExogaugeError) -> int:
    """3: a service does not answer, or has not ended: the same command later goes on. 4: it lets this caller not do it.
    2: what was handed in, or the installation, is not usable."""
    from exogauge.client.problems import ClientProblem

    if not isinstance(error, ClientProblem):
        return BAD_INPUT
    return NOT_NOW if error.later else NOT_YOU if error.status in (401, 403) else BAD_INPUT
