"""What was done with the logs before they were compared, in words."""

from __future__ import annotations

from collections.abc import Sequence

from exogauge.logs.model import Log
from exogauge.support.settings import PlainLog, WornLog


def notes_on_logs(plain: Sequence[PlainLog], worn: Sequence[WornLog]) -> tuple[str, ...]:
    """Time that was left out, and logs that were low-passed before they were stored."""
    with_device = [each.log for each in worn]
    logs = [*(each.log for each in plain), *with_device]
    left_out = [_left_out(each) for each in logs if each.left_out]
    limited = [each for each in logs if each.stored is not None]
    return (*left_out, *_filtered(limited), *_not_alike(limited, [each for each in with_device if not each.stored]))


def _left_out(log: Log) -> str:
    spans = " and ".join(f"from {start:.2f} to {stop:.2f} s" for start, stop in log.left_out)
    return (
        f"{log.name}, {spans}: something touched the robot. This time is left out of the supporting torque, of the "
        "bands and of their doubt."
    )


def _filtered(limited: Sequence[Log]) -> list[str]:
    """One sentence for each low-pass."""
    said = []
    rate_hz = limited[0].rate_hz if limited else 0.0
    for stored in dict.fromkeys(each.stored for each in limited if each.stored):
        names = ", ".join(each.name for each in limited if each.stored == stored)
        said.append(
            f"The signals of {names} were low-passed at {stored.half_hz(rate_hz):.2f} Hz before they were stored. What "
            "the model says of them passes the same low-pass, so what is faster shows in no supporting torque."
        )
    return said


def _not_alike(limited: Sequence[Log], others: Sequence[Log]) -> list[str]:
    if not limited or not others:
        return []
    names, slow = (", ".join(each.name for each in logs) for logs in (others, limited))
    return [
        f"{names} with the device were not stored like {slow}. Around starts, stops and turns approach A compares "
        "what is not alike: record all logs alike."
    ]
