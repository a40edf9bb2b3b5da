"""A case evaluated by a tree's own command; the answer is kept by code and by input."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from tests.gate.cases import Case
from tests.gate.trees import Tree


def answers(jobs: Sequence[tuple[Tree, Case]], kept: Path, processes: int) -> dict[tuple[str, str], Any]:
    """(tree's name, case's name) -> `exit`, the code of `exogauge run`, and all of results.json.

    A thread waits for each child process.
    """
    found = {}
    with ThreadPoolExecutor(processes) as pool:
        running = {pool.submit(_answer, tree, case, kept): (tree.name, case.name) for tree, case in jobs}
        for done in as_completed(running):
            tree, case = running[done]
            found[tree, case], known = done.result()
            how = "known" if known else f"exit code {found[tree, case]['exit']}"
            print(f"{len(found):4d} of {len(running)}  {case:24s} by {tree}: {how}", flush=True)
    return found


def _answer(tree: Tree, case: Case, kept: Path) -> tuple[Any, bool]:
    """And whether it was known."""
    with TemporaryDirectory(prefix="exogauge-gate-case-") as scratch:
        study = case.study(Path(scratch))
        name = f"{case.name.replace('/', '-')}-{study.stem}-{_content(study.parent)}.json"
        path = kept / "answers" / tree.version / name
        if path.exists():
            return json.loads(path.read_bytes()), True
        with TemporaryDirectory(prefix="exogauge-gate-out-") as out:
            done = tree.command("run", str(study), "--out", out)
            results = Path(out) / "results.json"
            answer: dict[str, Any] = {"exit": done.returncode}
            answer |= json.loads(results.read_bytes()) if results.exists() else {}
        if done.returncode != 0:
            print(f"{case.name} by {tree.name}: {done.stderr.strip().splitlines()[-1:]}", flush=True)
    path.parent.mkdir(parents=True, exist_ok=True)
    unfinished = path.with_suffix(f".{os.getpid()}")
    unfinished.write_text(json.dumps(answer, ensure_ascii=False))
    os.replace(unfinished, path)
    return answer, False


def _content(folder: Path) -> str:
    digest = hashlib.sha256()
    for path in sorted(path for path in folder.rglob("*") if path.is_file()):
        digest.update(path.relative_to(folder).as_posix().encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()[:12]
