"""The studies on which two trees are compared, and which of them are asked for."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from tests.gate.trees import Tree
from tests.real.recordings.studies import STUDIES

SAMPLE_SEED = 7  # the sample of README's commands
BLIND_SEED, BLIND_CASES = 611953, 60  # drawn once, never used before; spent as a blind figure, not as a comparison


@dataclass(frozen=True)
class Case:
    """study(scratch): the study file, in a folder of its own below `scratch` or where it was kept."""

    name: str
    study: Callable[[Path], Path]


def cases(only: str, kept: Path, maker: Tree, blind: Path | None) -> list[Case]:
    """only: `sample,blind:0:10,real`, or `real:icub`. kept: folder for what is simulated, once. blind: cases made
    before, in place of fresh ones."""
    found: list[Case] = []
    for asked in only.split(","):
        sort, _, which = asked.partition(":")
        found.extend({"sample": _sample, "blind": _blind, "real": _real}[sort](which, kept, maker, blind))
    return found


def _sample(_which: str, kept: Path, maker: Tree, _blind: Path | None) -> Iterator[Case]:
    folder = kept / f"sample-{SAMPLE_SEED}"
    if not (folder / "study.yaml").exists():
        _make(maker, "sample", str(folder), "--seed", str(SAMPLE_SEED), "--realism", "ideal")
    yield Case("sample", lambda _scratch: folder / "study.yaml")


def _blind(which: str, kept: Path, maker: Tree, blind: Path | None) -> Iterator[Case]:
    folder = blind or kept / f"blind-{BLIND_SEED}-{BLIND_CASES}"
    if not (folder / "seal.txt").exists():
        _make(maker, "blind", "make", str(folder), "--seed", str(BLIND_SEED), "--cases", str(BLIND_CASES))
    found = sorted(folder.glob("case_*/study.yaml"))
    first, _, stop = which.partition(":")
    for study in found[int(first or 0) : int(stop) if stop else None]:
        yield Case(f"blind/{study.parent.name}", lambda _scratch, study=study: study)  # type: ignore[misc]


def _real(which: str, _kept: Path, _maker: Tree, _blind: Path | None) -> Iterator[Case]:
    """Copies of recordings are not kept. Those that are not beside the repository are told and left out."""
    for name, study in STUDIES.items():
        if which in ("", name) and study.is_there:
            yield Case(f"real/{name}", lambda scratch, name=name: STUDIES[name].make(scratch))  # type: ignore[misc]
        elif which in ("", name):
            print(f"real/{name}: the recording is not beside the repository, left out")


def _make(maker: Tree, *arguments: str) -> None:
    print(f"exogauge {' '.join(arguments)} …", flush=True)
    done = maker.command(*arguments)
    if done.returncode != 0:
        raise SystemExit(done.stderr)


def recorded_answers(results: Path, names: Sequence[str]) -> dict[str, object]:
    """case -> what `exogauge blind run` has written of it: `discrepancy` alone of results.json."""
    found = dict[str, object]()
    for name in names:
        path = results / f"{name.removeprefix('blind/')}.json"
        if name.startswith("blind/") and path.exists():
            found[name] = {"discrepancy": json.loads(path.read_bytes())["discrepancy"]}
    return found
