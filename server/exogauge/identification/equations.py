"""The equations of motion of a log as rows: base axes and actuator axes together ([Evaluator] (11), corrected).

    Y_o φ         = F_o
    Y_j φ - Z ξ   = F_j          Z: one column per effect and axis
    Y_c φ - s z   = F_c          what a sensor inside the robot carries; F_c = -s times its reading, z: its zero

expressed in the base link, so that neither its pose nor its velocity is needed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.criteria import Criteria
from exogauge.effects.effect import JointEffect, JointSignals
from exogauge.estimation.statistics import Form, Statistics
from exogauge.identification.added_columns import AddedColumn
from exogauge.identification.contacts import ContactPaths
from exogauge.identification.preparation import Prepared
from exogauge.robots.cuts import CutRows
from exogauge.robots.description import Robot
from exogauge.robots.motion import Motion
from exogauge.robots.parameters import BaseParameters
from exogauge.robots.row_blocks import BodyLoads, RowBlocks, Swept
from exogauge.robots.rows import RowLayout, RowType

Array = NDArray[np.float64]
IntArray = NDArray[np.intp]

NONE, EVERY = np.zeros(0, dtype=np.intp), slice(None)
TOLD = (RowType.BASE, RowType.AXIS, RowType.SENSOR)
CHUNK = 500  # samples per batch: 15 MB of regressor with its copies, whatever the log's length


@final
@dataclass(frozen=True)
class Chunk:
    """Rows of one kind. samples: (n,) places among the kept samples, ascending. block: (n, k_r + 1) = [A_r | y_r].

    columns: (k_r,) of x.
    """

    kind: int
    samples: IntArray
    columns: IntArray
    block: Array

    def residual(self, x: Array) -> Array:
        """(n,) y - A x."""
        return np.asarray(self.block[:, -1] - np.dot(self.block[:, :-1], x[self.columns]))


@final
@dataclass(frozen=True)
class Equations:
    """Which parameters each row holds. P = B + A·K + E parameters x = [φ_b (B), ξ (A, K) axis by axis, ζ (E)].

    blocks: regressor rows in the parameters of base. effects: K, on every axis. added: E, each in rows of its own.
    cuts: rows of the sensors that carry bodies.
    A kind of rows is a number in `layout`. Around starts, stops and turns, where a joint may stick for longer than a
    low-passed velocity can show, an axis gives no row. criteria: of the run.
    """

    robot: Robot
    blocks: RowBlocks
    base: BaseParameters
    effects: Sequence[JointEffect]
    added: Sequence[AddedColumn] = ()
    cuts: Sequence[CutRows] = ()
    criteria: Criteria = field(default_factory=Criteria)

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
    def body_columns(self) -> tuple[IntArray, ...]:
        """Indices in x of the base parameters in each told row."""
        return (*self.blocks.columns, *(own for cut in self.cuts for own in cut.columns))

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
        """Indices in x of every row kind: of bodies, effects on an axis, added ones."""
        return list(self._columns)

    @cached_property
    def _columns(self) -> tuple[IntArray, ...]:
        found = []
        told = self.layout.in_told(range(len(self.layout)))
        for kind, row in enumerate(self.layout.rows):
            on_axis = self.effect_columns(row.place) if row.type in (RowType.AXIS, RowType.AT_REST) else NONE
            added = self.first_added + self.added_to(kind)[0]
            found.append(np.concatenate([self.body_columns[told[kind]], on_axis, added]))
        return tuple(found)

    def filled(
        self,
        prepared: Prepared,
        samples: slice | IntArray,
        signals: Sequence[JointSignals],
        added: Array,
        reused: Sequence[Array] | None = None,
    ) -> list[Array]:
        """The forward model: per base and axis row (n, k_r + 1), Fortran order, [A | y], so that A x - y is what
        bodies, low-passed as they were before the log was stored, effects on axes and added ones ask for.

        signals: what the effects of each axis see of these samples. added: (T, entries) as `Prepared.added`. reused:
        what an earlier call gave, overwritten.
        """
        motion, told = prepared.motion.rows(samples), self.layout.told
        blocks = self.blocks.fill(motion, len(self.effects) + len(self.added) + 1, reused)
        kinds = self.layout.numbers(RowType.BASE, RowType.AXIS)
        blocks = [block[:, : len(self._columns[kind]) + 1] for kind, block in zip(kinds, blocks, strict=True)]
        for kind, block in zip(kinds, blocks, strict=True):
            self._finish(prepared, samples, kind, added, block)
        for seen, block, own in zip(signals, blocks[told.axes], self.body_columns[told.axes], strict=True):
            self._fill_effects(seen, block, len(own))
        return blocks

    def filled_sensors(self, prepared: Prepared, samples: slice | IntArray, added: Array) -> list[Array]:
        """The same of the rows of sensors."""
        kinds, motion = iter(self.layout.numbers(RowType.SENSOR)), prepared.motion.rows(samples)
        blocks = []
        for cut in self.cuts:
            own = [next(kinds) for _ in cut.columns]
            filled = cut.fill(motion, [len(self.added_to(kind)[0]) + 1 for kind in own])
            for kind, block in zip(own, filled, strict=True):
                self._finish(prepared, samples, kind, added, block)
                blocks.append(block)
        return blocks

    def _finish(self, prepared: Prepared, samples: slice | IntArray, kind: int, added: Array, block: Array) -> None:
        """Write the added columns, which stand last before the right-hand side, and that."""
        (told,), (_, entries) = self.layout.in_told([kind]), self.added_to(kind)
        np.negative(prepared.smeared[samples, told], out=block[:, -1])
        for place, entry in enumerate(entries, block.shape[1] - 1 - len(entries)):
            np.negative(added[samples, entry], out=block[:, place])

    def _fill_effects(self, signals: JointSignals, block: Array, first: int) -> None:
        """Write the effects' columns of one axis, from the first on."""
        for k, effect in enumerate(self.effects, first):
            np.negative(effect.column(signals), out=block[:, k])

    def asked(
        self,
        prepared: Prepared,
        signals: Sequence[JointSignals],
        added: Array,
        alternatives: Array,
        of: slice = EVERY,
    ) -> Array:
        """(L, n, T) what each of L parameter sets asks of the told rows `of`, without what friction holds at rest.

        signals, added: as for `filled`, of all samples; signals are looked at where axes are asked for. alternatives:
        (P, L).
        """
        rows, kinds = range(*of.indices(len(self.layout.told))), self.layout.numbers(*TOLD)
        out = self._loads.of(prepared.motion, alternatives[: self.base_size])[:, of]
        for place, row in enumerate(rows):
            kind = kinds[row]
            out[:, place] += prepared.smeared[:, row]
            columns, entries = self.added_to(kind)
            for column, entry in zip(columns + self.first_added, entries, strict=True):
                out[:, place] -= np.multiply.outer(alternatives[column], added[:, entry])
            if self.layout.rows[kind].type == RowType.AXIS:
                axis = self.layout.rows[kind].place
                for effect, column in zip(self.effects, self.effect_columns(axis), strict=True):
                    out[:, place] -= np.multiply.outer(alternatives[column], effect.column(signals[axis]))
        return out

    def outside(self, prepared: Prepared, samples: slice | IntArray = EVERY) -> Array:
        """(n, told rows but those of sensors) F: what the contact sensors say of base and axes."""
        return self.acting(prepared, prepared.wrenches[samples], samples)

    def acting(self, prepared: Prepared, wrenches: Array, samples: slice | IntArray = EVERY) -> Array:
        """The same of any wrenches (n, S, 6) at the contact sensors."""
        return self._contacts.effect(prepared.motion.q[samples], wrenches)

    def acting_at(self, q: Array, wrenches: Array) -> Array:
        """The same in any postures (n, J)."""
        return self._contacts.effect(q, wrenches)

    def acting_components(self, prepared: Prepared, sensor: int, samples: slice | IntArray = EVERY) -> Array:
        """(n, 6, rows) the same of one newton, and one newton metre, of each component at a contact sensor."""
        return self._contacts.of_components(prepared.motion.q[samples], sensor)

    @cached_property
    def _contacts(self) -> ContactPaths:
        return ContactPaths(self.robot)

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
        layout, view, reused = self.layout, prepared.low_passed, None
        for which in chunks(len(prepared.kept)):
            samples, everyone = prepared.kept[which], np.arange(which.start, which.stop)
            moving = prepared.steady[samples]
            signals = [replace(each, rest=np.where(moving[:, axis], 0.0, each.rest))  # filters ring
                       for axis, each in enumerate(view.signals(samples))]  # fmt: skip
            blocks = self.filled(prepared, samples, [_without_friction(each) for each in signals], view.added, reused)
            reused, outside = blocks, self.outside(prepared, samples)
            for row, block in enumerate(blocks):
                block[:, -1] += outside[:, row]
            rows = [self._chunk(kind, everyone, blocks[kind]) for kind in layout.numbers(RowType.BASE)]
            sensors = self.filled_sensors(prepared, samples, view.added)
            carried = prepared.carried[samples].reshape(len(samples), -1)
            for kind, block, read in zip(layout.numbers(RowType.SENSOR), sensors, carried.T, strict=True):
                block[:, -1] += read
                rows.append(self._chunk(kind, everyone, block))
            for axis, seen in enumerate(signals):
                kind, steady = layout.axis(axis), moving[:, axis]
                block = blocks[kind]
                self._hold(kind, seen, block, x_before[self._columns[kind]])
                if not steady.all():
                    rows.append(self._chunk(kind, everyone[steady], np.asfortranarray(block[steady])))
                    resting = ~steady & (seen.rest > self.criteria.identifying.at_rest)
                    at_rest = np.asfortranarray(block[resting])
                    rows.append(self._chunk(layout.resting(axis), everyone[resting], at_rest))
                else:
                    rows.append(self._chunk(kind, everyone, block))
            yield which, [chunk for chunk in rows if len(chunk.samples)]

    def _chunk(self, kind: int, samples: IntArray, block: Array) -> Chunk:
        return Chunk(kind, samples, self._columns[kind], block)

    def _hold(self, kind: int, signals: JointSignals, block: Array, x: Array) -> None:
        """Friction that holds at rest, and the current that the model calls for. x: (k_r,) of the pass before."""
        first = len(self.body_columns[kind])
        if signals.rest.any():
            r = block[:, -1] - np.dot(block[:, :-1], x)
            self._fill_effects(replace(signals, stick=signals.rest * np.sign(r)), block, first)
        gain = first + self._gain if self._gain is not None else None
        if (
            gain is not None
            and self.robot.joints[self.layout.rows[kind].place].actuation == "current"
            and x[gain] > 0.0
        ):
            excess = block[:, :-1] @ x - block[:, -1]  # torque that the current before explains too little of
            block[:, gain] -= excess / x[gain]
            block[:, -1] -= excess

    @cached_property
    def _gain(self) -> int | None:
        """Place of k_T among the effects."""
        return next((k for k, effect in enumerate(self.effects) if effect.name == "motor_gain"), None)

    def collect(self, prepared: Prepared, x_before: Array, folds: int, form: Form = "gram") -> list[Statistics]:
        """Statistics of `folds` consecutive parts of a log."""
        parts = [Statistics.empty(self.size, self.columns(), form) for _ in range(folds)]
        edges = np.linspace(0, len(prepared.kept), folds + 1).astype(int)
        for _, rows in self.rows(prepared, x_before):
            for chunk in rows:
                cuts = np.searchsorted(chunk.samples, edges)
                for fold, part in enumerate(parts):
                    if cuts[fold] < cuts[fold + 1]:
                        part.add_rows(chunk.kind, chunk.block[cuts[fold] : cuts[fold + 1]])
        return parts

    def stretches(
        self, prepared: Prepared, x_before: Array, weights: Array, length: int, of: Callable[[Chunk, IntArray], Array]
    ) -> Array:
        """(stretches, P) sums of w A^T v over `length` consecutive kept samples each. of: v (n,) of a chunk whose rows
        lie in these stretches. x_before: as for `rows`."""
        sums = np.zeros((-(-len(prepared.kept) // length), self.size))
        for _, rows in self.rows(prepared, x_before):
            for chunk in rows:
                stretch = chunk.samples // length
                starts = np.flatnonzero(np.diff(stretch, prepend=-1))
                scored = chunk.block[:, :-1] * (weights[chunk.kind] * of(chunk, stretch))[:, None]
                sums[np.ix_(stretch[starts], chunk.columns)] += np.add.reduceat(scored, starts, axis=0)
        return sums

    def residuals(self, prepared: Prepared, x: Array) -> Array:
        """(T_kept, kinds) y - A x, 0 where an axis gives no row; rows at rest are among those of their axis."""
        residual = np.zeros((len(prepared.kept), len(self.layout)))
        for _, rows in self.rows(prepared, x):
            for chunk in rows:
                residual[chunk.samples, self.layout.moving(chunk.kind)] = chunk.residual(x)
        return residual

    def of_bodies(self, motion: Motion | Swept, phi: Array, of: slice = EVERY) -> Array:
        """(T, n, ...) Y φ of the told rows `of`. phi: (B, ...) base parameters, one set or several."""
        found = self._loads.of(motion, phi.reshape(len(phi), -1))[:, of]
        return np.ascontiguousarray(found.transpose(2, 1, 0)).reshape(motion.samples, -1, *phi.shape[1:])

    @cached_property
    def _loads(self) -> BodyLoads:
        frames = [cut.frame for cut in self.cuts]
        return BodyLoads(self.robot.tree, self.base.columns, self.robot.axes_from_joints, frames)


def chunks(samples: int) -> list[slice]:
    return [slice(start, min(start + CHUNK, samples)) for start in range(0, samples, CHUNK)]


def _without_friction(signals: JointSignals) -> JointSignals:
    """At rest the sign of the residual is sought of all but what holds there."""
    return replace(signals, direction=np.zeros_like(signals.direction)) if signals.rest.any() else signals
