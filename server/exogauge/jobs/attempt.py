"""One worker at one job: claim it, load, compute in the child, save, and record the end.

Only this file catches `Exception`: whatever happens, the job gets a state and a reason a user can read.
"""

from __future__ import annotations

import logging
import math
import shutil
import threading
import time
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from typing import TypeVar, final

import sqlalchemy as sa
from sqlalchemy.exc import InterfaceError, OperationalError, SQLAlchemyError
from sqlalchemy.orm import Session

from exogauge.errors import Cancelled, ExogaugeError, Unavailable
from exogauge.jobs import recipes, records
from exogauge.jobs.compute import ComputeChild, ComputeChildDied, ComputeFailed
from exogauge.storage.blobs import BlobStore
from exogauge.storage.tables import Job

log = logging.getLogger(__name__)
T = TypeVar("T")

LOOK_EVERY_S = 0.2  # progress written and wishes to cancel read, at most this often
LONGEST_PAUSE_S = 5.0
DISK_PATIENCE_S = 120.0


class NotMineAnyMore(ExogaugeError):
    """Another worker has the job, or it has ended: write nothing."""


class Leaving(ExogaugeError):
    """This worker was asked to leave."""


def until_it_works(action: Callable[[], T], patience_s: float = math.inf) -> T:
    """Do something again and again while the database or the disk is away; the last error after `patience_s`."""
    give_up, pause_s = time.monotonic() + patience_s, 0.2
    while True:
        try:
            return action()
        except (OperationalError, InterfaceError, sa.exc.TimeoutError, Unavailable) as error:
            if time.monotonic() > give_up:
                raise
            log.warning("cannot do this now, trying again in %.1f s: %s", pause_s, error)
            time.sleep(pause_s)
            pause_s = min(2 * pause_s, LONGEST_PAUSE_S)


@final
class Runner:
    """Runs jobs, one at a time, for one worker. scratch: this worker's own folder."""

    def __init__(self, engine: sa.Engine, blobs: BlobStore, worker_id: str, scratch: Path) -> None:
        self._engine, self._blobs, self._worker, self._scratch = engine, blobs, worker_id, scratch
        self._child = ComputeChild()
        self._one_at_a_time = threading.Lock()
        self._leaving = threading.Event()
        self._looked = 0.0

    def run(self, job_id: str) -> None:
        """Bring a job to an end, or leave it alone when it is not free."""
        with self._one_at_a_time:
            while (job := until_it_works(lambda: self._claim(job_id))) is not None:
                try:
                    self._attempt(job)
                except ComputeChildDied as error:
                    log.warning("job %s: %s", job.id, error)
                    self._note(job, f"attempt {job.attempts}: {error}\n{error.stderr}")
                    continue
                except NotMineAnyMore:
                    log.warning("job %s is no longer ours", job.id)
                except Leaving:
                    log.info("job %s goes back into the queue", job.id)
                return

    def _claim(self, job_id: str) -> Job | None:
        with Session(self._engine, expire_on_commit=False) as session, session.begin():
            job = records.claim(session, job_id, self._worker)
        if job is None:
            return None
        if job.cancel_requested:
            self._end(job, "cancelled", "cancelled on request")
            return None
        if job.attempts > records.MAX_ATTEMPTS:
            times = f"{records.MAX_ATTEMPTS} times"
            self._end(
                job, "failed", f"the process that ran it died {times} (crash, kill or out of memory); see the log"
            )
            return None
        return job

    def _attempt(self, job: Job) -> None:
        """Load, compute, save. Raises what means 'try again' or 'not mine'; everything else becomes an end."""
        started, folder = time.monotonic(), self._scratch / job.id
        log.info("job %s: attempt %d", job.id, job.attempts)
        try:
            self._compute_and_save(job, folder)
            log.info("job %s succeeded in %.1f s", job.id, time.monotonic() - started)
        except (ComputeChildDied, NotMineAnyMore, Leaving):
            raise
        except Cancelled as error:
            self._end(job, "cancelled", str(error))
        except ComputeFailed as error:
            reason = str(error) if error.expected else f"unexpected error ({error.kind}): {error}"
            self._end(job, "failed", reason, log_text=error.trace or "")
        except ExogaugeError as error:
            self._end(job, "failed", str(error))
        except Exception as error:
            log.exception("job %s", job.id)
            self._end(job, "failed", f"unexpected error ({type(error).__name__}): {error}")
        finally:
            shutil.rmtree(folder, ignore_errors=True)

    def _compute_and_save(self, job: Job, folder: Path) -> None:
        recipe = recipes.RECIPES.get(job.kind)
        if recipe is None:
            raise ExogaugeError(f"this worker knows no jobs of kind {job.kind!r}")
        source, out = folder / "study", folder / "out"
        shutil.rmtree(folder, ignore_errors=True)
        out.mkdir(parents=True)
        source.mkdir()
        files = until_it_works(lambda: self._pinned(job))
        recipes.load(self._blobs, files, source)
        self._child.call(
            recipe.compute, source, out, job.settings, lambda p, m: self._watch(job, p, m), recipe.timeout_s
        )
        products = until_it_works(lambda: recipes.keep(self._blobs, out), DISK_PATIENCE_S)
        until_it_works(lambda: self._succeed(job, products))

    def _pinned(self, job: Job) -> dict[str, str]:
        with Session(self._engine) as session, session.begin():
            return recipes.pinned_files(session, job)

    def _watch(self, job: Job, progress: float | None, message: str | None) -> None:
        """Called by the child's loop. Progress and wishes are best effort; a database that is away stops nothing."""
        if self._leaving.is_set():
            raise Leaving
        now = time.monotonic()
        if now - self._looked < LOOK_EVERY_S:
            return
        self._looked = now
        try:
            with Session(self._engine) as session, session.begin():
                if progress is not None:
                    records.report(session, job.id, self._worker, progress, message or "")
                wanted = records.cancel_wanted(session, job.id, self._worker)
        except SQLAlchemyError as error:
            log.warning("job %s: progress not written: %s", job.id, error)
            return
        if wanted is None:
            raise NotMineAnyMore(job.id)
        if wanted:
            raise Cancelled("cancelled on request")

    def _succeed(self, job: Job, products: list[recipes.Product]) -> None:
        with Session(self._engine) as session, session.begin():
            line = stamped(f"attempt {job.attempts} succeeded on {self._worker}")
            if not records.finish(session, job.id, self._worker, "succeeded", log=line):
                raise NotMineAnyMore(job.id)
            recipes.save(session, job, products)

    def _end(self, job: Job, state: records.Ending, reason: str, log_text: str = "") -> None:
        log.info("job %s %s: %s", job.id, state, reason)
        text = stamped(f"attempt {job.attempts} {state} on {self._worker}: {reason}") + log_text

        def write() -> None:
            with Session(self._engine) as session, session.begin():
                records.finish(session, job.id, self._worker, state, reason, text)

        until_it_works(write)

    def _note(self, job: Job, text: str) -> None:
        def write() -> None:
            with Session(self._engine) as session, session.begin():
                records.note(session, job.id, self._worker, stamped(text))

        until_it_works(write)

    def leave(self, patience_s: float = 5.0) -> None:
        """Stop computing, take nothing more, and put back what was not finished in time."""
        self._leaving.set()
        self._one_at_a_time.acquire(timeout=patience_s)  # never released: no further job starts here
        with Session(self._engine) as session, session.begin():
            records.release(session, self._worker)
        shutil.rmtree(self._scratch, ignore_errors=True)


def stamped(text: str) -> str:
    """A line of the job's log."""
    return f"{datetime.now(UTC).isoformat(timespec='seconds')} {text}\n"
