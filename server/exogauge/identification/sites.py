"""Where an effect can sit, and what it does to the equations from there."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

from exogauge.effects.effect import JointSignals
from exogauge.effects.places import BaseChange, BaseSignals, EncoderSignals, LinkSignals, PairSignals, SensorSignals
from exogauge.effects.shaped import AxisSignals, in_si
from exogauge.identification.added_columns import COMPONENTS, kinds_of_body
from exogauge.identification.axis_signals import axis_signals
from exogauge.identification.equations import Equations
from exogauge.identification.model import RobotModel, Seen, Site
from exogauge.identification.preparation import Prepared, wrenches
from exogauge.identification.thinned import at_all, thinned
from exogauge.logs.derivatives import differentiate, differentiate_twice
from exogauge.robots.description import Robot, WrenchSensor
from exogauge.robots.ends import carries_nothing, takes_payload
from exogauge.robots.motion import Motion
from exogauge.robots.parameters import of_slide
from exogauge.robots.row_blocks import Swept
from exogauge.robots.rows import RowType
from exogauge.robots.tree import RigidTree

Array = NDArray[np.float64]
IntArray = NDArray[np.intp]

STEP = 1e-3  # of a coefficient, for the slope of the equations with it


@final
@dataclass(frozen=True)
class AxisSite:
    """An actuator axis."""

    axis: int

    def label(self, equations: Equations) -> tuple[str, str, str]:
        return "joint", equations.robot.joints[self.axis].name, ""

    def kinds(self, equations: Equations) -> tuple[int, ...]:
        return (equations.layout.axis(self.axis),)

    def see(self, model: RobotModel, prepared: Prepared) -> Seen:
        signals = axis_signals(model, prepared, [self.axis])[0]
        return seen_of_axis(signals)

    def in_si(self, model: RobotModel, unit: str, shape: tuple[float, ...]) -> tuple[float, str]:
        sizes = (model.sizes.velocity, model.sizes.torque, model.sizes.range)
        factor, own = in_si(unit, *(float(each[self.axis]) for each in sizes))
        if model.robot.joints[self.axis].name not in model.robot.tree.sliding:
            return factor, own
        return (factor / (2.0 * np.pi), "1/m") if own == "1/rev" else (factor, of_slide(own))


def seen_of_axis(signals: AxisSignals) -> Seen:
    return Seen(signals, lambda effect, shape: effect.columns(signals, shape)[:, :, None])


@final
@dataclass(frozen=True)
class SensorSite:
    """One component (0..5) of a sensor, or all of it (None). sensor: among `Robot.cuts`; where it is a contact,
    under a foot say, among `Robot.contacts`.

    A contact sensor's reading is no row: it stands in those of the base and of the joints between the two. What it
    reads is taken as it is, since no model tells how two feet share a load; low-passed its noise is small beside it.
    """

    sensor: int
    component: int | None
    contact: bool = False

    def of(self, robot: Robot) -> WrenchSensor:
        return (robot.contacts if self.contact else robot.cuts)[self.sensor]

    def label(self, equations: Equations) -> tuple[str, str, str]:
        part = "" if self.component is None else COMPONENTS[self.component]
        return "sensor", self.of(equations.robot).name, part

    def kinds(self, equations: Equations) -> tuple[int, ...]:
        if not self.contact:
            return tuple(equations.layout.sensor(self.sensor))  # what one does moves the bodies, and with them all six
        robot, layout = equations.robot, equations.layout
        body = robot.tree.frames[self.of(robot).frame][0]
        return tuple(k for k in kinds_of_body(robot, body) if layout.rows[k].type != RowType.SENSOR)

    def see(self, model: RobotModel, prepared: Prepared) -> Seen:
        sign = self.of(model.robot).sign
        own = slice(6 * self.sensor, 6 * self.sensor + 6)
        if self.contact:
            expected = sign * wrenches([self.of(model.robot)], prepared.log)[:, 0]
        else:
            expected = -sign * carried(model, prepared)[:, own]
        number = model.order.get(prepared.log.name, -1)
        contacts = len(model.robot.contacts) if self.contact else 0
        time = prepared.log.time - prepared.log.time[0]
        signals = SensorSignals(time, expected, -1 if self.component is None else self.component, number, contacts)
        felt = sign * np.eye(6)[None]
        if self.contact:  # the same for all of its components
            found = f"felt {self.sensor}"
            felt = model.prepared.of(prepared.log, found, lambda: self._felt(model.equations, prepared))
        if self.component is not None:
            felt = felt[:, [self.component]]  # a copy: the others need not be held for this one

        def columns(effect: Any, shape: tuple[float, ...]) -> Array:
            read = effect.columns(signals, shape)
            if self.component is None:
                return np.asarray(np.einsum("tcw,twk->tck", read, np.broadcast_to(felt, (len(time), *felt.shape[1:]))))
            return np.asarray(read[:, :, None] * felt)

        return Seen(signals, columns)

    def _felt(self, equations: Equations, prepared: Prepared) -> Array:
        """(T, 6, kinds) what a reading that is too much by one in each component takes off the rows; nothing where a
        component is a constant, as nobody measured it: what is missing then is that one."""
        own = equations.layout.in_told(self.kinds(equations))
        if not np.all(np.ptp(wrenches([self.of(equations.robot)], prepared.log), axis=0) > 0.0):
            return np.zeros((prepared.log.samples, 6, len(own)))
        felt = equations.acting_components(prepared, self.sensor)[:, :, own]
        felt *= -self.of(equations.robot).sign
        return felt

    def in_si(self, model: RobotModel, unit: str, shape: tuple[float, ...]) -> tuple[float, str]:
        own = "N" if self.component is not None and self.component < 3 else "N·m"
        if unit == "reading/reading":
            other = "N" if round(shape[0]) < 3 else "N·m"
            return 1.0, {("N", "N"): "1", ("N·m", "N·m"): "1", ("N·m", "N"): "m", ("N", "N·m"): "1/m"}[own, other]
        return 1.0, unit.replace("reading", own)


@final
@dataclass(frozen=True)
class BaseSite:
    """The base: every row feels how it stands and moves."""

    def label(self, equations: Equations) -> tuple[str, str, str]:
        return "base", "base", ""

    def kinds(self, equations: Equations) -> tuple[int, ...]:
        return every_kind(equations)

    def see(self, model: RobotModel, prepared: Prepared) -> Seen:
        motion, rate = prepared.motion, prepared.log.rate_hz
        acc, gyro, gyro_dot = (differentiate(each, rate) for each in (motion.acc, motion.gyro, motion.gyro_dot))
        time = prepared.log.time - prepared.log.time[0]
        still = (motion.acc, motion.gyro, motion.gyro_dot)
        imu, feet = model.robot.T_base_imu, wrenches(model.robot.contacts, prepared.log)
        place = np.zeros(3) if imu is None else imu.translation
        feel = bool(feet.size) and bool(np.all(np.ptp(feet, axis=0) > 0.0))
        floating = model.robot.floating
        signals = BaseSignals(time, *still, acc, gyro, gyro_dot, floating, motion.q[:, 0], place, feel, _turn(model))
        layout = model.equations.layout
        own = layout.in_told(self.kinds(model.equations))

        def columns(effect: Any, shape: tuple[float, ...]) -> Array:
            changes: Sequence[BaseChange] = effect.changes(signals, shape)
            phi = model.bodies_in(prepared.log.recording)
            rows = [response(model.equations, model.cutoff_hz, phi, prepared, change) for change in changes]
            for each, change in zip(rows, changes, strict=True):
                if change.first_torque is not None:
                    each[:, layout.told.axis(0)] -= change.first_torque
            return np.stack([each[:, own] for each in rows], axis=1)

        return Seen(signals, columns)

    def in_si(self, model: RobotModel, unit: str, shape: tuple[float, ...]) -> tuple[float, str]:
        return 1.0, unit


def _turn(model: RobotModel) -> Array:
    """(3,) [rad] by which the model holds the base to be turned."""
    found = _found_at(model, BaseSite())
    return np.array([found.get(f"about_{axis}", 0.0) for axis in "xyz"])


def _found_at(model: RobotModel, site: Site) -> dict[str, float]:
    """Name of a coefficient -> its value, of what the model holds at a site."""
    effects = model.extension.effects if model.extension else ()
    names = [(each.site, one.name) for each in effects for one in each.effect.coefficients]
    own = model.identified.added[len(model.identified.added) - len(names) :]
    return {name: float(value) for (at, name), value in zip(names, own, strict=True) if at == site}


def every_kind(equations: Equations) -> tuple[int, ...]:
    """Rows of the base, of all driven axes and of sensors inside the robot."""
    layout, joints = equations.layout, enumerate(equations.robot.joints)
    axes = [layout.axis(axis) for axis, joint in joints if joint.actuation != "none"]
    return (*layout.numbers(RowType.BASE), *axes, *layout.numbers(RowType.SENSOR))


@final
@dataclass(frozen=True)
class EncoderSite:
    """What a joint's encoder reads: every row feels where the links beyond it are. joint: its number."""

    joint: int

    def label(self, equations: Equations) -> tuple[str, str, str]:
        return "joint", equations.robot.joints[self.joint].name, ""

    def kinds(self, equations: Equations) -> tuple[int, ...]:
        return every_kind(equations)

    def see(self, model: RobotModel, prepared: Prepared) -> Seen:
        layout = model.equations.layout
        time, position = prepared.log.time - prepared.log.time[0], prepared.motion.q[:, self.joint]
        signals = EncoderSignals(time, position, _nothing_moves_before(model.robot, self.joint))
        own, held = layout.in_told(self.kinds(model.equations)), _found_at(model, self)
        phi, samples = model.bodies_in(prepared.log.recording), prepared.motion.samples
        at = thinned(samples, prepared.log.rate_hz, model.cutoff_hz)
        swept = model.prepared.of(prepared.log, "swept", lambda: Swept.of(prepared.motion.rows(at)))
        place = {told: place for place, told in enumerate(own)}
        slopes = dict[int, list[tuple[int, Array]]]()

        def moved(low: float, high: float, error: Array) -> list[tuple[int, Array]]:
            """Place of each of the site's kinds that feels it, and (T,) what."""
            wrenches = prepared.wrenches[at]
            found = read_wrongly(model.equations, phi, swept, wrenches, self.joint, low, high, error[at])[:, own]
            live = np.flatnonzero(found.any(axis=0))
            return list(zip(live.tolist(), at_all(samples, at, found[:, live]).T, strict=True))

        def columns(effect: Any, shape: tuple[float, ...]) -> Array:
            out = np.zeros((len(effect.coefficients), len(own), samples))
            for one, error, rows in zip(effect.coefficients, effect.errors(signals, shape).T, out, strict=True):
                size, read = held.get(one.name, 0.0), _with_rates(error, prepared.log.rate_hz)
                if abs(size) > STEP:
                    for kind, row in moved(0.0, size, read):
                        rows[kind] = row
                else:
                    for order in np.flatnonzero(read.any(axis=0)).tolist():
                        if order not in slopes:  # of the angle, its rate, that one's: every error goes along them
                            unit = np.zeros_like(read)
                            unit[:, order] = 1.0
                            slopes[order] = moved(-STEP, STEP, unit)
                        for kind, slope in slopes[order]:
                            rows[kind] += slope * read[:, order]
                for told, row in _of_drive(model, self.joint, read):
                    if told in place:
                        rows[place[told]] += row
            return out.transpose(2, 0, 1)

        return Seen(signals, columns)

    def in_si(self, model: RobotModel, unit: str, shape: tuple[float, ...]) -> tuple[float, str]:
        return 1.0, unit


def positions(model: RobotModel, prepared: Prepared) -> Array:
    """(T, J) [rad or m] where the joints stand: what is read, and by how much the model holds it to be wrong."""
    q, time = prepared.motion.q, prepared.log.time - prepared.log.time[0]
    for added in model.extension.effects if model.extension else ():
        if isinstance(site := added.site, EncoderSite):
            read, own = prepared.motion.q[:, site.joint], _found_at(model, site)
            signals = EncoderSignals(time, read, _nothing_moves_before(model.robot, site.joint))
            effect: Any = added.effect
            q = q.copy() if q is prepared.motion.q else q
            q[:, site.joint] += effect.errors(signals, added.shape) @ [own[one.name] for one in effect.coefficients]
    return q


def _with_rates(error: Array, rate_hz: float) -> Array:
    """(T, 3): an error (T,) of an angle, its rate and the rate of that; exactly none where it is constant."""
    if len(error) < 3 or not np.ptp(error):
        return np.stack([error, 0.0 * error, 0.0 * error], axis=1)
    return np.stack([error, differentiate(error, rate_hz), differentiate_twice(error, rate_hz)], axis=1)


def _of_drive(model: RobotModel, joint: int, error: Array) -> Iterator[tuple[int, Array]]:
    """Told rows of axes, and (T,) what friction and rotor take off each per unit of an error (T, 3) of a joint's
    angle."""
    if not error[:, 1:].any():
        return
    still = np.zeros(len(error))
    for axis, share in enumerate(model.robot.axes_from_joints[:, joint]):
        if share:
            none, row = JointSignals(still, still, still, still, still, still), np.zeros(len(error))
            moved = replace(none, velocity=share * error[:, 1], acceleration=share * error[:, 2])
            for effect, size in zip(model.equations.effects, model.identified.xi[axis], strict=True):
                row += size * (effect.column(moved) - effect.column(none))
            yield model.equations.layout.told.axis(axis), row


@final
@dataclass(frozen=True)
class PairSite:
    """axis: the one further from the base, by whose joint the pair is called. other: the driven one before it."""

    axis: int
    other: int

    def label(self, equations: Equations) -> tuple[str, str, str]:
        return "joint", equations.robot.joints[self.axis].name, ""

    def kinds(self, equations: Equations) -> tuple[int, ...]:
        return (equations.layout.axis(self.axis), equations.layout.axis(self.other))

    def see(self, model: RobotModel, prepared: Prepared) -> Seen:
        return seen_of_pair(*axis_signals(model, prepared, [self.axis, self.other]))

    def in_si(self, model: RobotModel, unit: str, shape: tuple[float, ...]) -> tuple[float, str]:
        return 1.0, unit


def seen_of_pair(own: AxisSignals, other: AxisSignals) -> Seen:
    signals = PairSignals(own, other)
    return Seen(signals, lambda effect, shape: np.asarray(effect.columns(signals, shape)))


@final
@dataclass(frozen=True)
class LinkSite:
    """body: of the tree."""

    body: int

    def label(self, equations: Equations) -> tuple[str, str, str]:
        return "link", equations.robot.tree.bodies[self.body], ""

    def kinds(self, equations: Equations) -> tuple[int, ...]:
        return kinds_of_body(equations.robot, self.body)

    def see(self, model: RobotModel, prepared: Prepared) -> Seen:
        number = model.order.get(prepared.log.name, -1)
        time = prepared.log.time - prepared.log.time[0]
        signals = LinkSignals(time, number, carries_nothing(model.robot.tree, self.body))
        rows: list[Array] = []

        def columns(effect: Any, shape: tuple[float, ...]) -> Array:
            present = effect.present(signals, shape)
            if not present:
                return np.zeros((prepared.log.samples, 4, len(self.kinds(model.equations))))
            if not rows:
                rows.append(self._rows(model.equations, prepared.motion))
            return np.asarray(-present * rows[0])

        return Seen(signals, columns)

    def _rows(self, equations: Equations, motion: Motion) -> Array:
        """(T, 4, kinds) Y φ per kg and kg·m of this link."""
        per_unit = equations.base.regroup[:, 10 * self.body : 10 * self.body + 4]
        rows = equations.of_bodies(motion, per_unit)[:, equations.layout.in_told(self.kinds(equations))]
        return np.ascontiguousarray(rows.transpose(0, 2, 1))

    def in_si(self, model: RobotModel, unit: str, shape: tuple[float, ...]) -> tuple[float, str]:
        return 1.0, unit


def seen_by(model: RobotModel, prepared: Prepared, sites: Sequence[Site]) -> dict[Site, Seen]:
    """Site -> `Site.see`."""
    single = [site.axis for site in sites if isinstance(site, AxisSite)]
    paired = [axis for site in sites if isinstance(site, PairSite) for axis in (site.axis, site.other)]
    axes = list(dict.fromkeys([*single, *paired]))
    signals = dict(zip(axes, axis_signals(model, prepared, axes), strict=True)) if axes else {}
    found: dict[Site, Seen] = {}
    for site in sites:
        if isinstance(site, AxisSite):
            found[site] = seen_of_axis(signals[site.axis])
        elif isinstance(site, PairSite):
            found[site] = seen_of_pair(signals[site.axis], signals[site.other])
        else:
            found[site] = site.see(model, prepared)
    return found


def encoders(robot: Robot) -> list[EncoderSite]:
    """Of joints that turn, but for those that bear an outside wrench, which acts elsewhere then."""
    tree = robot.tree
    bearing = {body for sensor in robot.contacts for body in _way_to_base(tree, tree.frames[sensor.frame][0])}
    return [
        EncoderSite(int(joint))
        for body, joint in enumerate(tree.dof)
        if joint >= 0 and not tree.prismatic[body] and body not in bearing
    ]


def with_zeros(robot: Robot) -> list[int]:
    """Joints of these whose zero is their own; that of the first one of a fixed base turns the robot as a whole."""
    return [each.joint for each in encoders(robot) if not _nothing_moves_before(robot, each.joint)]


def _nothing_moves_before(robot: Robot, joint: int) -> bool:
    tree = robot.tree
    before = int(tree.parent[int(np.flatnonzero(tree.dof == joint)[0])])
    return not robot.floating and not any(tree.dof[each] >= 0 for each in _way_to_base(tree, before))


def _way_to_base(tree: RigidTree, body: int) -> list[int]:
    way = list[int]()
    while body >= 0:
        way.append(body)
        body = int(tree.parent[body])
    return way


def neighbours(robot: Robot) -> list[PairSite]:
    """Every driven joint with the next driven one on its way to the base."""
    tree, found = robot.tree, list[PairSite]()
    for body, axis in enumerate(tree.dof):
        if axis < 0 or robot.joints[axis].actuation == "none":
            continue
        above = int(tree.parent[body])
        while above >= 0 and (tree.dof[above] < 0 or robot.joints[tree.dof[above]].actuation == "none"):
            above = int(tree.parent[above])
        if above >= 0:
            found.append(PairSite(int(axis), int(tree.dof[above])))
    return found


def end_links(equations: Equations) -> list[LinkSite]:
    """Bodies that carry nothing and move, or hang behind a sensor."""
    tree = equations.robot.tree
    behind = {tree.bodies.index(name) for name in tree.parts}
    return [
        LinkSite(body)
        for body in range(len(tree.bodies))
        if takes_payload(equations.robot, body) and (tree.dof[body] >= 0 or body in behind) and not _finger(tree, body)
    ]


def _finger(tree: RigidTree, body: int) -> bool:
    """Whether it is what hardly weighs on a link that carries nothing else."""
    parent = int(tree.parent[body])
    return parent >= 0 and carries_nothing(tree, parent)


def carried(model: RobotModel, prepared: Prepared) -> Array:
    """(T, 6 C) what holds and moves the bodies beyond each sensor, in its frame, without its zero."""
    return model.computed.of(
        prepared.log,
        "carried",
        lambda: model.equations.of_bodies(
            prepared.motion, model.bodies_in(prepared.log.recording), model.equations.layout.told.sensors
        ),
    )


def response(equations: Equations, cutoff_hz: float, phi: Array, prepared: Prepared, change: BaseChange) -> Array:
    """(T, told rows) what the change takes off each per unit: - d(Y φ)/dθ. phi: (B,) base parameters.

    Computed at some of the samples, with a cubic spline between: whatever moves, moves below the cut-off.
    """
    samples = prepared.motion.samples
    if not (change.acc.any() or change.gyro.any() or change.gyro_dot.any()):
        return np.zeros((samples, len(equations.layout.told)))
    at = thinned(samples, prepared.log.rate_hz, cutoff_hz)
    m = prepared.motion.rows(at)
    acc, gyro, gyro_dot = (each[at] for each in (change.acc, change.gyro, change.gyro_dot))

    def moved(step: float) -> Array:
        base = m.acc + step * acc, m.gyro + step * gyro, m.gyro_dot + step * gyro_dot
        return equations.of_bodies(Motion(m.q, m.dq, m.ddq, *base), phi)

    if not gyro.any() and not gyro_dot.any():  # then the rows are linear in it
        still = np.zeros_like(m.q)
        found = -equations.of_bodies(Motion(m.q, still, still, acc, gyro, gyro_dot), phi)
    else:
        found = (moved(-STEP) - moved(STEP)) / (2.0 * STEP)
    return at_all(samples, at, found)


def read_wrongly(
    equations: Equations, phi: Array, swept: Swept, wrenches: Array, joint: int, low: float, high: float, error: Array
) -> Array:
    """(n, told rows) what an error of a joint's angle, with its rate and the rate of that (n, 3), takes off each of n
    samples per unit, from `low` to `high` times it: as large as it is held to be it is whole there, and no slope.
    phi: (B,) base parameters. swept: what was read. wrenches: (n, S, 6) at the contact sensors.

    No row feels the angle but by what the links beyond it weigh, and by what acts on feet beyond it.
    """
    tree, way = equations.robot.tree, error.T
    turned_by_it = tree.subtree[int(np.flatnonzero(tree.dof == joint)[0])]
    beyond = np.where(turned_by_it[equations.base.columns // 10], phi, 0.0)
    feet = [tree.frames[each.frame][0] for each in equations.robot.contacts]
    bears = any(body >= 0 and turned_by_it[body] for body in feet)
    rows_of_feet = slice(0, equations.layout.told.axes.stop)

    def rows(step: float) -> Array:
        moved = swept.with_joint(joint, step * way)
        found = equations.of_bodies(moved, beyond)
        if bears:
            found[:, rows_of_feet] -= equations.acting_at(moved.q, wrenches)
        return found

    return np.asarray((rows(low) - rows(high)) / (high - low))
