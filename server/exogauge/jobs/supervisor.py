"""Embedded workers: start them, start them again when they die, and let them leave with their parent.

Each worker's stdin is a pipe whose other end only this process holds. When this process is gone, however it
went, the pipe closes and the worker leaves (`leave_with_parent`).
"""

from __future__ import annotations

import logging
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from typing import final

log = logging.getLogger(__name__)

FIRST_BACK_OFF_S = 0.5
LONGEST_BACK_OFF_S = 30.0
HEALTHY_AFTER_S = 30.0  # a worker that lived this long starts again with the first back-off


@final
class Supervisor:
    """Keeps `count` worker processes alive until `stop()`."""

    def __init__(self, command: Sequence[str], count: int, environment: Mapping[str, str] | None = None) -> None:
        self._command, self._count = list(command), count
        self._environment = dict(environment) if environment is not None else None
        self._stopping = threading.Event()
        self._processes: dict[int, subprocess.Popen[bytes]] = {}
        self._threads: list[threading.Thread] = []

    def start(self) -> None:
        """Start one thread per slot; each keeps one worker alive."""
        for slot in range(self._count):
            thread = threading.Thread(target=self._keep, args=(slot,), name=f"worker-slot-{slot}", daemon=True)
            thread.start()
            self._threads.append(thread)

    def _keep(self, slot: int) -> None:
        back_off = FIRST_BACK_OFF_S
        while not self._stopping.is_set():
            born = time.monotonic()
            process = subprocess.Popen(self._command, stdin=subprocess.PIPE, env=self._environment)
            self._processes[slot] = process
            code = process.wait()
            assert process.stdin is not None
            process.stdin.close()
            if self._stopping.is_set():
                return
            if time.monotonic() - born > HEALTHY_AFTER_S:
                back_off = FIRST_BACK_OFF_S
            log.warning("worker %d ended with code %d; the next starts in %.1f s", process.pid, code, back_off)
            self._stopping.wait(back_off)
            back_off = min(2 * back_off, LONGEST_BACK_OFF_S)

    def stop(self, patience_s: float = 5.0) -> None:
        """Ask the workers to leave, then insist."""
        self._stopping.set()
        for process in list(self._processes.values()):
            if process.poll() is None:
                process.terminate()
        for process in list(self._processes.values()):
            try:
                process.wait(timeout=patience_s)
            except subprocess.TimeoutExpired:
                process.kill()
        for thread in self._threads:
            thread.join(timeout=patience_s)


def leave_with_parent(leave: Callable[[], None]) -> None:
    """Call `leave()` once stdin ends: whoever started this worker is gone."""

    def wait() -> None:
        while os.read(sys.stdin.fileno(), 1024):
            pass
        log.warning("the parent process is gone; leaving")
        leave()

    threading.Thread(target=wait, name="parent-watch", daemon=True).start()
