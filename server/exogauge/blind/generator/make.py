"""All cases of a benchmark, in as many processes as asked for, and their sealed answers."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from exogauge.blas_threads import limit_children
from exogauge.blind.answers import write_answers
from exogauge.blind.generator.case import write_case
from exogauge.blind.generator.plan import ROBOTS, STANDING, can_be_asked_for, case_name
from exogauge.errors import BadInput, Fault

What = tuple[int, str, tuple[str, ...]]  # seed, robots, effects

_README = """\
SYNTHETIC DATA. Nothing in this folder was measured on a robot.

case_*/          studies of robots of our own in which effects may be hidden (`exogauge run case_0001`)
answers.json.gz  what is hidden in each; no evaluating code opens it
seal.txt         SHA-256 of the answers as JSON text
results/         what an evaluation said of each case, after `exogauge blind run`
"""


def make(
    out: Path,
    seed: int,
    cases: int,
    progress: Callable[[float, str], None] | None = None,
    processes: int = 1,
    robots: str = "both",
    effects: Sequence[str] = (),
) -> None:
    """Write `cases` studies, the answers and their seal into `out`, which must be new or empty.

    The same seed gives the same bytes, whatever `processes`; case n is the same however many there are. robots: which
    ones the cases are made of, a key of `plan.ROBOTS`, or `plan.STANDING`. effects: hide one of these in
    every case; none: all sorts, two or nothing now and then.
    """
    if seed < 0 or cases < 1:
        column, value = ("seed", seed) if seed < 0 else ("cases", cases)
        detail = "the seed must be 0 or more, and the number of cases 1 or more"
        raise BadInput(Fault(detail, "blind_numbers", column=column, value=str(value)))
    if robots not in (*ROBOTS, STANDING):
        raise _unknown("no cases are made of this robot", "robot", robots, (*ROBOTS, STANDING))
    for each in effects:
        if each not in can_be_asked_for(robots):
            raise _unknown("this is not hidden in cases of these robots", "effects", each, can_be_asked_for(robots))
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        advice = "Give a new folder, so that old results never meet new answers."
        raise BadInput(Fault(f"{out} is not an empty folder", "folder_not_empty", advice))
    out.parent.mkdir(parents=True, exist_ok=True)
    unfinished = Path(tempfile.mkdtemp(prefix=f".{out.name}-", dir=out.parent))
    try:
        (unfinished / "README.txt").write_text(_README, encoding="utf-8")
        tell = progress or (lambda share, what: None)
        answers = _make_all(unfinished, (seed, robots, tuple(effects)), cases, tell, min(processes, cases))
        write_answers(unfinished, seed, answers)
        unfinished.chmod(0o755)
        os.replace(unfinished, out)
    finally:
        shutil.rmtree(unfinished, ignore_errors=True)


def _unknown(detail: str, column: str, value: str, known: Iterable[str]) -> BadInput:
    return BadInput(Fault(detail, f"unknown_{column}", f"Known: {', '.join(known)}", column=column, value=value))


def _make_all(
    out: Path, what: What, cases: int, tell: Callable[[float, str], None], processes: int
) -> list[dict[str, Any]]:
    if processes < 2:
        answers = []
        for number in range(1, cases + 1):
            answers.append(_make(out, what, number))
            tell(number / cases, f"{number} of {cases} cases")
        return answers
    done: dict[int, dict[str, Any]] = {}
    limit_children()
    with ProcessPoolExecutor(processes, get_context("spawn")) as pool:
        running = {pool.submit(_make, out, what, number): number for number in range(1, cases + 1)}
        try:
            for each in as_completed(running):
                done[running[each]] = each.result()
                tell(len(done) / cases, f"{len(done)} of {cases} cases")
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise
    return [done[number] for number in sorted(done)]


def _make(out: Path, what: What, number: int) -> dict[str, Any]:
    seed, robots, effects = what
    name = case_name(number)
    if robots == STANDING:
        from exogauge.blind.generator.standing import write_standing_case  # needs MuJoCo

        return write_standing_case(out / name, name, seed, number, effects)
    return write_case(out / name, seed, number, robots, effects)
