"""Where recordings of real robots lie beside the repository, and how one of them becomes a study folder."""

from __future__ import annotations

import os
import sysconfig
from pathlib import Path

DATA = Path(os.path.normpath(Path(__file__).parents[3] / ".." / "shared" / "data"))
ROBOTS = Path(sysconfig.get_path("purelib")) / "cmeel.prefix/share/example-robot-data/robots"


def is_there(recording: str) -> bool:
    return (DATA / recording).is_dir()


def place(recording: str, files: tuple[str, ...], folder: Path) -> None:
    """Copy those files of a recording into a folder."""
    for file in files:
        (folder / file).write_bytes((DATA / recording / file).read_bytes())


def write_fixed_arm(folder: Path, urdf: str, joints: tuple[str, ...]) -> None:
    """robot.yaml and the URDF of a robot of `example-robot-data` whose joints log torques."""
    (folder / "robot.urdf").write_bytes((ROBOTS / urdf).read_bytes())
    (folder / "robot.yaml").write_text(
        "version: 1\nurdf: robot.urdf\nbase: fixed\njoints:\n"
        + "".join(f"  - {{name: {joint}, actuation: torque}}\n" for joint in joints)
    )
