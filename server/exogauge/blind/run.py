"""Evaluates every case with the product's own entry, in as many processes as there are processors.

Knows nothing of the answers. What a case says goes to results/<case>.json as soon as it is known, so an interrupted
run goes on where it stopped; results of another version of the code are made again.
"""

from __future__ import annotations

import json
import os
import shutil
import tempfile
import time
import traceback
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from exogauge.blas_threads import limit_children
from exogauge.errors import BadInput, ExogaugeError, Fault, Unavailable
from exogauge.jobs.code_version import code_version
from exogauge.side_by_side import CORES

RESULTS = "results"
_STARTED = ".started"

Progress = Callable[[float, str], None]


def run(out: Path, progress: Progress, processes: int, keep: bool = False) -> list[str]:
    """Evaluate the cases of `out` that have no result yet; the names of those that failed.

    keep: take results of earlier code as they are.
    """
    cases = sorted(path.parent.name for path in out.glob("case_*/study.yaml"))
    if not cases:
        advice = "Give the folder that `exogauge blind make` has written."
        raise BadInput(Fault("there are no cases in this folder", "no_cases", advice, file=str(out)))
    results, code = out / RESULTS, code_version()
    results.mkdir(exist_ok=True)
    limit_children()  # they are as many as there are processors
    os.environ.setdefault(CORES, "1")
    for mark in results.glob(f"*{_STARTED}"):  # of a run that was interrupted
        mark.unlink()
    missing = {case for case in cases if not _is_done(results / f"{case}.json", code, keep)}

    def ended(case: str) -> None:
        missing.discard(case)
        progress(1.0 - len(missing) / len(cases), f"{len(cases) - len(missing)} of {len(cases)} cases")

    while missing:
        before = len(missing)
        _evaluate_in_pool(out, sorted(missing), code, processes, ended)
        for case in [case for case in sorted(missing) if (results / f"{case}{_STARTED}").exists()]:
            _evaluate_in_pool(out, [case], code, 1, ended)  # whose fault it was that a process died shows alone
            if case in missing:
                _write(results / f"{case}.json", _record(case, code, 0.0, 0.0, {}, "the process died"))
                (results / f"{case}{_STARTED}").unlink(missing_ok=True)
                ended(case)
        if len(missing) == before:
            raise Unavailable("the processes that evaluate cases die before they begin: is memory short?")
    return [case for case in cases if json.loads((results / f"{case}.json").read_bytes())["error"]]


def _is_done(path: Path, code: str, keep: bool) -> bool:
    """A result that is not to be made again; any other is removed."""
    try:
        record = json.loads(path.read_bytes())
        if not record["error"] and (keep or record["code"] == code):
            return True
    except (OSError, ValueError, KeyError):
        pass
    path.unlink(missing_ok=True)
    return False


def _evaluate_in_pool(out: Path, cases: Sequence[str], code: str, processes: int, ended: Callable[[str], None]) -> None:
    """Stops early when a process dies; the marks of what had been started stay."""
    with ProcessPoolExecutor(min(processes, len(cases)), get_context("spawn")) as pool:
        running = {pool.submit(_evaluate, out, case, code): case for case in cases}
        try:
            for done in as_completed(running):
                done.result()
                ended(running[done])
        except BrokenProcessPool:
            return
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise


def _evaluate(out: Path, case: str, code: str) -> None:
    """In a process of the pool. Whatever goes wrong belongs to this case."""
    from exogauge.studies.evaluate import evaluate

    mark = out / RESULTS / f"{case}{_STARTED}"
    mark.touch()
    folder = Path(tempfile.mkdtemp(prefix="exogauge-blind-"))
    start, processor, result, error = time.perf_counter(), time.process_time(), dict[str, Any](), None
    try:
        failed = evaluate(out / case / "study.yaml", folder, lambda *_: None)
        error = "\n".join(each.sentence for each in failed) or None
        result = json.loads((folder / "results.json").read_bytes())
    except Exception as problem:
        error = f"{type(problem).__name__}: {problem}"
        if not isinstance(problem, ExogaugeError):  # a fault of the program: where
            error += f"\n{traceback.format_exc()}"
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    seconds, processor = time.perf_counter() - start, time.process_time() - processor
    _write(out / RESULTS / f"{case}.json", _record(case, code, seconds, processor, result, error))
    mark.unlink()


def _record(
    case: str, code: str, seconds: float, processor: float, result: dict[str, Any], error: str | None
) -> dict[str, Any]:
    """discrepancy: as in results.json, None where the step was not done, and then `why`."""
    skipped = [step for step in result.get("steps", []) if step["step"] == "discrepancy" and step["status"] != "done"]
    return {
        "case": case,
        "code": code,
        "seconds": round(seconds, 3),
        "processor_seconds": round(processor, 3),
        "error": error,
        "discrepancy": result.get("discrepancy"),
        "why": skipped[0].get("reason") if skipped else None,
    }


def _write(path: Path, record: dict[str, Any]) -> None:
    """Whole or not at all."""
    unfinished = path.with_suffix(".unfinished")
    unfinished.write_text(json.dumps(record, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    os.replace(unfinished, path)
