"""A worker process: holds a lease, takes jobs from the queue, leaves in good order."""

from __future__ import annotations

import logging
import math
import os
import signal
import sys
import tempfile
import threading

from exogauge import tracing
from exogauge.jobs.attempt import Runner
from exogauge.jobs.bell import Bell, listen
from exogauge.jobs.code_version import code_version, hashed
from exogauge.jobs.engine import JobQueue, take_jobs
from exogauge.jobs.leases import Lease, Reaper, new_worker_id
from exogauge.jobs.supervisor import leave_with_parent
from exogauge.settings import Settings
from exogauge.storage import migrate
from exogauge.storage.store import open_installation

log = logging.getLogger(__name__)

LEASE_S = 10.0
SETTLED_S = 5.0  # judgement: files of an installation that is being replaced are left alone for so long at its end
LOOKED_EVERY_S = 0.5  # for a worker that leaves when there is nothing to do


def work(settings: Settings, *, with_parent: bool = False, idle_s: float = math.inf, lease_s: float = LEASE_S) -> None:
    """Run jobs until SIGTERM or SIGINT, until the parent is gone (`with_parent`: its end of stdin closes), or until
    there was nothing to do for `idle_s`.

    The process then ends at once: what it was computing goes back into the queue, without counting as an attempt. Where
    the program's own files were replaced it begins anew by them, in the same process, before it takes another job.
    """
    environment = dict(os.environ)
    flush = tracing.send_spans("worker")
    migrate.at_newest_or_raise(migrate.current(settings.database_url))
    installation = open_installation(settings)
    worker_id = new_worker_id()
    folder = settings.work / worker_id
    log.info("worker %s computes by %s", worker_id, code_version())  # as it is now, whatever is installed later
    lease = Lease(installation.engine, worker_id, lease_s)
    leaving, new_code = threading.Event(), threading.Event()

    def begin_anew() -> None:
        log.warning("worker %s: the files of exogauge have changed; it begins anew by them", worker_id)
        new_code.set()
        leaving.set()

    runner = Runner(installation, worker_id, folder, begin_anew)
    reaper = Reaper(installation.engine, JobQueue(installation.engine), lease_s, folder.parent)
    told = threading.Event()

    def lost() -> None:
        log.error("worker %s was declared dead; it ends without writing anything", worker_id)
        os._exit(3)

    def leave() -> None:
        told.set()
        leaving.set()

    signal.signal(signal.SIGTERM, lambda *_: leave())
    if not with_parent:
        signal.signal(signal.SIGINT, lambda *_: leave())
    else:
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches the whole group; the parent decides
        leave_with_parent(leave)
    lease.take()
    runner.temporary.mkdir(parents=True, exist_ok=True)
    os.environ["TMPDIR"] = tempfile.tempdir = str(runner.temporary)  # also of what computes: swept with the worker
    lease.keep(lost, reaper.reap)
    bell = Bell()
    listen(installation.engine, bell)
    take_jobs(settings.database_url, worker_id, runner.run, bell)
    log.info("worker %s takes jobs", worker_id)
    while not leaving.wait(None if idle_s == math.inf else LOOKED_EVERY_S):
        if runner.idle_s() >= idle_s:
            log.info("worker %s had nothing to do for %.0f s", worker_id, idle_s)
            break
    try:
        runner.leave()
        lease.give_back()
        flush()
        if new_code.is_set() and settled(told):
            logging.shutdown()
            os.execve(sys.executable, [sys.executable, *sys.orig_argv[1:]], environment)
    finally:
        os._exit(0)  # threads of the engine may still wait for a computation that is gone


def settled(told: threading.Event) -> bool:
    """Wait until the program's files stay as they are; False where the worker was told to leave meanwhile."""
    before = hashed()
    while not told.wait(SETTLED_S):
        now = hashed()
        if now == before:
            return True
        before = now
    return False
