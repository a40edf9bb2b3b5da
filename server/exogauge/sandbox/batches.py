"""Many logs by few children: to start a child takes ten times longer than to read a short log.

A batch of logs shares one child. A log that this child does not give, because it is damaged or because the child
ended before it answered, is asked for again in a child of its own, and what that one says counts: no log has the
fault of another, of the memory that others took, or of the time that was left.

What sharing means: no file reaches another log's table as long as its reader does what it should, but a hostile file
that takes its reader over could alter the other logs of its batch. These are asked for by the same caller at the same
time: the logs of one study, which one lab handed in.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import TypeVar

from exogauge.errors import BadInput, BadLog, Unavailable
from exogauge.logs.model import Log
from exogauge.sandbox.asking import ask
from exogauge.sandbox.limits import Limits
from exogauge.sandbox.parent import CHILD, LogRequest, parse_log, read_answer
from exogauge.sandbox.protocol import LOGS

MAX_LOGS = 32
MAX_BYTES = 32 << 20  # of the files of one batch; beyond, a child's start no longer counts
MAX_THREADS = 4
SHARED = Limits(cpu_s=20, wall_s=60.0)  # ten times what a batch takes; a log that needs more gets it alone

T = TypeVar("T")


def parse_logs(requests: Sequence[LogRequest], limits: Limits | None = None) -> list[Log]:
    """The logs in the order in which they are asked for. limits: of each child.

    Raises the faults of all logs at once, as TooLarge where every log at fault is, otherwise as BadLog; Unavailable.
    """
    found = read_each(requests, lambda log: log, limits)
    errors = [each for each in found if isinstance(each, BadInput)]
    if errors:
        kinds = {type(error) for error in errors}
        kind = kinds.pop() if len(kinds) == 1 else BadLog
        raise kind([fault for error in errors for fault in error.faults])
    return [each for each in found if isinstance(each, Log)]


def read_each(
    requests: Sequence[LogRequest], take: Callable[[Log], T], limits: Limits | None = None
) -> list[T | BadInput]:
    """What `take` makes of each log, or the error of its files; in the order in which they are asked for.

    `take` is called in threads, as soon as a log is read; only what it returns is kept.
    """
    batches = list(batches_of(requests))
    with ThreadPoolExecutor(min(MAX_THREADS, _processors())) as pool:
        try:
            # Large logs are read in this thread: one at a time, as each may fill a child's memory.
            running = [None if _large(batch) else pool.submit(_read_batch, batch, take, limits) for batch in batches]
            return [
                each
                for batch, future in zip(batches, running, strict=True)
                for each in (_read_batch(batch, take, limits) if future is None else future.result())
            ]
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def batches_of(requests: Sequence[LogRequest]) -> Iterator[list[LogRequest]]:
    """Neighbours together, up to MAX_LOGS and MAX_BYTES; a larger log is a batch of its own."""
    batch, size = list[LogRequest](), 0
    for request in requests:
        if batch and (len(batch) == MAX_LOGS or size + request.size > MAX_BYTES):
            yield batch
            batch, size = [], 0
        batch.append(request)
        size += request.size
    if batch:
        yield batch


def _large(batch: Sequence[LogRequest]) -> bool:
    return sum(request.size for request in batch) > MAX_BYTES


def _processors() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _read_batch(batch: Sequence[LogRequest], take: Callable[[Log], T], limits: Limits | None) -> list[T | BadInput]:
    given = _read_shared(batch, take, limits or SHARED) if len(batch) > 1 else {}
    return [given[k] if k in given else _read_alone(each, take, limits) for k, each in enumerate(batch)]


def _read_shared(batch: Sequence[LogRequest], take: Callable[[Log], T], limits: Limits) -> dict[int, T]:
    """What one child for all gives, by place in the batch."""
    names = ", ".join(name for request in batch for name in request.paths)
    options = {"logs": [request.to_plain() for request in batch]}
    found = dict[int, T]()
    with tempfile.TemporaryDirectory(prefix="exogauge-") as folder:
        try:
            answers = ask(CHILD, "logs", options, Path(folder), limits, BadLog, file=names)["logs"]
        except (BadInput, Unavailable):
            return found
        for k, (request, answer) in enumerate(zip(batch, answers, strict=True)):
            if answer is None:
                continue
            try:
                log = read_answer(Path(folder) / LOGS.format(k), request, answer)
            except (BadInput, OSError):
                continue
            found[k] = take(log)
    return found


def _read_alone(request: LogRequest, take: Callable[[Log], T], limits: Limits | None) -> T | BadInput:
    try:
        log = parse_log(request, limits)
    except BadInput as bad:
        return bad
    return take(log)
