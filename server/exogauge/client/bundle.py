"""A study's or robot's folder as one zip, the same bytes each time; what must not leave stays behind."""

from __future__ import annotations

import zipfile
from pathlib import Path

import yaml

from exogauge.errors import BadStudy, Fault

STAYS_BEHIND = {"truth.json"}  # of synthetic studies: what no evaluating code may see
STORED = {".parquet", ".gz", ".zip", ".png"}
EPOCH = (1980, 1, 1, 0, 0, 0)


def zipped(folder: Path, main: str, target: Path) -> Path:
    """Pack the files below `folder`, which must hold `main`; hidden files and truth.json are left out."""
    if not (folder / main).is_file():
        raise BadStudy(Fault(f"the folder holds no {main}", "missing_file", "Name the folder that does.", str(folder)))
    return packed(folder, sorted(path for path in folder.rglob("*") if path.is_file()), target)


def zipped_robot(description: Path, target: Path) -> Path:
    """Pack a robot.yaml and the URDF it names, and nothing else of the folder they are in."""
    content = yaml.safe_load(description.read_text())
    urdf = content.get("urdf") if isinstance(content, dict) else None
    named = [description.parent / urdf] if isinstance(urdf, str) else []
    return packed(description.parent, [description, *(path for path in named if path.is_file())], target)


def packed(folder: Path, files: list[Path], target: Path) -> Path:
    """A zip of `files` under their paths relative to `folder`."""
    with zipfile.ZipFile(target, "w") as bundle:
        for path in files:
            name = path.relative_to(folder)
            if path.name in STAYS_BEHIND or any(part.startswith(".") for part in name.parts):
                continue
            entry = zipfile.ZipInfo(name.as_posix(), EPOCH)
            entry.compress_type = zipfile.ZIP_STORED if path.suffix in STORED else zipfile.ZIP_DEFLATED
            with path.open("rb") as source, bundle.open(entry, "w", force_zip64=True) as member:
                while chunk := source.read(1 << 20):
                    member.write(chunk)
    return target
