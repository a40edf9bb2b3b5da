"""What the logs with one wear say of it, laid end to end: supporting torque, where its bands run, what counts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal, final

import numpy as np
from numpy.typing import NDArray

from exogauge.devices.routing import Routing
from exogauge.effects.band import BandEffect, BandSignals
from exogauge.logs.filtering import LowPass
from exogauge.robots.tree import IntArray
from exogauge.support.evidence import on_joints

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
Approach = Literal["A", "B"]

BLOCK_S = 1.0  # length of the parts that count as independent


@final
@dataclass(frozen=True)
class WearLog:
    """One log: T samples of its motion, of which n are kept; D joints; X parameters of the robot.

    time: (T,) [s] from its start. posture: (T, J) [rad]. low_pass: at the rate of these samples, what the torque has
    passed; None where nothing is to be filtered. kept: (n,). torque: (n, D) [N·m] support, used: (n, D) where
    it counts. sloped: (m,) places among the kept, slope: (m, D, X) ∂torque/∂x there, None where it is not known.
    """

    name: str
    motion: str
    time: Array
    posture: Array
    kept: IntArray
    torque: Array
    used: BoolArray
    sloped: IntArray
    slope: NDArray[np.float32] | None
    low_pass: LowPass | None = None

    def as_torque(self, pull: Array) -> Array:
        """(n, …) at the kept samples, low-passed as the torque. pull: (T, …) [N]: what flips within a moment, such as
        friction, leaves less of itself in the torque."""
        return (self.low_pass.apply(pull) if self.low_pass else pull)[self.kept]


@final
class WearLogs:
    """Several logs with one wear on (or as if it were); N kept samples of all of them.

    joints: (D,) columns of q. torque: (N, D) [N·m]. used: (N, D). log: (N,) place of each sample's log. time: (N,) [s]
    in its log. share: how many logs with the wear each log stands for (1, but for logs without it).
    """

    def __init__(self, logs: Sequence[WearLog], joints: IntArray, names: Sequence[str], share: float = 1.0) -> None:
        self.logs, self.joints, self.names, self.share = tuple(logs), joints, tuple(names), share
        self.torque = np.concatenate([each.torque for each in logs])
        self.used = np.concatenate([each.used for each in logs])
        self.log = np.repeat(np.arange(len(logs)), [len(each.kept) for each in logs])
        self.time = np.concatenate([each.time[each.kept] for each in logs])
        ends = np.cumsum([each.time[-1] + float(np.median(np.diff(each.time))) for each in logs])
        self.starts, self.span = np.concatenate([[0.0], ends[:-1]]), float(ends[-1])

    @cached_property
    def clock(self) -> Array:
        """(N,) [s] with all logs laid end to end."""
        return np.asarray(self.time + self.starts[self.log])

    @cached_property
    def block(self) -> IntArray:
        """(N,) samples of one log within `BLOCK_S` share a number."""
        part = np.floor(self.time / BLOCK_S).astype(np.intp)
        return np.asarray(np.unique(self.log * (int(part.max()) + 1) + part, return_inverse=True)[1], dtype=np.intp)

    def few(self) -> WearLogs:
        """One log of every motion, kept samples alone: for a first look at many wires. Not for what has a memory."""
        motions = [each.motion for each in self.logs]
        chosen = [each for k, each in enumerate(self.logs) if motions.index(each.motion) == k]
        thin = [
            replace(
                each,
                time=each.time[each.kept],
                posture=each.posture[each.kept],
                kept=np.arange(len(each.kept)),
                low_pass=None,
            )
            for each in chosen
        ]
        return WearLogs(thin, self.joints, self.names)

    def wire(self, course: Course) -> Wire:
        """A course in these logs."""
        runs = [
            Run(each, float(start), course, self.joints) for each, start in zip(self.logs, self.starts, strict=True)
        ]
        return Wire(course, tuple(runs), self.span)


@final
@dataclass(frozen=True)
class Course:
    """Where a wire runs, whatever the log. kind, name: its place. index: of the routing's band; without a routing it is
    the joint `column` of q that stands for a wire, lengthened in the direction `sign`."""

    kind: str
    name: str
    routing: Routing | None
    index: int
    column: int = -1
    sign: float = 1.0

    def length(self, posture: Array) -> Array:
        """(T,) [m, or rad]. posture: (T, J)."""
        if self.routing is None:
            return np.asarray(self.sign * posture[:, self.column])
        return self.routing.lengths(posture)[:, self.index]

    def jacobian(self, posture: Array, joints: IntArray) -> Array:
        """(T, D)"""
        if self.routing is None:
            return np.where(joints == self.column, self.sign, 0.0) * np.ones((len(posture), 1))
        return on_joints(self.routing.geometry(posture).jacobian[:, self.index], self.routing, joints)


@final
class Run:
    """One wire in one log. length: (T,) [m]. rate: (T,) [m/s]. jacobian: (n, D) [m/rad] at the kept samples."""

    def __init__(self, log: WearLog, start: float, course: Course, joints: IntArray) -> None:
        self.log, self.start, self._course, self._joints = log, start, course, joints
        self.length = course.length(log.posture)
        self.rate = np.gradient(self.length, log.time) if len(log.time) > 1 else np.zeros_like(self.length)
        self.jacobian = course.jacobian(log.posture[log.kept], joints)

    @cached_property
    def segments(self) -> tuple[Array, Array] | None:
        """(T, S) lengths, (T, S-1) wrap angles; None for what is no wire."""
        course = self._course
        if course.routing is None:
            return None
        found = course.routing.segments(self.log.posture, course.index)
        return found.length, found.wrap

    @cached_property
    def segment_jacobian(self) -> Array:
        """(n, S, D) of the segments' lengths."""
        course = self._course
        assert course.routing is not None
        found = course.routing.segments(self.log.posture[self.log.kept], course.index)
        return on_joints(found.jacobian, course.routing, self._joints)


@final
class Wire:
    """A band, or what pulls like one, in all logs. jacobian: (N, D). length [m], rate [m/s]: (N,). shortest, travel:
    [m]."""

    def __init__(self, course: Course, runs: Sequence[Run], span: float) -> None:
        self.course, self.runs, self.span = course, tuple(runs), span
        self.jacobian = np.concatenate([run.jacobian for run in runs])
        self.length = np.concatenate([run.length[run.log.kept] for run in runs])
        self.rate = np.concatenate([run.rate[run.log.kept] for run in runs])
        self.shortest = min(float(run.length.min()) for run in runs)
        self.travel = max(float(run.length.max()) for run in runs) - self.shortest

    def signals(self, run: Run, k: float, l_0: float, per_segment: bool) -> BandSignals:
        segments = run.segments if per_segment else None
        return BandSignals(
            time=run.log.time,
            clock=run.log.time + run.start,
            start=run.start,
            span=self.span,
            length=run.length,
            rate=run.rate,
            stretch=np.maximum(run.length - l_0, 0.0),
            stiffness=k,
            natural_length=l_0,
            shortest=self.shortest,
            travel=self.travel,
            segment_length=None if segments is None else segments[0],
            wrap=None if segments is None else segments[1],
        )

    def stretch(self, l_0: float) -> Array:
        """(N,) [m] beyond l_0, low-passed as the torque: the low-pass rounds the corner where the band comes taut."""
        return np.concatenate([run.log.as_torque(np.maximum(run.length - l_0, 0.0)) for run in self.runs])

    def taut(self, l_0: float) -> Array:
        """(N,) share of the moment that a band of natural length l_0 is taut: minus the slope of `stretch` with l_0."""
        return np.concatenate([run.log.as_torque((run.length > l_0).astype(float)) for run in self.runs])

    def applies(self, effect: BandEffect, k: float, l_0: float) -> bool:
        return any(effect.applies(self.signals(run, k, l_0, effect.per_segment)) for run in self.runs)

    def columns(
        self,
        effect: BandEffect,
        shape: tuple[float, ...],
        k: float,
        l_0: float,
        pulls: Sequence[BoolArray] | None = None,
    ) -> Array:
        """(N, D, C) torque on the joints per unit of each coefficient. pulls: by log, (T,) where the band pulls at all;
        None: everywhere."""
        parts = []
        for number, run in enumerate(self.runs):
            added = effect.added_tension(self.signals(run, k, l_0, effect.per_segment), shape)
            if pulls is not None and not effect.per_segment:
                added = added * pulls[number][:, None]
            pull = run.log.as_torque(added)
            if effect.per_segment:
                parts.append(-np.einsum("nsd,nsc->ndc", run.segment_jacobian, pull))
            else:
                parts.append(-run.jacobian[:, :, None] * pull[:, None, :])
        return np.concatenate(parts)

    def tension(self, laws: Sequence[tuple[BandEffect, tuple[float, ...], Array]], k: float, l_0: float) -> list[Array]:
        """By log, (T,) [N] of the spring and of laws (effect, shape, coefficients) that pull alike all along the band.
        Below 0 they would push, which a band does not."""
        found = []
        for run in self.runs:
            signals = self.signals(run, k, l_0, False)
            whole = signals.tension
            for effect, shape, coefficients in laws:
                whole = whole + effect.added_tension(signals, shape) @ coefficients
            found.append(whole)
        return found

    def beyond_spring(self, tension: Sequence[Array], k: float, l_0: float) -> Array:
        """(N, D) torque of a band with this tension (of `tension`) beside that of its spring."""
        parts = []
        for run, own in zip(self.runs, tension, strict=True):
            pull = np.maximum(own, 0.0) - k * np.maximum(run.length - l_0, 0.0)
            parts.append(-run.jacobian * run.log.as_torque(pull)[:, None])
        return np.concatenate(parts)
