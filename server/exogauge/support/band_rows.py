"""What the logs with one wear say of it, laid end to end: supporting torque, where its bands run, what counts."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import final

import numpy as np
import scipy
from numpy.typing import NDArray

from exogauge.devices.routing import Routing
from exogauge.effects.band import BandEffect, BandSignals, way_of_a_sample
from exogauge.logs.filtering import LowPass
from exogauge.robots.tree import IntArray
from exogauge.support.evidence import on_joints
from exogauge.support.inputs import ByName

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

BLOCK_S = 1.0  # length of the parts that count as independent


@final
@dataclass(frozen=True)
class WearLog:
    """One log: T samples of its motion, of which n are kept; D joints; X parameters of the robot.

    time: (T,) [s] from its start. posture: (T, J) [rad]. low_pass: at the rate of these samples, what the torque has
    passed; None where nothing is to be filtered. kept: (n,). torque: (n, D) [N·m] support, used: (n, D) where
    it counts. sloped: (m,) places among the kept, slope: (m, D, X) ∂torque/∂x there, None where it is not known. own:
    declared uncertainty -> (m, D, K) [N·m] one standard deviation each of what is this log's own.
    session: the same of what all logs have in common. anew: as of `Inputs`.
    share: how many logs with the wear it stands for. zero_std: (D,) [N·m] of a constant torque that is this log's own;
    None: there is none. partner: the log that was taken off it, if one was; ahead: [s] time in that one when this one
    begins.
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
    share: float = 1.0
    own: ByName = field(default_factory=dict)
    session: ByName = field(default_factory=dict)
    anew: frozenset[str] = frozenset()
    zero_std: Array | None = None
    partner: str = ""
    ahead: float = 0.0

    @property
    def inputs(self) -> tuple[NDArray[np.float32], ...]:
        return (*self.own.values(), *self.session.values())

    def as_torque(self, pull: Array) -> Array:
        """(n, …) at the kept samples, low-passed as the torque. pull: (T, …) [N]: what flips within a moment, such as
        friction, leaves less of itself in the torque."""
        return (self.low_pass.apply(pull) if self.low_pass else pull)[self.kept]

    def at_slopes(self, weighted: Array) -> NDArray[np.float32]:
        """(m D', P) Σ over the kept samples, of which each stands for its neighbours among the sloped ones: between
        these, slopes are taken as straight. weighted: (n, D, P); D': joints that slopes are known of."""
        m, joints = (
            len(self.sloped),
            next(each.shape[1] for each in (self.slope, *self.inputs) if each is not None),
        )
        own = weighted[:, :joints]
        flat = self._between_slopes @ own.reshape(len(own), -1)
        return np.asarray(flat.reshape(m * joints, -1).astype(np.float32))

    def of_slopes(self, columns: NDArray[np.float32], places: IntArray) -> Array:
        """(k, D', K) between the sloped samples, at k places among the kept. columns: (m, D', K)."""
        flat = self._between_slopes[:, places].T @ columns.reshape(len(columns), -1)
        return np.asarray(flat.reshape(len(places), *columns.shape[1:]), dtype=np.float64)

    @cached_property
    def _between_slopes(self) -> scipy.sparse.csr_array:
        return between(self.sloped, len(self.kept))


def between(places: IntArray, n: int) -> scipy.sparse.csr_array:
    """(m, n) share of each of n samples that each of m in rising order has in it, along straight lines."""
    m = len(places)
    if m == 0:
        return scipy.sparse.csr_array((0, n))
    at = np.interp(np.arange(n), places, np.arange(m))
    before = np.minimum(at.astype(np.intp), max(m - 2, 0))
    after = np.minimum(before + 1, m - 1)
    shares = np.concatenate([1.0 - (at - before), at - before])
    return scipy.sparse.csr_array((shares, (np.concatenate([before, after]), np.tile(np.arange(n), 2))), shape=(m, n))


@final
class WearLogs:
    """Several logs with one wear on (or as if it were); N kept samples of all of them.

    joints: (D,) columns of q. torque: (N, D) [N·m]. used: (N, D). log: (N,) place of each sample's log. spans: the
    samples of each log. time: (N,) [s] in its log. share: (N,) how many logs with the wear its log stands for (1, but
    for logs without it). zero_std: (L, D) [N·m] of a constant torque that is a log's own.
    """

    def __init__(self, logs: Sequence[WearLog], joints: IntArray, names: Sequence[str]) -> None:
        self.logs, self.joints, self.names = tuple(logs), joints, tuple(names)
        self.torque = np.concatenate([each.torque for each in logs])
        self.used = np.concatenate([each.used for each in logs])
        self.log = np.repeat(np.arange(len(logs)), [len(each.kept) for each in logs])
        ends = np.cumsum([len(each.kept) for each in logs]).tolist()
        self.spans = tuple(slice(start, end) for start, end in zip([0, *ends[:-1]], ends, strict=True))
        self.share = np.repeat([each.share for each in logs], [len(each.kept) for each in logs])
        self.time = np.concatenate([each.time[each.kept] for each in logs])
        none = np.zeros(self.torque.shape[1])
        self.zero_std = np.stack([none if each.zero_std is None else each.zero_std for each in logs])
        stops = np.cumsum([each.time[-1] + float(np.median(np.diff(each.time))) for each in logs])
        self.starts, self.span = np.concatenate([[0.0], stops[:-1]]), float(stops[-1])

    @cached_property
    def clock(self) -> Array:
        """(N,) [s] with all logs laid end to end."""
        return np.asarray(self.time + self.starts[self.log])

    @property
    def partners(self) -> tuple[tuple[int, ...], ...]:
        """Places of logs from which the same log was taken off, by that log; any other log is alone."""
        of = [each.partner or f"{each.name}/{k}" for k, each in enumerate(self.logs)]
        return tuple(tuple(k for k, own in enumerate(of) if own == name) for name in dict.fromkeys(of))

    @cached_property
    def block(self) -> IntArray:
        """(N,) samples of one log within `BLOCK_S` share a number."""
        part = np.floor(self.time / BLOCK_S).astype(np.intp)
        return np.asarray(np.unique(self.log * (int(part.max()) + 1) + part, return_inverse=True)[1], dtype=np.intp)

    def few(self) -> WearLogs:
        """One log of every motion, kept samples alone: for a first look at many wires. Not for what has a memory."""
        motions = [each.motion for each in self.logs]
        chosen = [each for k, each in enumerate(self.logs) if motions.index(each.motion) == k]
        return WearLogs([_kept(each, 1) for each in chosen], self.joints, self.names)

    def every(self, step: int) -> WearLogs:
        """All logs, of the kept samples every n-th alone. Not for what has a memory."""
        return WearLogs([_kept(each, step) for each in self.logs], self.joints, self.names)

    def wire(self, course: Course) -> Wire:
        """A course in these logs."""
        parts = [
            (course.length(each.posture), course.jacobian(each.posture[each.kept], self.joints)) for each in self.logs
        ]
        return self.wire_along(course, parts)

    def wire_along(self, course: Course, parts: Sequence[tuple[Array, Array]]) -> Wire:
        """The same where `Run.length` and `Run.jacobian` are known, by log."""
        each = zip(self.logs, self.starts, parts, strict=True)
        runs = [Run(log, float(start), course, self.joints, *part) for log, start, part in each]
        return Wire(course, runs, self.span)


def _kept(log: WearLog, step: int) -> WearLog:
    kept = log.kept[::step]
    return replace(
        log,
        time=log.time[kept],
        posture=log.posture[kept],
        kept=np.arange(len(kept)),
        torque=log.torque[::step],
        used=log.used[::step],
        sloped=np.zeros(0, dtype=np.intp),
        slope=None,
        own={},
        session={},
        low_pass=None,
    )


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

    def __init__(
        self, log: WearLog, start: float, course: Course, joints: IntArray, length: Array, jacobian: Array
    ) -> None:
        self.log, self.start, self._course, self._joints = log, start, course, joints
        self.length, self.jacobian = length, jacobian
        self.rate = np.gradient(length, log.time) if len(log.time) > 1 else np.zeros_like(length)

    @cached_property
    def clock(self) -> Array:
        """(T,) [s] with all logs laid end to end."""
        return self.log.time + self.start

    @cached_property
    def way(self) -> Array:
        """(T,) [m] that the length goes within one sample."""
        return way_of_a_sample(self.log.time, self.rate)

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


def band_wires(logs: WearLogs, routing: Routing) -> tuple[Wire, ...]:
    """Of the declared bands."""
    parts = list[list[tuple[Array, Array]]]()
    for log in logs.logs:
        length, geometry = routing.lengths(log.posture), routing.geometry(log.posture[log.kept])
        jacobian = on_joints(geometry.jacobian, routing, logs.joints)
        parts.append([(length[:, b], jacobian[:, b].copy()) for b in range(len(routing.bands))])
    courses = [Course("band", band.name, routing, b) for b, band in enumerate(routing.bands)]
    return tuple(logs.wire_along(course, part) for course, part in zip(courses, zip(*parts, strict=True), strict=True))


def stretches(wires: Sequence[Wire], l_0: Array) -> Array:
    """(N, W) [m] beyond l_0 (W,), low-passed as the torque: the low-pass rounds the corner where a band comes taut."""
    return _as_torque(wires, lambda length, rest: np.maximum(length - rest, 0.0), l_0)


def taut(wires: Sequence[Wire], l_0: Array) -> Array:
    """(N, W) share of the moment that bands are taut, low-passed likewise: minus the slope of `stretches` with l_0."""
    return _as_torque(wires, lambda length, rest: (length > rest).astype(np.float64), l_0)


def _as_torque(wires: Sequence[Wire], pull: Callable[[Array, float], Array], l_0: Array) -> Array:
    """(N, W) of all wires of a log side by side, which costs little more than one; of all logs where none is
    filtered."""
    if wires and all(run.log.low_pass is None for run in wires[0].runs):
        return np.stack([pull(wire.length, rest) for wire, rest in zip(wires, l_0, strict=True)], axis=1)
    found = []
    for runs in zip(*(wire.runs for wire in wires), strict=True):
        own = [pull(run.length, rest) for run, rest in zip(runs, l_0, strict=True)]
        found.append(runs[0].log.as_torque(np.stack(own, axis=1)))
    return np.concatenate(found) if found else np.zeros((0, 0))


@final
class Wire:
    """A band, or what pulls like one, in all logs. jacobian: (N, D). length [m], rate [m/s]: (N,). shortest,
    longest, travel: [m]."""

    def __init__(self, course: Course, runs: Sequence[Run], span: float) -> None:
        self.course, self.runs, self.span = course, tuple(runs), span
        self.jacobian = np.concatenate([run.jacobian for run in runs])
        self.length = np.concatenate([run.length[run.log.kept] for run in runs])
        self.rate = np.concatenate([run.rate[run.log.kept] for run in runs])
        self.shortest = min(float(run.length.min()) for run in runs)
        self.longest = max(float(run.length.max()) for run in runs)
        self.travel = self.longest - self.shortest

    def signals(self, run: Run, k: float, l_0: float, per_segment: bool) -> BandSignals:
        segments = run.segments if per_segment else None
        return BandSignals(
            time=run.log.time,
            clock=run.clock,
            start=run.start,
            span=self.span,
            length=run.length,
            rate=run.rate,
            stretch=np.maximum(run.length - l_0, 0.0),
            stiffness=k,
            natural_length=l_0,
            shortest=self.shortest,
            travel=self.travel,
            way=run.way,
            segment_length=None if segments is None else segments[0],
            wrap=None if segments is None else segments[1],
        )

    def every(self, logs: WearLogs, step: int) -> Wire:
        """In the same logs with every n-th of the kept samples alone (`WearLogs.every`)."""
        parts = [(run.length[run.log.kept[::step]], run.jacobian[::step]) for run in self.runs]
        return logs.wire_along(self.course, parts)

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
        return self.columns_of_all(effect, [shape], k, l_0, pulls)[0]

    def columns_of_all(
        self,
        effect: BandEffect,
        shapes: Sequence[tuple[float, ...]],
        k: float,
        l_0: float,
        pulls: Sequence[BoolArray] | None = None,
    ) -> list[Array]:
        """The same of several shapes, which are low-passed side by side."""
        return self._columns(effect, [(shape, k, l_0) for shape in shapes], pulls)

    def columns_about(
        self,
        effect: BandEffect,
        shape: tuple[float, ...],
        springs: Sequence[tuple[float, float]],
        pulls: Sequence[BoolArray] | None = None,
    ) -> list[Array]:
        """The same of a band with several springs (k, l_0)."""
        return self._columns(effect, [(shape, *spring) for spring in springs], pulls)

    def _columns(
        self,
        effect: BandEffect,
        asked: Sequence[tuple[tuple[float, ...], float, float]],
        pulls: Sequence[BoolArray] | None,
    ) -> list[Array]:
        """Of each shape, k and l_0."""
        if not asked:
            return []
        parts: list[list[Array]] = [[] for _ in asked]
        for number, run in enumerate(self.runs):
            springs = dict.fromkeys((k, l_0) for _, k, l_0 in asked)
            signals = {spring: self.signals(run, *spring, effect.per_segment) for spring in springs}
            added = [effect.added_tension(signals[k, l_0], shape) for shape, k, l_0 in asked]
            if pulls is not None and not effect.per_segment:
                added = [one * pulls[number][:, None] for one in added]
            pull = run.log.as_torque(np.concatenate(added, axis=-1))
            each = pull.shape[-1] // len(asked)
            for place, part in enumerate(parts):
                own = pull[..., place * each : (place + 1) * each]
                if effect.per_segment:
                    part.append(-np.einsum("nsd,nsc->ndc", run.segment_jacobian, np.ascontiguousarray(own)))
                else:
                    part.append(-run.jacobian[:, :, None] * own[:, None, :])
        return [np.concatenate(part) for part in parts]

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

    def pulls(
        self, laws: Sequence[tuple[BandEffect, tuple[float, ...], Array]], k: float, l_0: float, step: float
    ) -> tuple[Array, Array]:
        """(N,) each: [N] by these laws, and [N/m] by which it grows as the band is shorter, by a step [m]."""
        parts = []
        for run, *both in zip(self.runs, self.tension(laws, k, l_0), self.tension(laws, k, l_0 - step), strict=True):
            pull, more = np.maximum(both, 0.0)
            parts.append(run.log.as_torque(np.stack([pull, (more - pull) / step], axis=1)))
        pull, slope = np.concatenate(parts).T
        return pull, slope

    def beyond_spring(self, tension: Sequence[Array], k: float, l_0: float) -> Array:
        """(N, D) torque of a band with this tension (of `tension`) beside that of its spring."""
        parts = []
        for run, own in zip(self.runs, tension, strict=True):
            pull = np.maximum(own, 0.0) - k * np.maximum(run.length - l_0, 0.0)
            parts.append(-run.jacobian * run.log.as_torque(pull)[:, None])
        return np.concatenate(parts)
