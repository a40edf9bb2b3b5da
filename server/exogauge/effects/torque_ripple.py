"""Torque that comes and goes with the position."""

from __future__ import annotations

from typing import final

import numpy as np

from exogauge.effects.effect import Quantity
from exogauge.effects.shaped import Array, AxisSignals, Shape

STEP = 0.8  # cycles per range between tried orders: a range of motion tells orders one cycle apart, and hardly less
SLOWEST, FASTEST = 3.5, 150.0  # cycles per range
PLACES = 2048  # into which a range is divided to look for peaks: 13 of the fastest cycle
FINER = 4  # points of the spectrum per cycle over the range


@final
class TorqueRipple:
    """τ = A_s sin Nθ + A_c cos Nθ, with N cycles per revolution of the joint, not necessarily whole (a gear's is not).

    N is tried from 4 to 28 cycles over the axis' own range: below are gravity and springs, also springs of another
    shape than the one that is tried. Faster ones, such as the turns of the motor behind a gear, are too many to be
    tried blindly; `promising` sees them in what a model leaves.
    One order at a time: the strongest is found first, further ones as findings of their own.
    """

    name = "torque_ripple"
    place = "joint"
    sentence = "The torque comes and goes with the position, as gear teeth and magnets pass by."
    coefficients = (Quantity("ripple_sin", "N·m"), Quantity("ripple_cos", "N·m"))
    shapes = (
        Shape("cycles", "cycles per range", SLOWEST, FASTEST, tuple(4.0 + STEP * k for k in range(31))),
    )  # fmt: skip
    departing = tuple(Quantity(f"{part}_{wave}", "N·m") for part in ("second", "by_load") for wave in ("sin", "cos"))
    confounds = ("motor_offset",)
    needs = "Slow steady motion over a wide range of positions, in both directions."
    coordinate = "position"

    def columns(self, signals: AxisSignals, shape: tuple[float, ...]) -> Array:
        (cycles,) = shape
        phase = 2.0 * np.pi * cycles / (signals.range or 1.0) * signals.position
        return np.stack([np.sin(phase), np.cos(phase)], axis=1)

    def departures(self, signals: AxisSignals, shape: tuple[float, ...]) -> Array:
        """(T, 4) the second harmonic, and the same waves with the motor's torque over its usual one."""
        load = np.abs(signals.drive)[:, None] / (signals.torque_scale or 1.0)
        (cycles,) = shape
        return np.hstack([self.columns(signals, (2.0 * cycles,)), load * self.columns(signals, shape)])

    def applies(self, signals: AxisSignals) -> bool:
        return signals.range > 0.0 and bool(np.any(signals.direction != 0.0))

    def promising(self, position: Array, residual: Array, span: float, count: int = 3) -> tuple[float, ...]:
        """Orders [cycles per range] at which residuals (n,) of steady motion rise and fall with the position (n,).

        The largest peaks of their spectrum over the position, strongest first, one cycle apart or more. span: the axis'
        range (`AxisSignals.range`). For all logs at once: a ripple has the same phase in each.
        """
        if span <= 0.0 or len(position) == 0:
            return ()
        place = np.floor((position - position.min()) / span * PLACES).astype(np.intp)
        sums = np.bincount(place, weights=residual - residual.mean())
        power = np.abs(np.fft.rfft(sums, FINER * max(PLACES, len(sums)))) ** 2
        cycles = np.arange(len(power)) * PLACES / (FINER * max(PLACES, len(sums)))
        power[(cycles < SLOWEST) | (cycles > FASTEST)] = 0.0
        found: list[float] = []
        while len(found) < count and power.max() > 0.0:
            best = float(cycles[np.argmax(power)])
            found.append(best)
            power[np.abs(cycles - best) < 1.0] = 0.0
        return tuple(found)


EFFECT = TorqueRipple()
