"""Torque that comes and goes with the position."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.effects.effect import Quantity
from exogauge.effects.shaped import Array, AxisSignals, Shape

STEP = 0.8  # cycles per range between tried orders: a range of motion tells orders one cycle apart, and hardly less
SLOWEST, FASTEST = 3.5, 150.0  # cycles per range


@final
class TorqueRipple:
    """τ = A_s sin Nθ + A_c cos Nθ, with N cycles per revolution of the joint, not necessarily whole (a gear's is not).

    N is tried from 4 to 28 cycles over the axis' own range: below are gravity and springs, also springs of another
    shape than the one that is tried. Faster ones, such as the turns of the motor behind a gear, are too many to be
    tried blindly; `promising` sees them in what a model leaves.
    One order at a time: the strongest is found first, further ones as findings of their own.
    """

    name = "torque_ripple"
    words = "torque ripple"
    place = "joint"
    sentence = "The torque comes and goes with the position, as gear teeth and magnets pass by."
    coefficients = (
        Quantity("ripple_sin", "N·m", words="size of the sine"),
        Quantity("ripple_cos", "N·m", words="size of the cosine"),
    )
    shapes = (
        Shape(
            "cycles", "cycles per range", SLOWEST, FASTEST, tuple(4.0 + STEP * k for k in range(31)),
            words="cycles per revolution of the joint, or per metre that it slides",
        ),
    )  # fmt: skip
    departing = tuple(Quantity(f"{part}_{wave}", "N·m") for part in ("second", "by_load") for wave in ("sin", "cos"))
    confounds = ("motor_offset",)
    needs = "Slow steady motion over a wide range of positions, in both directions."
    coordinate = "position"

    def columns(self, signals: AxisSignals, shape: tuple[float, ...]) -> Array:
        return self.columns_of_all(signals, [shape]).T

    def columns_of_all(self, signals: AxisSignals, shapes: Sequence[tuple[float, ...]]) -> Array:
        """Where orders follow each other evenly, each wave is the one before it turned by the same angle."""
        same = 1e-9  # of a step between orders: as even as rounding leaves them
        cycles, once = np.array(shapes)[:, 0], 2.0 * np.pi / (signals.range or 1.0) * signals.position
        steps, waves = np.diff(cycles), np.empty((2 * len(cycles), len(once)))
        even = len(steps) > 0 and bool(np.all(np.abs(steps - steps[0]) < same * np.abs(steps[0])))
        turn, wave = _wave(steps[0] * once) if even else None, _wave(cycles[0] * once)
        for k, each in enumerate(cycles):
            if k:
                wave = _wave(each * once) if turn is None else wave * turn
            waves[2 * k], waves[2 * k + 1] = wave.imag, wave.real
        return waves

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
        finer = 4  # points of the spectrum per cycle over the range
        places = 2048  # into which a range is divided to look for peaks: 13 of the fastest cycle
        if span <= 0.0 or len(position) == 0:
            return ()
        place = np.floor((position - position.min()) / span * places).astype(np.intp)
        sums = np.bincount(place, weights=residual - residual.mean())
        power = np.abs(np.fft.rfft(sums, finer * max(places, len(sums)))) ** 2
        cycles = np.arange(len(power)) * places / (finer * max(places, len(sums)))
        power[(cycles < SLOWEST) | (cycles > FASTEST)] = 0.0
        found: list[float] = []
        while len(found) < count and power.max() > 0.0:
            best = float(cycles[np.argmax(power)])
            found.append(best)
            power[np.abs(cycles - best) < 1.0] = 0.0
        return tuple(found)


def _wave(phase: Array) -> NDArray[np.complex128]:
    """e^(i phase); sine and cosine are quicker one by one."""
    wave = np.empty(len(phase), dtype=np.complex128)
    wave.real, wave.imag = np.cos(phase), np.sin(phase)
    return wave


EFFECT = TorqueRipple()
