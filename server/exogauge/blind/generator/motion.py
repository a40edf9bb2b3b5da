"""Which logs a case has, what each is for, and which show the same motion.

Excitation: every joint on its own sum of sines, run through fast and slow and stopped, each joint at its own times.

Positions, velocities and accelerations are closed forms, so a joint that stops stands exactly still.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.synthetic.robot_facts import Joint

DURATION_S = 25.0


@final
@dataclass(frozen=True)
class LogPlan:
    """path: logs of one path show the same motion. motion: its name, where logs are compared by it."""

    name: str
    role: str
    path: int
    motion: str | None = None

    @property
    def worn(self) -> bool:
        return self.role == "with_device"


PLAIN = (
    *(LogPlan(f"id_{n + 1}", "identification", n) for n in range(4)),
    *(LogPlan(f"val_{n + 1}", "validation", 4 + n) for n in range(2)),
)
WITH_DEVICE = (  # in the order in which they were recorded
    *(LogPlan(f"id_{n + 1}", "identification", n) for n in range(3)),
    LogPlan("val_1", "validation", 3),
    LogPlan("reach_plain", "without_device", 4, "reach"),
    LogPlan("reach_worn_1", "with_device", 4, "reach"),
    LogPlan("reach_worn_2", "with_device", 4, "reach"),
    LogPlan("sway_plain", "without_device", 5, "sway"),
    LogPlan("sway_worn", "with_device", 5, "sway"),
)


Array = NDArray[np.float64]

RATE_HZ = 200.0
FASTEST, QUICKEST = 1.8, 7.0  # of any joint [rad/s, rad/s²]
_RAMP_S = 0.4  # from one pace to the next
_STANDING_S = 0.5  # at least, at both ends
_PACES = (  # relative to a joint's fastest run: least, most, shortest [s], longest [s]
    (0.7, 1.0, 3.0, 5.0),
    (0.05, 0.15, 1.5, 2.5),
    (0.4, 0.7, 2.0, 4.0),
    (0.0, 0.0, 0.8, 1.4),
    (0.15, 0.3, 1.5, 3.0),
)


@final
@dataclass(frozen=True)
class Motion:
    """L logs of T samples at `RATE_HZ`. time: (T,) [s]; q, dq, ddq: (L, T, J) [rad, rad/s, rad/s²]."""

    time: Array
    q: Array
    dq: Array
    ddq: Array


def excitations(rng: np.random.Generator, joints: Sequence[Joint], logs: int, duration_s: float) -> Motion:
    """Each log its own."""
    time = np.arange(round(duration_s * RATE_HZ)) / RATE_HZ
    runs = [[_run(rng, joint, time) for joint in joints] for _ in range(logs)]
    q, dq, ddq = np.moveaxis(np.array(runs), (2, 3), (0, 2))
    return Motion(time, q, dq, ddq)


def _run(rng: np.random.Generator, joint: Joint, time: Array) -> Array:
    """(3, T): position, velocity, acceleration of one joint along one path at changing pace."""
    phase, pace, pace_dot = _paced(rng, time)
    w = 2 * np.pi * np.exp(np.linspace(np.log(0.07), np.log(0.45), 4) + rng.uniform(-0.15, 0.15, 4))
    size, shift = rng.uniform(0.5, 1.0, 4) * w**-0.5, rng.uniform(0.0, 2 * np.pi, 4)
    argument = np.outer(phase, w) + shift
    path, slope, bend = np.sin(argument) @ size, np.cos(argument) @ (size * w), -np.sin(argument) @ (size * w**2)
    wave = np.array([path, slope * pace, bend * pace**2 + slope * pace_dot])
    largest = np.abs(wave).max(axis=1)
    reach = rng.uniform(0.7, 1.0) * 0.5 * (joint.upper - joint.lower)
    scale = min(reach / largest[0], rng.uniform(0.7, 1.0) * FASTEST / largest[1], QUICKEST / largest[2])
    wave *= scale
    room = 0.5 * (joint.upper - joint.lower) - scale * largest[0]
    wave[0] += 0.5 * (joint.upper + joint.lower) + rng.uniform(-1.0, 1.0) * room
    return np.asarray(wave)


def _paced(rng: np.random.Generator, time: Array) -> tuple[Array, Array, Array]:
    """How far along the path, how fast, how much faster: (T,) each. At a pace of 0 the joint stands still."""
    phase, pace, pace_dot = np.zeros_like(time), np.zeros_like(time), np.zeros_like(time)
    before = 0.0
    for start, level in _schedule(rng, float(time[-1]) - _STANDING_S - _RAMP_S):
        x = np.clip((time - start) / _RAMP_S, 0.0, 1.0)
        change, before = level - before, level
        pace_dot += change * 30.0 * x**2 * (1.0 - x) ** 2 / _RAMP_S
        pace += change * x**3 * (10.0 - 15.0 * x + 6.0 * x**2)
        phase += change * (_RAMP_S * x**4 * (2.5 - 3.0 * x + x**2) + np.maximum(time - start - _RAMP_S, 0.0))
    pace[np.abs(pace) < 1e-12] = 0.0
    return phase, pace, pace_dot


def _schedule(rng: np.random.Generator, end: float) -> list[tuple[float, float]]:
    """When a joint changes to which pace; all sorts of `_PACES` once in random order, then again; 0 at the end."""
    changes, start = list[tuple[float, float]](), _STANDING_S * (1.0 + rng.uniform())
    while start < end:
        for kind in rng.permutation(len(_PACES)):
            least, most, shortest, longest = _PACES[kind]
            changes.append((start, float(rng.uniform(least, most))))
            start += _RAMP_S + float(rng.uniform(shortest, longest))
    return [change for change in changes if change[0] < end] + [(end, 0.0)]
