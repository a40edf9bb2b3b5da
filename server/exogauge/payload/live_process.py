"""The process of one stream: messages of a client in, answers out; the service only passes them on.

    python -m exogauge.payload.live_process FOLDER RATE_HZ SILENCE_S FD       a stream, on the socket FD
    python -m exogauge.payload.live_process FOLDER finish                     the log of one that is no more

FOLDER holds `payload/` as it was handed in; `stream.bin` grows with every sample taken; at the end `log.parquet` is
written. It leaves when the other end of the socket is gone, and ends the stream after SILENCE_S without a sample.
"""

from __future__ import annotations

import faulthandler
import json
import select
import signal
import socket
import struct
import sys
import time
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

from exogauge.errors import BadStudy, ExogaugeError, Fault
from exogauge.payload.contract import PayloadFile
from exogauge.payload.live import Start
from exogauge.payload.live_input import Arrivals, Columns
from exogauge.payload.live_lines import Stream
from exogauge.payload.live_messages import CLIENT_BYTES, CLIENT_TEXT, CONTROL, Frames, error_message, framed
from exogauge.payload.live_record import Record, write_log
from exogauge.payload.live_start import open_start

Array = NDArray[np.float64]

RAW, LOG, COLUMNS = "stream.bin", "log.parquet", "columns.json"
NUMBER = struct.Struct("<Q")
AT_ONCE = 1024  # samples of one message
ALLOWED = 2.0  # times the stated rate that may come in the mean …
BURST_S = 10.0  # … after so much at once: what a client sends again when it comes back
MOST_FAULTS = 20  # of one connection


def main() -> None:
    faulthandler.enable()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the service decides
    folder = Path(sys.argv[1])
    if sys.argv[2] == "finish":
        if (folder / COLUMNS).exists():
            write_log(folder / RAW, json.loads((folder / COLUMNS).read_text()), folder / LOG)
        return
    with socket.socket(fileno=int(sys.argv[4])) as channel:
        conversation = Conversation(channel)
        try:
            run(folder, float(sys.argv[2]), float(sys.argv[3]), conversation)
        except ExogaugeError as error:
            conversation.say(error_message(error))
            conversation.control(fatal=True)
        except (BrokenPipeError, ConnectionResetError):
            pass  # the service is gone; what was taken is on disk


def run(folder: Path, rate_hz: float, silence_s: float, conversation: Conversation) -> None:
    counted_every_s = 1.0
    file, start = open_start(folder / "payload")
    taker = Taker(file, start, rate_hz, folder / RAW)
    (folder / COLUMNS).write_text(json.dumps(taker.stream.columns.names), encoding="utf-8")
    silent_since = counted = time.monotonic()
    while True:
        frames = conversation.receive(max(silence_s - (time.monotonic() - silent_since), 0.0))
        if frames is None:
            taker.record.close()
            return
        before = taker.stream.arrivals.counts.received
        ended = False
        for said in taker.answers(frames):
            if "control" in said:
                conversation.control(**said["control"])
                ended |= "end" in said["control"]
            else:
                conversation.say(said)
                conversation.send()
        now = time.monotonic()
        if taker.stream.arrivals.counts.received > before:
            silent_since = now
        if now - counted > counted_every_s:
            conversation.control(counts=taker.counts())
            counted = now
        if ended or now - silent_since >= silence_s:
            break
    why = "the client said so" if ended else f"nothing came for {silence_s:g} s"
    for said in taker.stream.end():
        conversation.say(said)
    taker.record.close()
    samples = write_log(folder / RAW, taker.stream.columns.names, folder / LOG)
    said = {"type": "ended", "why": why, "samples": samples, "counts": taker.counts()}
    conversation.control(counts=taker.counts(), ended=said)


@final
class Conversation:
    """Frames over a socket; what is said leaves with `send`."""

    def __init__(self, channel: socket.socket) -> None:
        self._channel, self._frames, self._out = channel, Frames(), list[bytes]()

    def receive(self, timeout_s: float) -> list[tuple[int, bytes]] | None:
        """What has come by now, after waiting for the first of it; empty when nothing came. None: the other end is
        gone."""
        if not select.select([self._channel], [], [], timeout_s)[0]:
            return []
        data = self._channel.recv(1 << 20)
        return list(self._frames.of(data)) if data else None

    def say(self, message: Mapping[str, Any]) -> None:
        self._out.append(framed(CLIENT_TEXT, json.dumps(message).encode()))

    def control(self, **message: Any) -> None:
        self._out.append(framed(CONTROL, json.dumps(message).encode()))
        self.send()

    def send(self) -> None:
        self._channel.sendall(b"".join(self._out))
        self._out.clear()


@final
class Taker:
    """What the messages of a client do to its stream."""

    def __init__(self, file: PayloadFile, start: Start, rate_hz: float, path: Path) -> None:
        again_s = 60.0  # of a stream that was killed, from which Φ is found again
        self.rate_hz = rate_hz
        columns = Columns(file, start.pose.chain)
        self.record = Record(path, len(columns.names))
        numbers, rows = self.record.tail(round(again_s * rate_hz))
        self.stream = Stream(file, start, rate_hz)
        if len(numbers):
            for _ in self.stream.take(numbers, rows):
                pass
            arrivals = self.stream.arrivals
            self.stream.arrivals = Arrivals(arrivals.last, arrivals.time)
            self.stream.arrivals.counts.taken = self.record.size
            self.stream.arrivals.counts.received = self.record.size
        self.stream.kept = self.record.append
        self._allowance, self._filled = BURST_S * rate_hz, time.monotonic()
        self._faults = 0
        self._numbers, self._rows = list[NDArray[np.int64]](), list[Array]()

    def counts(self) -> dict[str, int | None]:
        return {**self.stream.arrivals.counts.plain(), "last": self.stream.arrivals.last}

    def answers(self, frames: Iterable[tuple[int, bytes]]) -> Iterable[Mapping[str, Any]]:
        """To all that came together; samples that follow each other are taken at once."""
        for kind, data in frames:
            try:
                if kind == CONTROL:
                    yield from self._taken()
                    yield self._welcome()
                elif kind == CLIENT_BYTES:
                    self._keep(*self._from_bytes(data))
                else:
                    said = self._from_text(data)
                    if said["type"] == "samples":
                        self._keep(*self._from_json(said))
                        continue
                    yield from self._taken()
                    if said["type"] == "zero":
                        self.stream.live.zero()
                    else:
                        yield {"control": {"end": True}}
            except ExogaugeError as error:
                yield from self._fault(error_message(error))
        yield from self._taken()

    def _welcome(self) -> Mapping[str, Any]:
        self._faults = 0
        live, columns = self.stream.live, self.stream.columns
        last = self.stream.arrivals.last
        return {
            "type": "welcome",
            "columns": list(columns.names),
            "rate_hz": self.rate_hz,
            "delay_s": live.track.lag / self.rate_hz,
            "next": 0 if last is None else last + 1,
            "limits": {
                "samples_at_once": AT_ONCE,
                "samples_per_s": ALLOWED * self.rate_hz,
                "gap_s": live.start.criteria.payload_live.longest_gap / self.rate_hz,
            },
        }

    def _taken(self) -> Iterable[Mapping[str, Any]]:
        if not self._numbers:
            return
        numbers, rows = np.concatenate(self._numbers), np.concatenate(self._rows)
        self._numbers, self._rows = [], []
        for said in self.stream.take(numbers, rows, time.monotonic()):
            if said["type"] == "error":
                yield from self._fault(said)
            else:
                yield said

    def _keep(self, first: int, rows: Array) -> None:
        now = time.monotonic()
        most = BURST_S * self.rate_hz
        self._allowance = min(self._allowance + ALLOWED * self.rate_hz * (now - self._filled), most)
        self._filled = now
        if len(rows) > self._allowance:
            self._faults = MOST_FAULTS
            detail = f"more samples than {ALLOWED:g} times the stated {self.rate_hz:g} Hz"
            advice = (
                f"Say another rate_hz, or send at most {most:.0f} at once and {ALLOWED * self.rate_hz:g} per second."
            )
            raise BadStudy(Fault(detail, "too_fast", advice, "stream"))
        self._allowance -= len(rows)
        self._numbers.append(np.arange(first, first + len(rows)))
        self._rows.append(rows)

    def _fault(self, message: Mapping[str, Any]) -> Iterable[Mapping[str, Any]]:
        yield message
        self._faults += 1
        if self._faults >= MOST_FAULTS:
            yield {"control": {"close": 1008}}

    def _from_bytes(self, data: bytes) -> tuple[int, Array]:
        width = len(self.stream.columns.names)
        if len(data) < NUMBER.size + 8 * width or (len(data) - NUMBER.size) % (8 * width):
            detail = f"a binary message is a number (u64) and whole samples of {width} float64, little-endian"
            advice = f"Send 8 + n · {8 * width} bytes: {', '.join(self.stream.columns.names)}."
            raise BadStudy(Fault(detail, "wrong_size", advice, "stream", value=f"{len(data)} bytes"))
        rows = np.frombuffer(data, "<f8", offset=NUMBER.size).reshape(-1, width)
        return self._numbered(NUMBER.unpack_from(data)[0], rows)

    def _from_text(self, data: bytes) -> dict[str, Any]:
        advice = 'Send {"type": "samples", "seq": 0, "rows": [[…]]}, {"type": "zero"} or {"type": "end"}.'
        try:
            said = json.loads(data)
        except (ValueError, RecursionError) as error:
            value = data[:60].decode(errors="replace")
            raise BadStudy(Fault("the text is no JSON", "not_json", advice, "stream", value=value)) from error
        if not isinstance(said, dict) or said.get("type") not in ("samples", "zero", "end"):
            value = str(said.get("type") if isinstance(said, dict) else said)[:60]
            raise BadStudy(Fault("there is no such message", "unknown_message", advice, "stream", value=value))
        return said

    def _from_json(self, said: Mapping[str, Any]) -> tuple[int, Array]:
        width = len(self.stream.columns.names)
        seq = said.get("seq")
        if not isinstance(seq, int) or isinstance(seq, bool) or seq < 0:
            advice = "Number samples from 0, each one more than the one before."
            raise BadStudy(Fault("`seq` is no number of a sample", "no_number", advice, "stream", value=str(seq)[:60]))
        try:
            rows = np.array(said.get("rows"), dtype=np.float64)
        except (ValueError, TypeError, OverflowError):
            rows = np.zeros(0)
        if rows.ndim != 2 or rows.shape[1] != width or not len(rows):
            advice = f"In this order: {', '.join(self.stream.columns.names)}."
            raise BadStudy(Fault(f"`rows` is a list of samples of {width} numbers", "wrong_size", advice, "stream"))
        return self._numbered(seq, rows)

    def _numbered(self, seq: int, rows: Array) -> tuple[int, Array]:
        largest_number = 2**62
        if len(rows) > AT_ONCE:
            detail, advice = f"a message may have {AT_ONCE} samples", "Send several messages."
            raise BadStudy(Fault(detail, "too_many", advice, "stream", value=str(len(rows))))
        if seq > largest_number:
            detail, advice = "the number of the sample is too large", "Number samples from 0."
            raise BadStudy(Fault(detail, "no_number", advice, "stream", value=str(seq)))
        return seq, rows


if __name__ == "__main__":
    main()
