"""Motions and devices of stored studies, kept ready in this process so that a what-if is answered in milliseconds.

The study's files are read once by a short-lived child (`opening_motion`); what comes back are plain numbers and names,
checked once more here. The benches asked for least recently go when memory runs short.
"""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, final

import numpy as np

from exogauge.api.opening_motion import MOTION
from exogauge.devices.bench import Bench, wire_bytes
from exogauge.devices.device import Device
from exogauge.errors import BadStudy, Fault, TooLarge
from exogauge.robots.plain_tree import from_plain
from exogauge.sandbox.asking import ask
from exogauge.sandbox.limits import Limits
from exogauge.studies.device_pages.device_content import device_from
from exogauge.studies.series.recorded_motion import RecordedMotion

CHILD = "exogauge.api.opening_motion"
MOST_SAMPLES = 5000  # of a synchronous answer; a longer log is thinned evenly
MIB = 1 << 20
KEPT_BYTES = 256 * MIB  # of all benches together
BENCH_BYTES, TRIED_BYTES, WIRE_BYTES = 64 * MIB, 16 * MIB, 32 * MIB  # of one bench; of routings tried on it; of one
AT_ONCE = 2  # children that read at the same time

Key = tuple[str, str, str | None]
"""(content hash of the study, log, device file as asked for)."""


@final
@dataclass(frozen=True)
class Ready:
    motion: RecordedMotion
    bench: Bench


@final
class Benches:
    """Threads share it. A bench that several ask for at once is made once."""

    def __init__(self, kept_bytes: int = KEPT_BYTES) -> None:
        self._kept_bytes = kept_bytes
        self._kept: OrderedDict[Key, Ready] = OrderedDict()
        self._making: dict[Key, threading.Lock] = {}
        self._lock, self._at_once = threading.Lock(), threading.Semaphore(AT_ONCE)

    def get(self, key: Key, make: Callable[[], Ready]) -> Ready:
        """The bench of this key; `make` is called where none is kept, and may raise."""
        with self._lock:
            making = self._making.setdefault(key, threading.Lock())
        with making:
            with self._lock:
                if (kept := self._kept.get(key)) is not None:
                    self._kept.move_to_end(key)
                    return kept
            try:
                with self._at_once:
                    made = make()
                self._keep(key, made)
            finally:
                with self._lock:
                    self._making.pop(key, None)
        return made

    def __len__(self) -> int:
        return len(self._kept)

    def _keep(self, key: Key, made: Ready) -> None:
        with self._lock:
            self._kept[key] = made
            while len(self._kept) > 1 and sum(each.bench.nbytes for each in self._kept.values()) > self._kept_bytes:
                self._kept.popitem(last=False)


def open_bench(folder: Path, log: str, device: str | None) -> Ready:
    """folder: the study's files. Raises what `read_motion` does, TooLarge, Unavailable."""
    limits = Limits.for_bytes(sum(path.stat().st_size for path in folder.rglob("*") if path.is_file()))
    options = {"folder": str(folder), "log": log, "device": device, "most": MOST_SAMPLES}
    with TemporaryDirectory(prefix="exogauge-") as own:
        plain = ask(CHILD, "motion", options, Path(own), limits, BadStudy, what="study")
        try:
            motion = read_back(plain, Path(own) / MOTION)
        except (ValueError, KeyError, TypeError, OSError, OverflowError) as error:  # pydantic's error is a ValueError
            detail = "what was read of the study makes no motion"
            raise BadStudy(Fault(detail, "unreadable_file", "Hand the study in again.")) from error
    refuse_large(motion, motion.device, BENCH_BYTES)
    return Ready(motion, Bench(motion.tree, motion.device, motion.q, motion.time, TRIED_BYTES))


def read_back(plain: Mapping[str, Any], file: Path) -> RecordedMotion:
    """What the child answered and left behind. Raises ValueError, KeyError, TypeError or OSError where it is odd."""
    tree = from_plain(plain["tree"])
    samples, columns = int(plain["samples"]), 1 + len(tree.joints)
    if not 0 < samples <= MOST_SAMPLES or file.stat().st_size != 8 * samples * columns:
        raise ValueError("the motion has another size")
    table = np.fromfile(file, dtype=np.float64).reshape(samples, columns)
    if not np.isfinite(table).all() or (np.diff(table[:, 0]) <= 0.0).any():
        raise ValueError("time does not rise, or a number is not finite")
    return RecordedMotion(
        tree=tree,
        device=device_from(plain["device"]),
        device_file=str(plain["device_file"]),
        log=str(plain["log"]),
        q=np.ascontiguousarray(table[:, 1:]),
        time=np.ascontiguousarray(table[:, 0]),
        of_samples=int(plain["of_samples"]),
        every=int(plain["every"]),
        cutoff_hz=None if plain["cutoff_hz"] is None else float(plain["cutoff_hz"]),
    )


def refuse_large(motion: RecordedMotion, device: Device, most: int) -> None:
    """What would need more memory than an answer at once may take."""
    sizes: Sequence[int] = [wire_bytes(motion.tree, band, len(motion.time)) for band in device.bands]
    if sum(sizes) > most or max(sizes, default=0) > WIRE_BYTES:
        advice = "Submit a job of kind `whatif`, which has room for it."
        raise TooLarge(Fault("the bands pass too many joints for an answer at once", "too_many_bands", advice))
