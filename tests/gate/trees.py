"""A tree of the sources with an environment of its own: this one's packages, that tree's code."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
import sysconfig
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

HERE = Path(__file__).resolve().parents[2]


@dataclass(frozen=True)
class Tree:
    """version: 12 hex digits over the code, so that an answer belongs to what gave it."""

    name: str
    python: Path
    version: str

    def command(self, *arguments: str) -> subprocess.CompletedProcess[str]:
        """`exogauge ARGUMENTS` with this tree's code, on one thread."""
        environment = {key: value for key, value in os.environ.items() if not key.startswith(("EXOGAUGE_", "PYTHON"))}
        return subprocess.run(
            [self.python, "-B", "-m", "exogauge.cli", *arguments],
            env=environment | {"OPENBLAS_NUM_THREADS": "1"}, capture_output=True, text=True, check=False,
        )  # fmt: skip


@contextmanager
def trees(base: str) -> Iterator[tuple[Tree, Tree]]:
    """The tree of a revision or a folder, and this one. A revision is checked out into a temporary folder."""
    with TemporaryDirectory(prefix="exogauge-gate-") as scratch:
        folder = Path(base) if Path(base).is_dir() else Path(scratch) / "base"
        if not Path(base).is_dir():
            _git("worktree", "add", "--quiet", "--detach", str(folder), base)
        try:
            yield _tree(base, folder, Path(scratch)), _tree("this tree", HERE, Path(scratch))
        finally:
            if not Path(base).is_dir():
                _git("worktree", "remove", "--force", str(folder))


def _git(*arguments: str) -> None:
    subprocess.run(["git", "-C", str(HERE), *arguments], check=True)


def _tree(name: str, folder: Path, scratch: Path) -> Tree:
    environment = scratch / f"environment-{name.replace('/', '_')}"
    return Tree(name, _python(environment, folder.resolve() / "server"), _version(folder))


def _python(environment: Path, server: Path) -> Path:
    """The interpreter of a bare environment. Paths in .pth files also hold for children started with `python -I`."""
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", str(environment)], check=True)
    python = environment / "bin/python"
    asked = [str(python), "-c", "import sysconfig; print(sysconfig.get_path('purelib'))"]
    theirs = Path(subprocess.run(asked, check=True, capture_output=True, text=True).stdout.strip())
    ours = sysconfig.get_path("purelib")
    (theirs / "00_this_code.pth").write_text(f"{server}\n")
    (theirs / "10_packages.pth").write_text(f"import site; site.addsitedir({ours!r})\n")
    told = [str(python), "-I", "-c", "import exogauge; print(exogauge.__file__)"]
    code = Path(subprocess.run(told, check=True, capture_output=True, text=True).stdout.strip())
    if not code.is_relative_to(server):
        raise SystemExit(f"the code that would be evaluated is {code}, not that of {server}")
    return python


def _version(folder: Path) -> str:
    package = folder / "server/exogauge"
    digest = hashlib.sha256()
    for path in sorted(path for path in package.rglob("*") if path.is_file()):
        if not {"__pycache__", "_packaged"} & set(path.parts):
            digest.update(path.relative_to(package).as_posix().encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()[:12]
