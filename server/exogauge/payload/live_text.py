"""A stream's messages as lines for a person: once a second what is known, and every contact."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Iterator, Mapping
from typing import IO, Any, final

import numpy as np

from exogauge.criteria.payload_dynamic import USUAL, Moving


@final
class Contact:
    """One that may not have ended."""

    def __init__(self, time: float, wrench: list[float]) -> None:
        self.start = self.last = time
        self.most = wrench[:3]

    def goes_on(self, time: float, wrench: list[float]) -> None:
        self.last = time
        if np.linalg.norm(wrench[:3]) > np.linalg.norm(self.most):
            self.most = wrench[:3]

    @property
    def line(self) -> str:
        force = ", ".join(f"{x:.3g}" for x in self.most)
        return f"contact {self.start:.3f} to {self.last:.3f} s, force on the payload up to ({force}) N"


def lines(messages: Iterable[Mapping[str, Any]], criteria: Moving = USUAL) -> Iterator[str]:
    every = 10  # estimates for one line
    contact: Contact | None = None
    told, state, counts = 0, "", dict[str, int]()
    for each in messages:
        if each["type"] == "wrench":
            for time, wrench, alarm in zip(each["t"], each["wrench"], each["alarm"], strict=True):
                if contact is not None and time - contact.last > criteria.bridged_s:
                    yield contact.line
                    contact = None
                if alarm and contact is None:
                    contact = Contact(time, wrench)
                elif alarm and contact is not None:
                    contact.goes_on(time, wrench)
        elif each["type"] == "payload":
            counts = each["counts"]
            if told % every == 0 or each["state"] != state:
                yield known_line(each)
            told, state = told + 1, each["state"]
        elif each["type"] == "error":
            place = f"sample {each['row']}: " if "row" in each else ""
            yield f"{place}{each['detail']}. {each.get('advice', '')}".strip()
    if contact is not None:
        yield contact.line
    if counts:
        yield ", ".join(f"{name.replace('_', ' ')} {number}" for name, number in counts.items() if number)


def known_line(message: Mapping[str, Any]) -> str:
    value, std, mu = message["value"], message["std"], message["mu"]
    parts = [f"{message['t']:9.2f} s", f"{message['state']:10s}", f"m {value['m']:.4g} ± {std['m']:.1g} kg"]
    parts += [f"{name} {value[name]:.3g} ± {std[name]:.1g}" for name in ("mx", "my", "mz", "Ixx", "Iyy", "Izz")]
    parts.append(f"contact from {message['threshold_n']:.2g} N")
    if message["late_ms"] is not None:
        parts.append(f"wrench {message['late_ms']:.2f} ± {message['late_std_ms']:.1g} ms late")
    if mu is not None:
        parts.append(f"μ {mu:.2f} ± {message['mu_std']:.2f}")
    if message["in_doubt"]:
        parts.append(f"not to be believed: {' '.join(message['in_doubt'])}")
    return "  ".join(parts)


AXES = ("fx", "fy", "fz", "mx", "my", "mz")


def written(messages: Iterable[Mapping[str, Any]], out: IO[str]) -> Iterator[Mapping[str, Any]]:
    """The messages, each sample's wrench also as a row of CSV."""
    rows = csv.writer(out, lineterminator="\n")
    rows.writerow(["seq", "t", *AXES, *(f"std_{axis}" for axis in AXES), "alarm", "settled"])
    for each in messages:
        if each["type"] == "wrench":
            for seq, t, wrench, std, alarm, settled in zip(
                each["seq"], each["t"], each["wrench"], each["std"], each["alarm"], each["settled"], strict=True
            ):
                rows.writerow([seq, repr(t), *wrench, *std, int(alarm), int(settled)])
        yield each
