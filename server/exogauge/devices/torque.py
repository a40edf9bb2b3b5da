"""What the bands do to the joints: tension by each band's force law, torque by the Jacobian of its length."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.devices.device import Band
from exogauge.devices.routing import Routing
from exogauge.effects.band import WireMotion
from exogauge.effects.band_laws import BandLaw, check_values
from exogauge.errors import BadInput, Fault

Array = NDArray[np.float64]

CHUNK = 5000  # samples whose Jacobians are held at once


@final
@dataclass(frozen=True)
class BandTorque:
    """T samples, W bands, D joints on which they act (`Routing.joints`).

    torque: (T, D) [N·m, or N on a prismatic joint] on the joint, positive along it. length: (T, W) [m].
    tension: (T, W) [N]; the largest along the band where its law differs from segment to segment.
    """

    torque: Array
    length: Array
    tension: Array


def band_torque(routing: Routing, bands: Sequence[Band], q: Array, time: Array) -> BandTorque:
    """τ = Σ J^T f with f = -T: a band over the back that bending forward stretches, pulls the trunk up again.

    bands: those of the routing in its order, with the values to use. q: (T, J) [rad or m]. time: (T,) [s], rising; laws
    with rates take them from the lengths, so q should be low-passed. Raises BadInput where a value is missing.

    Implements [Evaluator] (21).
    """
    laws = _laws(routing, bands)
    length = routing.lengths(q)
    tension, torque = np.empty((len(bands), len(q))), np.zeros((len(routing.columns), len(q)))
    whole = [w for w, law in enumerate(laws) if not law.per_segment]
    for w, (band, law) in enumerate(zip(bands, laws, strict=True)):
        motion = WireMotion(time, length[:, w], _rate(length[:, w], time))
        if law.per_segment:
            tension[w] = _pull_by_segment(routing, w, band, law, motion, q, torque)
        else:
            tension[w] = law.tension(motion, *_values(band), band.law_values)
    if whole:
        for part in _chunks(len(q)):
            jacobian = routing.geometry(q[part]).jacobian
            for w in whole:
                torque[:, part] -= jacobian[:, w].T * tension[w, part]
    return BandTorque(torque.T, length, tension.T)


def _laws(routing: Routing, bands: Sequence[Band]) -> list[BandLaw]:
    if [band.name for band in bands] != [band.name for band in routing.bands]:
        raise ValueError("the bands are not those of the routing")
    unknown = [(b.name, what) for b in bands for what in ("stiffness", "natural_length") if getattr(b, what) is None]
    if unknown:
        advice = "Give it in the device file, or let it be identified"
        raise BadInput(
            [Fault(f"band {band!r} has no {what}", "value_missing", advice, column=what) for band, what in unknown]
        )
    return [check_values(band.law, band.law_values) for band in bands]


def _values(band: Band) -> tuple[float, float]:
    assert band.stiffness is not None
    assert band.natural_length is not None
    return band.stiffness, band.natural_length


def _rate(length: Array, time: Array) -> Array:
    """(T,) [m/s] central differences."""
    return np.gradient(length, time) if len(time) > 1 else np.zeros_like(length)


def _pull_by_segment(
    routing: Routing, w: int, band: Band, law: BandLaw, motion: WireMotion, q: Array, torque: Array
) -> Array:
    """(T,) [N] the largest tension along band w; adds what it does to the joints to torque (D, T).

    Segments are measured twice: a law may need all of a log, the Jacobians of all of it would fill the memory.
    """
    measured = (routing.segments(q[part], w) for part in _chunks(len(q)))
    lengths, wraps = zip(*((segments.length, segments.wrap) for segments in measured), strict=True)
    motion = replace(motion, segment_length=np.concatenate(lengths), wrap=np.concatenate(wraps))
    tension = law.tension(motion, *_values(band), band.law_values)
    for part in _chunks(len(q)):
        torque[:, part] -= np.einsum("tsd,ts->dt", routing.segments(q[part], w).jacobian, tension[part])
    largest: Array = tension.max(axis=1)
    return largest


def _chunks(samples: int) -> Iterator[slice]:
    return (slice(start, start + CHUNK) for start in range(0, max(samples, 1), CHUNK))
