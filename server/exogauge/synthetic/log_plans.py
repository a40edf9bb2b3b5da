"""Which logs a sample holds: excitations to identify and to validate, and motions repeated without a suit, with it, and
without it again."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import final

SUITS = {"none": (), "normal": ("normal",), "modified": ("modified",), "both": ("normal", "modified")}
MOTIONS = ("bend", "twist")
REPETITIONS = 5
REPETITIONS_AFTER = 2  # without the suit, at the end of the session
REPETITION_S = 14.0  # two bends, or a twist to either side


@final
@dataclass(frozen=True)
class LogPlan:
    """One log to make. motion: `excitation`, `bend`, `twist` or one that is played from a file; role, name: as in
    study.yaml; suit: the one worn.

    repeats: one of several logs of the same planned motion, otherwise the motion is drawn for this log.
    """

    name: str
    role: str
    motion: str
    duration_s: float
    suit: str | None = None
    repeats: bool = False


_EXCITATIONS = (
    LogPlan("id_1", "identification", "excitation", 50.0),
    LogPlan("id_2", "identification", "excitation", 50.0),
    LogPlan("id_3", "identification", "excitation", 50.0),
    LogPlan("id_4", "identification", "excitation", 50.0),
    LogPlan("val_1", "validation", "excitation", 25.0),
    LogPlan("val_2", "validation", "excitation", 25.0),
)
_WITHOUT_SUIT = (
    LogPlan("bend_plain", "validation", "bend", 25.0),
    LogPlan("twist_plain", "validation", "twist", 25.0),
)


def log_plans(suit: str, played: Mapping[str, float] | None = None) -> tuple[LogPlan, ...]:
    """suit: a key of `SUITS`. played: motions from files and how long each takes [s], in place of bends and twists."""
    if suit == "none" and not played:
        return _EXCITATIONS + _WITHOUT_SUIT
    if suit == "none":
        plain = (
            LogPlan(f"{name}_plain", "validation", name, each, repeats=True) for name, each in (played or {}).items()
        )
        return (*_EXCITATIONS, *plain)
    return _EXCITATIONS + tuple(
        LogPlan(f"{motion}_{worn or 'plain'}_{n}", "with_device" if worn else "without_device", motion, duration,
                worn, repeats=True)
        for worn, first, last in (
            (None, 1, REPETITIONS),
            *((worn, 1, REPETITIONS) for worn in SUITS[suit]),
            (None, REPETITIONS + 1, REPETITIONS + REPETITIONS_AFTER),
        )
        for motion, duration in (played or dict.fromkeys(MOTIONS, REPETITION_S)).items()
        for n in range(first, last + 1)
    )  # fmt: skip
