"""What nobody measured exactly about how a device sits: where its via points are, and how it was put on each time."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import final

import numpy as np
import scipy
from numpy.typing import NDArray

from exogauge.criteria.identifying import DECLARED
from exogauge.devices.device import Band
from exogauge.devices.routing import Routing
from exogauge.identification.disturbances import ZERO
from exogauge.support.band_model import NEAR, SEARCHED, Fitted, Setting, pulls, residual
from exogauge.support.band_nuisances import Between
from exogauge.support.band_rows import WearLog, Wire, between
from exogauge.support.evidence import on_joints

Array = NDArray[np.float64]

VIA_POINTS, DONNING = "via_points", "donning"
SHAPE_DOUBT = 0.25  # of a shape's range: how far what a search has named may be off, found as it is without the rest


@final
@dataclass(frozen=True)
class Moves:
    """of: (m,) whose each input is. torque: (n D, m) [N·m] that one standard deviation of each adds at `BandInputs`."""

    of: tuple[str, ...]
    torque: Array


def scores_of_inputs(setting: Setting, fitted: Fitted, moves: Moves | None = None) -> dict[str, Array]:
    """Name -> (P, n) Σ Aᵀ w δτ per standard deviation of each of its n independent inputs. δτ: torque that the input
    adds to what the fit explains. moves: where they are known of these springs, whatever columns they have.

    Via points move every log alike, along each of three axes; how the device was put on changes a band's length in one
    log alone.
    """
    few = BandInputs(setting, fitted)
    moves = few.moves() if moves is None else moves
    scores = few.weighted.reshape(-1, fitted.A.shape[2]).T @ moves.torque
    of = np.array(moves.of)
    return {name: np.asarray(scores[:, of == name]) for name in (VIA_POINTS, DONNING) if name in moves.of}


def nuisance_torques(setting: Setting, fitted: Fitted, shapes: bool = True) -> Between | None:
    """(N, D, m) [N·m] per standard deviation of what is fitted beside the bands: how the device sits, zeros of the
    feet's sensors, shapes of what a search has named. What the samples tell next to nothing of is left to the doubt.

    No gain: it would make less of all that was measured, of noise and pull alike, and be found wherever there is noise.
    Nor what makes a band's course longer throughout: that is its natural length's, with which the moment moves at which
    it comes taut.
    """
    least_told, samples = 0.01, 1000  # of what is declared of a direction; at most, as all of this is smooth
    few = BandInputs(setting, fitted, samples)
    found = [*few.beside_lengths(), *few.zeros_of_feet(), *(few.shapes() if shapes else ())]
    if not found:
        return None
    V = np.stack(found, axis=2, dtype=np.float32)
    flat = (V * np.sqrt(few.weight)[:, :, None].astype(np.float32)).reshape(-1, V.shape[2])
    told, directions = np.linalg.eigh((flat.T @ flat).astype(np.float64))
    some = told > least_told  # none where the springs pull next to nowhere, or leave all that is measured
    return few.everywhere(V @ directions[:, some]) if some.any() else None


@final
class BandInputs:
    """Every n-th sample, weighed for all: what is smooth needs no more."""

    def __init__(self, setting: Setting, fitted: Fitted, most: int = SEARCHED) -> None:
        step = max(1, len(setting.weight) // most)
        logs = self._logs = setting.logs
        self._chosen = np.concatenate([np.arange(span.start, span.stop, step) for span in logs.spans])
        self._log, self._joints = logs.log[self._chosen], logs.joints
        self._posture = np.concatenate([each.posture[each.kept[::step]] for each in logs.logs])
        self.columns, self.weight = fitted.A[self._chosen], step * setting.weight[self._chosen]
        self.weighted = self.columns * self.weight[:, :, None]
        self._wear, self._wires = fitted.wear, setting.wires

    def residual(self, e: Array) -> Array:
        """(n, D) of (N, D)."""
        return np.asarray(e[self._chosen])

    def torques(self) -> Iterator[tuple[str, Array]]:
        """(n, D) [N·m] that one standard deviation of each input adds, and whose it is."""
        yield from ((name, torque) for name, _, torque in self._of_each_band())

    def moves(self) -> Moves:
        found = list(self.torques())
        torque = np.stack([each.ravel() for _, each in found], axis=1) if found else np.zeros((self.weight.size, 0))
        return Moves(tuple(name for name, _ in found), torque)

    def beside_lengths(self) -> Iterator[Array]:
        """(n, D) the same, less what the band's own natural length would do."""
        places = self._wear.layout.natural_length
        for _, band, torque in self._of_each_band():
            own = self.columns[:, :, places[band]]
            told = float(np.sum(self.weight * own**2))
            alone = np.count_nonzero(places == places[band]) == 1 and told > 0.0
            yield torque - own * (float(np.sum(self.weight * own * torque)) / told) if alone else torque

    def _of_each_band(self) -> Iterator[tuple[str, int, Array]]:
        """Whose it is, of which band, and (n, D) [N·m]."""
        for place in range(len(self._wear.k)):
            wire = self._wires[place]
            if wire.course.routing is None:
                continue
            band = wire.course.routing.bands[wire.course.index]
            if not (band.point_std > 0.0 or band.donning_std > 0.0):
                continue
            pull, slope = (each[self._chosen, None] for each in pulls(self._wires, self._wear, place))
            if band.point_std > 0.0:
                for each in self._moved_points(wire, band, pull, slope):
                    yield VIA_POINTS, place, band.point_std * each
            if band.donning_std > 0.0:
                for each in self._other_lengths(wire, slope):
                    yield DONNING, place, band.donning_std * each

    def zeros_of_feet(self) -> Iterator[Array]:
        """(n, D) [N·m] that one standard deviation of each zero adds: of the session's course, or of each log's own, of
        which a share is alike in all."""
        parts = {place: each for place, each in enumerate(self._logs.logs) if ZERO in each.own or ZERO in each.session}
        for place, log in parts.items():
            if ZERO in log.own:
                alone = 1.0 if ZERO in log.anew else np.sqrt(1.0 - DECLARED.alike)
                yield from self._of_logs({place: log}, alone)
        in_common = {place: log for place, log in parts.items() if ZERO not in log.anew}
        yield from self._of_logs(in_common, np.sqrt(DECLARED.alike))

    def shapes(self) -> Iterator[Array]:
        """(n, D) [N·m] of each shape of what a search has named."""
        small, wear = 1e-3, self._wear
        before = residual(self._logs, self._wires, wear) if wear.added else np.zeros(0)
        for number, each in enumerate(wear.added):
            for place in each.searched:
                shape, now = each.effect.shapes[place], list(each.shape)
                share = shape.share(now[place])
                step = small if share + small <= 1.0 else -small
                now[place] = shape.at(share + step)
                added = list(wear.added)
                added[number] = replace(each, shape=tuple(now))
                moved = replace(wear, added=tuple(added))
                yield (SHAPE_DOUBT / step) * (before - residual(self._logs, self._wires, moved))[self._chosen]

    def _of_logs(self, logs: Mapping[int, WearLog], share: float) -> Iterator[Array]:
        """(n, D) of each zero that these logs have in common. share: of a log's own."""
        columns: Array | None = None
        for place, log in logs.items():
            whole = log.session[ZERO] if ZERO in log.session else np.float32(share) * log.own[ZERO]
            rows = self._log == place
            own = log.of_slopes(whole, self._chosen[rows] - self._logs.spans[place].start)
            if columns is None:
                columns = np.zeros((*self.weight.shape, own.shape[2]))
            columns[rows, : own.shape[1]] = own
        yield from () if columns is None else np.moveaxis(columns, 2, 0)

    def everywhere(self, values: Array) -> Between:
        """(N, D, m) of (n, D, m)."""
        spans = enumerate(self._logs.spans)
        parts = [between(self._chosen[self._log == k] - span.start, span.stop - span.start) for k, span in spans]
        return Between(values, scipy.sparse.block_diag(parts, format="csr"))

    def _moved_points(self, wire: Wire, band: Band, pull: Array, slope: Array) -> Iterator[Array]:
        """(n, D) of each coordinate, per metre. pull, slope: (n, 1) as of `pulls`."""
        routing = wire.course.routing
        assert routing is not None
        moved = Routing(routing.tree, [band, *_moved(band)])
        geometry = moved.geometry(self._posture)
        jacobian = on_joints(geometry.jacobian, moved, self._joints)
        for n in range(1, geometry.length.shape[1]):
            longer = (geometry.length[:, [n]] - geometry.length[:, [0]]) / NEAR
            turned = (jacobian[:, n] - jacobian[:, 0]) / NEAR
            yield -(turned * pull + jacobian[:, 0] * (slope * longer))

    def _other_lengths(self, wire: Wire, slope: Array) -> Iterator[Array]:
        """(n, D) of each log, per metre by which the band is longer in it. slope: (n, 1) as of `pulls`."""
        torque = wire.jacobian[self._chosen] * slope
        for log in np.unique(self._log):
            yield np.where((self._log == log)[:, None], torque, 0.0)


def _moved(band: Band) -> Iterator[Band]:
    """The band with each coordinate of each of its via points moved by a hundredth of a millimetre."""
    for number, point in enumerate(band.via_points):
        for axis in range(3):
            xyz = tuple(value + NEAR * (axis == k) for k, value in enumerate(point.xyz))
            points = list(band.via_points)
            points[number] = replace(point, xyz=(xyz[0], xyz[1], xyz[2]))
            yield replace(band, via_points=tuple(points))
