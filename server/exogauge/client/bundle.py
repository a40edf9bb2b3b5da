"""The folder of a study, robot or device as one zip, the same bytes each time; what must not leave stays behind."""

from __future__ import annotations

import zipfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import yaml

from exogauge.errors import BadStudy, Fault

STAYS_BEHIND = {"truth.json"}  # of synthetic studies: what no evaluating code may see
STORED = {".parquet", ".gz", ".zip", ".png"}
NAMES_A_FILE = {"urdf", "file"}
EPOCH = (1980, 1, 1, 0, 0, 0)


def zipped(folder: Path, main: str, target: Path) -> Path:
    """Pack the files below `folder`, which must hold `main`; hidden files and truth.json are left out."""
    if not (folder / main).is_file():
        raise BadStudy(Fault(f"the folder holds no {main}", "missing_file", "Name the folder that does.", str(folder)))
    found = sorted(path for path in folder.rglob("*") if path.is_file())
    return packed({path.relative_to(folder): path for path in found}, target)


def zipped_description(description: Path, main: str, target: Path) -> Path:
    """Pack a robot.yaml or device.yaml as `main`, the files it names, and nothing else of the folder they are in."""
    folder = description.parent
    try:
        names = sorted(set(named_files(yaml.safe_load(description.read_text()))))
    except (yaml.YAMLError, UnicodeDecodeError):
        names = []  # the service says where it is broken
    named = {Path(name): folder / name for name in names if ".." not in Path(name).parts}
    there = {name: path for name, path in named.items() if path.is_file()}
    return packed({Path(main): description, **there}, target)


def named_files(content: Any) -> Iterator[str]:
    """The values of all keys that name a file."""
    for key, value in content.items() if isinstance(content, dict) else ():
        if key in NAMES_A_FILE and isinstance(value, str) and not Path(value).is_absolute():
            yield value
    for part in content.values() if isinstance(content, dict) else content if isinstance(content, list) else ():
        yield from named_files(part)


def packed(files: Mapping[Path, Path], target: Path) -> Path:
    """A zip of `files`: path in it -> path on disk."""
    with zipfile.ZipFile(target, "w") as bundle:
        for name, path in files.items():
            if path.name in STAYS_BEHIND or any(part.startswith(".") for part in name.parts):
                continue
            entry = zipfile.ZipInfo(name.as_posix(), EPOCH)
            entry.compress_type = zipfile.ZIP_STORED if path.suffix in STORED else zipfile.ZIP_DEFLATED
            with path.open("rb") as source, bundle.open(entry, "w", force_zip64=True) as member:
                while chunk := source.read(1 << 20):
                    member.write(chunk)
    return target
