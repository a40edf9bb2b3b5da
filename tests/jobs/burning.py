"""A job kind for tests only, and the program whose workers know it.

    python burning.py work [--with-parent]     a worker
    python burning.py serve                    the server, with workers of this program

`burn` does what its settings say: {"mode", "seconds", "ledger"}. The ledger is an append-only file that counts
starts and ends independently of the engine.
"""

from __future__ import annotations

import ctypes
import importlib
import json
import os
import signal
import sys
import time
from pathlib import Path

from exogauge.errors import BadStudy, Fault
from exogauge.garbage import left_while_loading
from exogauge.progress import Stage

LEASE_S = 3.0


def burn(folder: Path, out: Path, progress, settings) -> None:
    ledger, seconds = Path(settings["ledger"]), float(settings.get("seconds", 0.2))
    note(ledger, "start")
    if settings.get("stdout"):
        print(settings["stdout"], flush=True)
    end = time.monotonic() + seconds
    while (left := end - time.monotonic()) > 0:
        progress(1.0 - left / seconds, f"{left:.1f} s left", Stage.READING)
        time.sleep(0.02)
    if settings.get("needs"):  # as what computes imports what it needs when it needs it
        importlib.import_module(settings["needs"])
    mode = settings.get("mode", "ok")
    progress(0.6, f"{mode}: about to")  # said at once after another: too often to be told, but for its end
    if mode == "bad":
        raise BadStudy(Fault("the log has no column", "missing_column", "Add it.", "logs/a.csv", column="t"))
    if mode == "differ":
        same = "Record the same motion with and without the device."
        told = [("dq.elbow", "31 %"), ("dq.knee", "44 %")]
        raise BadStudy([Fault("the motions differ", "motions_differ", same, "worn.csv", None, *each) for each in told])
    if mode == "defect":
        raise ZeroDivisionError("nobody foresaw this")
    if mode == "segfault" or (mode == "segfault_once" and starts(ledger) == 1):
        ctypes.string_at(0)
    if mode == "kill_worker":
        os.kill(os.getppid(), signal.SIGKILL)
        time.sleep(60)
    if settings.get("bytes"):
        try:
            (out / "load").write_bytes(os.urandom(settings["bytes"]))
        except OSError:
            if mode == "hides":
                raise BadStudy(Fault("the file is damaged", "damaged", "Export it again.")) from None
            raise
    files = {str(p.relative_to(folder)): p.read_text() for p in sorted(folder.rglob("*")) if p.is_file()}
    (out / "results.json").write_text(json.dumps({"files": files, "pid": os.getpid()}))
    (out / "series").mkdir()
    (out / "series" / "a.csv").write_text("t\n0\n")
    note(ledger, "end")


def note(ledger: Path, word: str) -> None:
    with ledger.open("a") as file:
        file.write(word + "\n")


def starts(ledger: Path) -> int:
    return ledger.read_text().split().count("start")


def main() -> None:
    import logging

    with left_while_loading():
        from exogauge.jobs import claims, engine, recipes, worker
        from exogauge.settings import Settings

    logging.basicConfig(level=logging.INFO)
    engine.POLL_S = 0.1  # a second in service: half of what these jobs take
    worker.SETTLED_S = 0.2
    if other := os.environ.get("BURN_VERSION"):  # of a worker of another release, or of the tests
        claims.code_version = lambda: other
    recipes.RECIPES["burn"] = recipes.Recipe("burn", "burning:burn", timeout_s=float(os.environ.get("BURN_LIMIT", 60)))
    if sys.argv[1] == "work":
        idle_s = float(os.environ.get("BURN_UNTIL_IDLE", "inf"))
        worker.work(Settings(), with_parent="--with-parent" in sys.argv, idle_s=idle_s, lease_s=LEASE_S)
    else:
        with left_while_loading():
            from exogauge.serving import serve

        serve(Settings(), worker_command=[sys.executable, __file__, "work", "--with-parent"])


if __name__ == "__main__":
    main()
