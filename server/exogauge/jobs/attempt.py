"""One worker at one job: claim it, load, compute in the child, save, and record the end.

Only this file catches `Exception`: whatever happens, the job gets a state and a reason a user can read.
"""

from __future__ import annotations

import logging
import math
import shutil
import threading
import time
from collections.abc import Callable, Mapping
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import Any, TypeVar, final

from exogauge import tracing
from exogauge.errors import Away, Cancelled, DiskFull, ExogaugeError, Unavailable
from exogauge.jobs import claims
from exogauge.jobs.claims import MAX_ATTEMPTS, MAX_CRASHES
from exogauge.jobs.code_version import outdated
from exogauge.jobs.compute import ComputeChild, ComputeChildDied, ComputeFailed, Outdated
from exogauge.jobs.plans_beside import lay_plans
from exogauge.jobs.recipes import recipe_for
from exogauge.jobs.turns import next_jobs
from exogauge.logbook import job_id
from exogauge.storage import held_files
from exogauge.storage.blobs import disk
from exogauge.storage.files import PinnedFile, keep_folder
from exogauge.storage.orphans import BlobGone
from exogauge.storage.records import JobRecord
from exogauge.storage.store import Installation, Storage, Store
from exogauge.storage.tables import owner_of

log = logging.getLogger(__name__)
T = TypeVar("T")

MOST_TRIED = 64  # jobs that other workers may take in the same moment
LOOK_EVERY_S = 0.2  # progress written and wishes to cancel read, at most this often
LONGEST_PAUSE_S = 5.0  # judgement: as long as it takes to find that nobody answers to a connection
LONGEST_DISK_PAUSE_S = 60.0  # before a computation begins anew, which may take minutes
DISK_PATIENCE_S = 120.0  # for a disk that is broken; a full one, or a store that is away, is waited for


class NotMineAnyMore(ExogaugeError):
    """Another worker has the job, or it has ended: write nothing."""


class Leaving(ExogaugeError):
    """This worker was asked to leave."""


def sleep(pause_s: float, _: Unavailable) -> None:
    time.sleep(pause_s)


def until_it_works(
    action: Callable[[], T],
    patience_s: float = math.inf,
    wait: Callable[[float, Unavailable], None] = sleep,
    longest_pause_s: float = LONGEST_PAUSE_S,
) -> T:
    """Do something again and again while the database, the object store or the disk is away; the last error after
    `patience_s`, but never for a full disk or a store that is away: somebody will make room, or mend the line. wait:
    for so long, and for what; it may raise to give up."""
    give_up, pause_s = time.monotonic() + patience_s, 0.2
    while True:
        try:
            return action()
        except Unavailable as error:
            if time.monotonic() > give_up and not isinstance(error, DiskFull | Away):
                raise
            log.warning("trying again in %.1f s: %s", pause_s, error)
            wait(pause_s, error)
            pause_s = min(2 * pause_s, longest_pause_s)


@final
class Runner:
    """Runs jobs, one at a time, for one worker: each in its own lab. scratch: this worker's own folder. begin_anew:
    called where the program's files have changed; no job is taken after that."""

    def __init__(
        self,
        installation: Installation,
        worker_id: str,
        scratch: Path,
        begin_anew: Callable[[], None] = lambda: None,
    ) -> None:
        self._installation, self._worker, self._scratch = installation, worker_id, scratch
        self._begin_anew, self._outdated = begin_anew, False
        self.temporary = scratch / "tmp"
        self._child = ComputeChild()
        self._one_at_a_time = threading.Lock()
        self._leaving = threading.Event()
        self._looked, self._ended = 0.0, time.monotonic()
        self._progress = 0.0
        self._charged = 0.0
        self._unsaid: tuple[float, str, str | None] | None = None
        self._stage: str | None = None

    def idle_s(self) -> float:
        """For how long nothing was computed; 0 while something is."""
        return 0.0 if self._one_at_a_time.locked() else time.monotonic() - self._ended

    def run(self) -> None:
        """Bring the job whose turn it is to an end, if there is one."""
        with self._one_at_a_time:
            again: str | None = None
            if self._outdated or outdated():
                self._end_of_this_code()
                return
            while (job := until_it_works(partial(self._claim, again))) is not None:
                again = job.id
                try:
                    self._traced_attempt(job)
                except ComputeChildDied as error:
                    log.warning("job %s: %s", job.id, error)
                    self._note(job, f"{error}\n{error.stderr}", crashed=True)
                    continue
                except NotMineAnyMore:
                    log.warning("job %s is no longer ours", job.id)
                except Outdated as error:
                    log.warning("job %s goes back into the queue: %s", job.id, error)
                    until_it_works(self._release)
                    self._end_of_this_code()
                except Leaving:
                    log.info("job %s goes back into the queue", job.id)
                return

    def _end_of_this_code(self) -> None:
        self._outdated = True
        self._begin_anew()

    def _release(self) -> None:
        with self._installation.session() as session:
            claims.release(session, self._worker)

    def _claim(self, again: str | None) -> JobRecord | None:
        """The next job, or the one whose computation died. None where other workers were quicker."""
        with self._installation.session() as session:
            keys = next_jobs(session, MOST_TRIED) if again is None else [again]
            taken = (claims.claim(session, key, self._worker) for key in keys)
            job = next((each for each in taken if each is not None), None)
            if job is not None and job.cancel_requested:
                claims.end_cancelled(session, job.id, self._worker)
                return None
            if job is not None and (job.crashes >= MAX_CRASHES or job.attempts > MAX_ATTEMPTS):
                times = job.crashes if job.crashes >= MAX_CRASHES else MAX_ATTEMPTS
                died = f"the process that ran it died {times} times (crash, kill or out of memory); see the log"
                claims.fail(session, job.id, self._worker, died)
                return None
        return job

    def _of(self, job: JobRecord) -> Storage:
        """All that is read and written for a job is its lab's."""
        return self._installation.of_lab(job.lab_id, "worker")

    def _traced_attempt(self, job: JobRecord) -> None:
        with tracing.of_job(job.kind, {"exogauge.job": job.id, "exogauge.attempt": job.attempts}):
            self._attempt(job)

    def _attempt(self, job: JobRecord) -> None:
        """Load, compute, save. Raises what means 'try again' or 'not mine'; everything else becomes an end."""
        started, folder = time.monotonic(), self._scratch / job.id
        job_id.set(job.id)
        log.info("job %s: attempt %d", job.id, job.attempts)
        self._charged = self._child.used_s
        try:
            self._compute_and_save(job, folder)
            log.info("job %s succeeded in %.1f s", job.id, time.monotonic() - started)
        except (ComputeChildDied, NotMineAnyMore, Outdated, Leaving):
            raise
        except Cancelled:
            self._cancelled(job)
        except ComputeFailed as error:
            reason = str(error) if error.expected else f"unexpected error ({error.kind}): {error}"
            self._fail(job, reason, error.trace or "", error.failure)
        except ExogaugeError as error:
            self._fail(job, str(error))
        except Exception as error:
            log.exception("job %s", job.id)
            failure = {"class": type(error).__name__, "faults": [], "defect": True}
            self._fail(job, f"unexpected error ({type(error).__name__}): {error}", failure=failure)
        finally:
            self._ended = time.monotonic()
            for left in (folder, *(self.temporary.iterdir() if self.temporary.is_dir() else ())):
                held_files.remove(left)

    def _compute_and_save(self, job: JobRecord, folder: Path) -> None:
        """A full disk is waited for: a computation that met one begins anew, what one made is kept until it fits."""
        out = folder / "out"

        def wait(pause_s: float, error: Unavailable) -> None:
            self._wait(job, pause_s, error)

        self._progress, self._unsaid, self._stage = 0.0, None, None
        until_it_works(lambda: self._compute(job, folder, out, wait), DISK_PATIENCE_S, wait, LONGEST_DISK_PAUSE_S)
        files = until_it_works(lambda: keep_folder(self._installation.blobs, out), DISK_PATIENCE_S, wait)

        def save() -> None:
            try:
                self._succeed(job, files)
            except BlobGone:  # of an equal file that nothing needed
                keep_folder(self._installation.blobs, out)
                raise

        until_it_works(save)

    def _compute(self, job: JobRecord, folder: Path, out: Path, wait: Callable[[float, Unavailable], None]) -> None:
        recipe, source = recipe_for(job.kind), folder / "study"
        try:
            with disk("prepare a scratch folder"):
                shutil.rmtree(folder, ignore_errors=True)
                out.mkdir(parents=True)
                source.mkdir()
            until_it_works(lambda: self._load(job, source), wait=wait)
            self._child.call(recipe.compute, source, out, job.settings, partial(self._watch, job), recipe.timeout_s)
        except DiskFull:
            shutil.rmtree(folder, ignore_errors=True)  # its own part of what is in the way
            raise

    def _wait(self, job: JobRecord, pause_s: float, error: Unavailable) -> None:
        """Say for what, and hear a wish to cancel or to leave."""
        until = time.monotonic() + pause_s
        while (left := until - time.monotonic()) > 0:
            self._watch(job, self._progress, f"waits: {error}", None)
            time.sleep(min(LOOK_EVERY_S, left))

    def _load(self, job: JobRecord, folder: Path) -> None:
        with self._of(job).reading() as store:
            noun, key = owner_of(job)
            store.owners(noun).write_with_all(key, folder)
            if noun == "study":
                lay_plans(store, folder)

    def _watch(self, job: JobRecord, progress: float | None, message: str | None, stage: str | None) -> None:
        """Called while the child computes. Best effort: a database that is away stops no computation."""
        if self._leaving.is_set():
            raise Leaving
        if progress is not None:
            if stage is not None and stage != self._stage:
                self._stage = stage
                tracing.stage(stage)
            self._progress = progress
            self._unsaid = (progress, message or "", stage)
        now = time.monotonic()
        if now - self._looked < LOOK_EVERY_S:
            return
        self._looked = now
        try:
            if self._unsaid is not None:
                with self._of(job).transaction() as store:
                    self._charge(store, job)
                    claims.report(store.session, job.id, self._worker, *self._unsaid)
                self._unsaid = None
            with self._of(job).reading() as store:
                wanted = claims.cancel_wanted(store.session, job.id, self._worker)
        except Unavailable as error:
            log.warning("job %s: progress not written: %s", job.id, error)
            self._looked = time.monotonic() + LONGEST_PAUSE_S  # else what is computed would wait for who tells of it
            return
        if wanted is None:
            raise NotMineAnyMore(job.id)
        if wanted:
            raise Cancelled("cancelled on request")

    def _charge(self, store: Store, job: JobRecord) -> None:
        """What was computed since it was last told."""
        before, self._charged = self._charged, self._child.used_s
        if self._charged > before:
            claims.charge(store.session, job.id, self._worker, self._charged - before)

    def _succeed(self, job: JobRecord, files: tuple[PinnedFile, ...]) -> None:
        with self._of(job).transaction() as store:
            self._charge(store, job)
            claims.append_log(store.session, job.id, self._worker, line(f"attempt {job.attempts} succeeded"))
            if not claims.succeed(store.session, job, self._worker, files):
                raise NotMineAnyMore(job.id)

    def _fail(self, job: JobRecord, reason: str, trace: str = "", failure: Mapping[str, Any] | None = None) -> None:
        log.info("job %s failed: %s", job.id, reason)
        tracing.failed(reason)
        self._note(job, f"{reason}\n{trace}")

        def write() -> None:
            with self._of(job).transaction() as store:
                self._charge(store, job)
                self._say_the_last(store, job)
                claims.fail(store.session, job.id, self._worker, reason, failure)

        until_it_works(write)

    def _say_the_last(self, store: Store, job: JobRecord) -> None:
        """At what it ended; looks are too rare to have written each step."""
        if self._unsaid is not None:
            claims.report(store.session, job.id, self._worker, *self._unsaid)

    def _cancelled(self, job: JobRecord) -> None:
        log.info("job %s cancelled", job.id)

        def write() -> None:
            with self._of(job).transaction() as store:
                self._charge(store, job)
                self._say_the_last(store, job)
                claims.end_cancelled(store.session, job.id, self._worker)

        until_it_works(write)

    def _note(self, job: JobRecord, text: str, *, crashed: bool = False) -> None:
        def write() -> None:
            with self._of(job).transaction() as store:
                if crashed:
                    claims.crashed(store.session, job.id, self._worker)
                self._charge(store, job)
                claims.append_log(store.session, job.id, self._worker, line(f"attempt {job.attempts}: {text}"))

        until_it_works(write)

    def leave(self, patience_s: float = 5.0) -> None:
        """Stop computing, take nothing more, and put back what was not finished in time."""
        self._leaving.set()
        if self._one_at_a_time.acquire(timeout=patience_s):  # never released: no further job starts here
            self._child.kill()
        self._release()
        shutil.rmtree(self._scratch, ignore_errors=True)


def line(text: str) -> str:
    return claims.stamped(datetime.now(UTC), text)
