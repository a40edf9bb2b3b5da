"""Teeth that change flank when the load changes its sign."""

from __future__ import annotations

from typing import final

import numpy as np

from exogauge.effects.effect import Quantity
from exogauge.effects.rates import second_rate_of_change
from exogauge.effects.shaped import Array, AxisSignals, Shape


@final
class Backlash:
    """τ = ½ b (K s + J s̈), encoder at the motor: the link is half a gap b from where the encoder says.

    s is the flank in contact, -1…1, and the link is behind by ½ b s: what the model asks for there is too much by the
    load's change over that way. The flank is left when the load has changed its sign, and the other one is reached
    when the load has grown to 2 w (a play of half-width w in the load; w is a share of the axis' own rms load).
    K [N·m/rad] and J [kg·m²] are the slope of gravity and the inertia that the load itself shows in the log, by its
    least squares on sin θ, cos θ and θ̈.

    With an encoder at the link the load is right and only the rotor jumps, by short pulses that steady motion leaves
    out: there it is not looked for. Where the load never changes its sign, s is constant, and masses explain it.
    """

    name = "backlash"
    sentence = "The gear has play: when the load changes its sign, the link falls to the other side of a gap."
    coefficients = (Quantity("b", "rad", low=0.0, high=0.2),)
    shapes = (Shape("w", "rms load", 0.01, 0.5, (0.02, 0.1, 0.3)),)
    confounds = ("coulomb", "motor_offset")
    needs = "Motion in which the joint's load changes its sign many times, such as slow swings through the vertical."
    coordinate = "load"
    claims_at_rest = False

    def columns(self, signals: AxisSignals, shape: tuple[float, ...]) -> Array:
        width = shape[0] * (signals.torque_scale or 1.0)
        s = np.clip(play(signals.load, width) / width, -1.0, 1.0)
        sine, cosine = np.sin(signals.position), np.cos(signals.position)
        rigid = np.stack([sine, cosine, signals.acceleration], axis=1)
        a, b, J = np.linalg.lstsq(rigid, signals.load, rcond=None)[0]
        K = a * cosine - b * sine
        return np.asarray(0.5 * (K * s + J * second_rate_of_change(s, signals.time))[:, None])

    def applies(self, signals: AxisSignals) -> bool:
        pressed = np.abs(signals.load) > self.shapes[0].high * signals.torque_scale
        return bool(np.any(pressed & (signals.load > 0.0)) and np.any(pressed & (signals.load < 0.0)))


def play(pushed: Array, half_width: float) -> Array:
    """(T,) what follows `pushed` with play, from 0: y_k = clip(y_{k-1}, pushed_k - w, pushed_k + w).

    Clips joined are a clip, two by two, then four by four: log₂ T passes and no loop over samples.
    """
    low, high, reach = pushed - half_width, pushed + half_width, 1
    while reach < len(pushed):
        before_low, before_high = low[:-reach].copy(), high[:-reach].copy()
        floor, ceiling = low[reach:].copy(), high[reach:].copy()
        low[reach:], high[reach:] = np.clip(before_low, floor, ceiling), np.clip(before_high, floor, ceiling)
        reach *= 2
    return np.asarray(np.clip(0.0, low, high))


EFFECT = Backlash()
