"""Teeth that change flank when the load changes its sign."""

from __future__ import annotations

from typing import final

import numpy as np

from exogauge.effects.effect import Quantity
from exogauge.effects.shaped import Array, AxisSignals, Shape

PRESSED = 0.1  # of the log's rms load: what counts as a load of one sign and of the other
LEAST_LOAD = 0.02  # of the axis' rms torque: what rounding and noise make of no load is none
WINDOW = 64  # samples of a flight that are looked at together
LOWEST = 0.04  # of half the gap: a lower rebound is none


@final
class Backlash:
    """τ = ½ b (K s + J s̈), encoder at the motor: the link lags by ½ b s, s = ±1 the flank in contact.

    What the model asks for at the encoder's angle is then too much by what gravity (slope K [N·m/rad]) and inertia
    (J [kg·m²]) make of that lag, both of the posture. In contact s̈ = 0. Once the load changes its sign the link flies:
    nothing drives it, s̈ goes with the load, it lands on the other flank and rebounds with the share e of its speed
    (`flight`). t_f is the time that a flight takes under the axis' rms torque with its usual inertia.

    b comes out somewhat too large where teeth give way, which delays the landing as a wider gap does.
    An encoder at the link misses no load, and only the rotor jumps: there backlash is not looked for. Where the load
    never changes its sign, s is constant, and masses explain it.
    """

    name = "backlash"
    place = "joint"
    sentence = "The gear has play: when the load changes its sign, the link falls to the other side of a gap."
    coefficients = (Quantity("b", "rad", low=0.0, high=0.2),)
    shapes = (
        Shape("t_f", "s", 0.01, 0.3, (0.02, 0.028, 0.04, 0.057, 0.08, 0.113, 0.16)),
        Shape("e", "1", 0.0, 0.8, (0.3,)),
    )
    confounds = ("coulomb", "motor_offset")
    needs = "Motion in which the joint's load changes its sign many times, such as swings through the vertical."
    coordinate = "load"

    def columns(self, signals: AxisSignals, shape: tuple[float, ...]) -> Array:
        t_f, e = shape
        J, K, share = _swing(signals)
        kappa = 0.25 * (signals.torque_scale or 1.0) * t_f**2 * share  # ½ b J: 2 = ½ (τ / κ) t_f²
        s, s_ddot = flight(signals.load / kappa, signals.time, e)
        return np.asarray(0.5 * (K * s + J * s_ddot))[:, None]

    def applies(self, signals: AxisSignals) -> bool:
        if len(signals.load) == 0:
            return False
        usual = float(np.sqrt(np.mean(signals.load**2)))
        both = np.max(signals.load) > PRESSED * usual and np.min(signals.load) < -PRESSED * usual
        return bool(both) and usual > LEAST_LOAD * signals.torque_scale


def _swing(signals: AxisSignals) -> tuple[Array, Array, Array]:
    """J, K, and J over its usual size, (T,) each; where they are not known, what the load itself shows in the log."""
    if signals.inertia is not None and signals.slope is not None:
        return signals.inertia, signals.slope, signals.inertia / (signals.usual_inertia or 1.0)
    sine, cosine = np.sin(signals.position), np.cos(signals.position)
    rigid = np.stack([sine, cosine, signals.acceleration], axis=1)
    a, b, J = np.linalg.lstsq(rigid, signals.load, rcond=None)[0]
    return np.full(len(sine), J), np.asarray(a * cosine - b * sine), np.ones(len(sine))


def flight(pull: Array, time: Array, rebound: float) -> tuple[Array, Array]:
    """s and s̈, (T,) each, of what lies against stops at ±1 and follows s̈ = pull (T,) [1/s²] between them.

    It starts on the side that the pull presses to, leaves when the pull turns, and comes back from where it lands with
    the share `rebound` of its speed, until that takes it no further than `LOWEST`. A landing is a pulse of s̈ that turns
    the speed, shared between the samples before and after it.
    """
    samples = len(pull)
    s, s_ddot = np.empty(samples), np.zeros(samples)
    if samples < 2:
        return np.where(pull < 0.0, -1.0, 1.0), s_ddot
    h = float(time[-1] - time[0]) / (samples - 1)
    side = -1.0 if pull[0] < 0.0 else 1.0
    turns = {1.0: np.flatnonzero(pull < 0.0), -1.0: np.flatnonzero(pull > 0.0)}
    start = 0
    while start < samples:
        later = turns[side][np.searchsorted(turns[side], start) :]
        leave = int(later[0]) if later.size else samples
        s[start:leave] = side
        x, v, start = side, 0.0, leave
        while start < samples:  # in flight, window by window
            part = pull[start : start + WINDOW]
            speed = v + h * np.cumsum(part)
            place = x + h * np.cumsum(speed)
            landed = np.flatnonzero((np.abs(place) >= 1.0) & (place * speed > 0.0))
            k = int(landed[0]) if landed.size else len(part)
            s[start : start + k], s_ddot[start : start + k] = place[:k], part[:k]
            if k == len(part):
                x, v, start = float(place[-1]), float(speed[-1]), start + k
                continue
            side = 1.0 if place[k] > 0.0 else -1.0
            before = float(place[k - 1]) if k else x
            late = (1.0 - side * before) / (side * (float(place[k]) - before))
            landing = float(speed[k]) - h * (1.0 - late) * float(part[k])
            pressed = side * float(pull[min(start + k + 1, samples - 1)])
            v = -rebound * landing if (rebound * landing) ** 2 > 2.0 * LOWEST * max(pressed, 0.0) else 0.0
            turn = (landing - v) / h
            s[start + k], s_ddot[start + k] = side, late * (part[k] - turn)
            s_ddot[start + k - 1] -= (1.0 - late) * turn
            x, start = side, start + k + 1
            if v == 0.0:
                break
    return s, s_ddot


EFFECT = Backlash()
