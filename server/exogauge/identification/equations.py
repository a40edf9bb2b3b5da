"""The equations of motion of a log as rows: base axes and actuator axes together ([Evaluator] (11), corrected).

    Y_o φ         = F_o
    Y_j φ - Z ξ   = F_j          Z: one column per effect and axis
    Y_c φ - s z   = F_c          what a sensor inside the robot carries; F_c = -s times its reading, z: its zero

expressed in the base link, so that neither its pose nor its velocity is needed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.effects.effect import JointEffect, JointSignals
from exogauge.estimation.statistics import Form, Statistics
from exogauge.identification.added_column import AddedColumn
from exogauge.identification.contacts import ContactPaths
from exogauge.identification.preparation import Prepared
from exogauge.robots.base_parameters import BaseParameters
from exogauge.robots.cut_rows import CutRows
from exogauge.robots.description import Robot
from exogauge.robots.motion import Motion
from exogauge.robots.row_blocks import RowBlocks
from exogauge.robots.rows import RowLayout

Array = NDArray[np.float64]
IntArray = NDArray[np.intp]
Tick = Callable[[float], None]

NONE = np.zeros(0, dtype=np.intp)
AT_REST = 0.995  # of the low-passed rest signal: above, an axis is at rest and hardly anything rings from its stop
CHUNK = 500  # samples per batch: 15 MB of regressor with its copies, whatever the log's length


@final
@dataclass(frozen=True)
class Chunk:
    """Rows of one kind. samples: (n,) places among the kept samples, ascending. block: (n, k_r + 1) = [A_r | y_r]."""

    kind: int
    samples: IntArray
    block: Array


@final
@dataclass(frozen=True)
class Equations:
    """Which parameters each row holds. P = B + A·K + E parameters x = [φ_b (B), ξ (A, K) axis by axis, ζ (E)].

    blocks: regressor rows in the parameters of base. effects: K, on every axis. added: E, each in rows of its own.
    cuts: rows of the sensors that carry bodies.
    A kind of rows is a number in `layout`. Around starts, stops and turns, where a joint may stick for longer than a
    low-passed velocity can show, an axis gives no row.
    """

    robot: Robot
    blocks: RowBlocks
    base: BaseParameters
    effects: Sequence[JointEffect]
    added: Sequence[AddedColumn] = ()
    cuts: Sequence[CutRows] = ()

    @property
    def base_size(self) -> int:
        return len(self.base.columns)

    @property
    def size(self) -> int:
        return self.first_added + len(self.added)

    @property
    def first_added(self) -> int:
        return self.base_size + len(self.robot.joints) * len(self.effects)

    @property
    def layout(self) -> RowLayout:
        return self.robot.rows

    def effect_columns(self, axis: int) -> IntArray:
        """Indices in x of the K coefficients of one axis."""
        return self.base_size + axis * len(self.effects) + np.arange(len(self.effects))

    @cached_property
    def entries(self) -> tuple[tuple[int, int], ...]:
        """(added column, row kind) of every column of `Prepared.added`."""
        return tuple((e, kind) for e, column in enumerate(self.added) for kind in column.kinds)

    @cached_property
    def _added_to(self) -> Mapping[int, tuple[IntArray, IntArray]]:
        found = {}
        for kind in {kind for _, kind in self.entries}:
            both = [(e, place) for place, (e, own) in enumerate(self.entries) if own == kind]
            e, places = np.array(both, dtype=np.intp).T
            found[kind] = (e, places)
        return found

    def added_to(self, kind: int) -> tuple[IntArray, IntArray]:
        """Added columns in the rows of one kind, and their columns in `Prepared.added`."""
        return self._added_to.get(self.layout.moving(kind), (NONE, NONE))

    def columns(self) -> list[IntArray]:
        """Indices in x of every row kind."""
        base, axes = self.blocks.columns[self.layout.base], self.blocks.columns[self.layout.axes]
        full = [np.concatenate([c, self.effect_columns(axis)]) for axis, c in enumerate(axes)]
        own = [*base, *full, *full, *(c for cut in self.cuts for c in cut.columns)]
        return [np.concatenate([c, self.first_added + self.added_to(kind)[0]]) for kind, c in enumerate(own)]

    def rows(self, prepared: Prepared, x_before: Array) -> Iterator[tuple[slice, list[Chunk]]]:
        """Chunks of (which of the kept samples, the rows they give). The blocks are overwritten by the next chunk.

        x_before: (P,) parameters of the pass before; two things are taken from them.
        The sign of the static friction, [Evaluator] (8)-(9). Differs from print: from the full residual
        r = u k_T + τ_o - (Y_j φ - F_j); (9) leaves out M_oj^T q̈_o and the acceleration of the other joints.
        The current û that the model calls for, where the current u is logged: the column of k_T is û, and k_T (u - û)
        goes to the right-hand side. At the solution this is (12) again, but the errors that u carries (its noise, and
        friction that the model does not know) no longer sit in the column, where they would shrink k_T and with it
        all torques of the joint: it is the Gauss-Newton step of least squares in amperes.
        """
        columns, reused, contacts = self.columns(), None, ContactPaths(self.robot)
        gains, layout = dict(self._gains()), self.layout
        for start in range(0, len(prepared.kept), CHUNK):
            which = slice(start, min(start + CHUNK, len(prepared.kept)))
            samples, everyone = prepared.kept[which], np.arange(which.start, which.stop)
            reused = self.blocks.fill(prepared.motion.rows(samples), len(self.effects) + len(self.added) + 1, reused)
            blocks = [block[:, : len(c) + 1] for block, c in zip(reused, columns, strict=False)]
            external = contacts.effect(prepared.motion.q[samples], prepared.wrenches[samples])
            external[:, layout.axes] -= prepared.smeared[samples, layout.told.axes]
            for kind, block in enumerate(blocks):
                block[:, -1] = external[:, kind]
            for kind, block in enumerate(blocks):
                self._fill_added(prepared, samples, kind, block)
            rows = [Chunk(kind, everyone, block) for kind, block in enumerate(blocks[layout.base])]
            rows += self._cut_rows(prepared, samples, everyone)
            for axis, signals in enumerate(_signals(prepared, samples)):
                kind = layout.axis(axis)
                block, steady = blocks[kind], prepared.steady[samples, axis]
                signals = replace(signals, rest=np.where(steady, 0.0, signals.rest))  # filters ring
                self._fill_effects(
                    signals, block, x_before[columns[kind]], gains.get(kind), len(self.added_to(kind)[0])
                )
                if not steady.all():
                    rows.append(Chunk(kind, everyone[steady], np.asfortranarray(block[steady])))
                    resting = ~steady & (signals.rest > AT_REST)
                    rows.append(Chunk(layout.resting(axis), everyone[resting], np.asfortranarray(block[resting])))
                else:
                    rows.append(Chunk(kind, everyone, block))
            yield which, [chunk for chunk in rows if len(chunk.samples)]

    def _fill_added(self, prepared: Prepared, samples: IntArray, kind: int, block: Array) -> None:
        """Write the added columns, which stand last before the right-hand side."""
        _, entries = self.added_to(kind)
        for place, entry in enumerate(entries, block.shape[1] - 1 - len(entries)):
            np.negative(prepared.added[samples, entry], out=block[:, place])

    def _cut_rows(self, prepared: Prepared, samples: IntArray, everyone: IntArray) -> Iterator[Chunk]:
        for index, cut in enumerate(self.cuts):
            kinds, smeared = self.layout.sensor(index), prepared.smeared[samples][:, self.layout.told.sensor(index)]
            motion = prepared.motion.rows(samples)
            blocks = cut.fill(motion, [len(self.added_to(kind)[0]) + 1 for kind in kinds])
            for component, (kind, block) in enumerate(zip(kinds, blocks, strict=True)):
                block[:, -1] = prepared.carried[samples, index, component] - smeared[:, component]
                self._fill_added(prepared, samples, kind, block)
                yield Chunk(kind, everyone, block)

    def collect(
        self, prepared: Prepared, x_before: Array, folds: int, form: Form = "gram", tick: Tick = lambda _: None
    ) -> list[Statistics]:
        """Statistics of `folds` consecutive parts of a log. tick: called with the fraction done."""
        parts = [Statistics.empty(self.size, self.columns(), form) for _ in range(folds)]
        edges = np.linspace(0, len(prepared.kept), folds + 1).astype(int)
        for which, rows in self.rows(prepared, x_before):
            for chunk in rows:
                cuts = np.searchsorted(chunk.samples, edges)
                for fold, part in enumerate(parts):
                    if cuts[fold] < cuts[fold + 1]:
                        part.add_rows(chunk.kind, chunk.block[cuts[fold] : cuts[fold + 1]])
            tick(which.stop / len(prepared.kept))
        return parts

    def scores(self, prepared: Prepared, x: Array, weights: Array, length: int) -> Array:
        """(blocks, P) sums of w A^T e over consecutive stretches of `length` kept samples, for a robust covariance."""
        columns = self.columns()
        sums = np.zeros((-(-len(prepared.kept) // length), self.size))
        for _, rows in self.rows(prepared, x):
            for chunk in rows:
                stretch = chunk.samples // length
                starts = np.flatnonzero(np.diff(stretch, prepend=-1))
                A, own = chunk.block[:, :-1], columns[chunk.kind]
                scored = A * (weights[chunk.kind] * (chunk.block[:, -1] - A @ x[own]))[:, None]
                sums[np.ix_(stretch[starts], own)] += np.add.reduceat(scored, starts, axis=0)
        return sums

    def residuals(self, prepared: Prepared, x: Array) -> Array:
        """(T_kept, kinds) y - A x, 0 where an axis gives no row; rows at rest are among those of their axis."""
        columns = self.columns()
        residual = np.zeros((len(prepared.kept), len(self.layout)))
        for _, rows in self.rows(prepared, x):
            for chunk in rows:
                place = self.layout.moving(chunk.kind)
                residual[chunk.samples, place] = chunk.block[:, -1] - chunk.block[:, :-1] @ x[columns[chunk.kind]]
        return residual

    def of_bodies(self, motion: Motion, phi: Array) -> Array:
        """(T, 6 or 0 + A, ...) Y φ of base and actuator axes. phi: (B, ...) base parameters, one set or several.

        By the rows that a fit takes: the compiled ones give all of a sample in a sixth of the time of inverse dynamics.
        """
        out, reused = np.empty((motion.samples, len(self.blocks.columns), *phi.shape[1:])), None
        for start in range(0, motion.samples, CHUNK):
            which = slice(start, min(start + CHUNK, motion.samples))
            reused = self.blocks.fill(motion.rows(which), 0, reused)
            for row, (block, own) in enumerate(zip(reused, self.blocks.columns, strict=True)):
                out[which, row] = block @ phi[own]
        return out

    def of_told(self, motion: Motion, phi: Array) -> Array:
        """(T, told rows, ...) Y φ of everything."""
        return np.concatenate([self.of_bodies(motion, phi), self.of_carried(motion, phi)], axis=1)

    def of_bodies_on(self, row: int, motion: Motion, phi: Array) -> Array:
        """(T,) one row of `of_bodies`, of an actuator axis, without the others."""
        out = np.empty(motion.samples)
        for start in range(0, motion.samples, CHUNK):
            which = slice(start, min(start + CHUNK, motion.samples))
            out[which] = self.blocks.fill_axis(row, motion.rows(which)) @ phi[self.blocks.columns[row]]
        return out

    def of_carried(self, motion: Motion, phi: Array) -> Array:
        """(T, 6 C, ...) the same of what the sensors carry."""
        out = np.empty((motion.samples, 6 * len(self.cuts), *phi.shape[1:]))
        for start in range(0, motion.samples if self.cuts else 0, CHUNK):
            which = slice(start, min(start + CHUNK, motion.samples))
            for index, cut in enumerate(self.cuts):
                for row, (block, own) in enumerate(zip(cut.fill(motion.rows(which)), cut.columns, strict=True)):
                    out[which, 6 * index + row] = block @ phi[own]
        return out

    def _gains(self) -> Iterator[tuple[int, int]]:
        """(row kind, place of k_T in it) of the axes whose current is logged."""
        for k, effect in enumerate(self.effects):
            if effect.name == "motor_gain":
                for axis, joint in enumerate(self.robot.joints):
                    if joint.actuation == "current":
                        kind = self.layout.axis(axis)
                        yield kind, len(self.blocks.columns[kind]) + k

    def _fill_effects(self, signals: JointSignals, block: Array, x: Array, gain: int | None, added: int) -> None:
        """Write the effects' columns of one axis. x: (k_r,) the row's parameters of the pass before.

        gain: place of k_T in the row where the current is logged. added: columns behind the effects', filled already.
        """
        first = block.shape[1] - 1 - len(self.effects) - added
        if signals.rest.any():
            without_friction = replace(signals, direction=np.zeros_like(signals.direction))
            for k, effect in enumerate(self.effects):
                np.negative(effect.column(without_friction), out=block[:, first + k])
            r = block[:, -1] - block[:, :-1] @ x
            signals = replace(signals, stick=signals.rest * np.sign(r))
        for k, effect in enumerate(self.effects):
            np.negative(effect.column(signals), out=block[:, first + k])
        if gain is not None and x[gain] > 0.0:
            excess = block[:, :-1] @ x - block[:, -1]  # torque that the current before explains too little of
            block[:, gain] -= excess / x[gain]
            block[:, -1] -= excess


def _signals(prepared: Prepared, samples: IntArray) -> list[JointSignals]:
    """What the effects of every axis see of some samples, contiguous, without a stick sign."""
    p, still = prepared, np.zeros(len(samples))
    drive, velocity, acceleration, direction, rest = (
        np.ascontiguousarray(x[samples].T) for x in (p.drive, p.axis_velocity, p.axis_acceleration, p.direction, p.rest)
    )
    return [
        JointSignals(drive[axis], velocity[axis], acceleration[axis], direction[axis], rest[axis], still)
        for axis in range(len(drive))
    ]
