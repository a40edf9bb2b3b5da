"""A gear that gives way like a spring."""

from __future__ import annotations

from typing import final

import numpy as np
from scipy.linalg.lapack import dtbtrs

from exogauge.effects.effect import Quantity
from exogauge.effects.rates import rate_of_change
from exogauge.effects.shaped import Array, AxisSignals, Shape

SOFTEST = (2.0 * np.pi * 2.0) ** -2  # [s²] the link on its spring at 2 Hz; a softer joint is no robot's
SOFT_HZ = 5.0  # a soft joint's resonance; where it would not show, none does
USUAL_DAMPING = 0.15  # ζ
LEAST_STIFF = 0.1  # of the spring's stiffness, that gravity leaves: with less a link would topple
LEAST_SHARE = 0.01  # of the rms torque


@final
class Elasticity:
    """τ = -ω² c (J r̈ + K r), ω = 2π f, encoder at the motor: the link lies r beyond the motor on a spring
    k = J_0 ω² with damping 2 ζ ω J_0, so that J r̈ + 2 ζ ω J_0 ṙ + (k + K) r = -τ_load, and τ_load lacks J r̈ + K r.

    J: inertia of what the axis turns, J_0 its mean; K: slope of gravity's load over the angle; both change with the
    posture (`deflection`). c = 1/ω² if all of the load is on the spring. For a stiff spring that is c τ̈_load.

    With an encoder at the link the rotor turns by τ_load/k more, which is the same column with c < 0. That is not
    looked for: noise of the positions makes c < 0 by itself.

    It cannot be told where the motion is slow against ω and no weight bends the spring (`applies` says so), nor well
    from rotor inertia where the load is mostly gravity, whose second derivative goes with the acceleration.
    """

    name = "elasticity"
    place = "joint"
    sentence = "The gear gives way like a spring, so the link does not move as the motor's encoder says."
    coefficients = (Quantity("c", "s²", low=0.0, high=SOFTEST),)
    shapes = (Shape("f", "Hz", 2.0, 30.0, (3.5, 5.0, 7.5, 15.0)), Shape("zeta", "1", 0.02, 0.7, (USUAL_DAMPING,)))
    departing = (Quantity("c_quadratic", "s²"), Quantity("c_cubic", "s²"))
    confounds = ("rotor_inertia", "motor_gain")
    needs = "Fast motion with quick starts and stops, or a second encoder at the link."
    coordinate = "acceleration"

    def columns(self, signals: AxisSignals, shape: tuple[float, ...]) -> Array:
        if len(signals.time) < 3:
            return np.zeros((len(signals.time), 1))
        spring = _Spring(signals, shape)
        return spring.lacking(signals.load, spring.response(signals.load))[:, None]

    def departures(self, signals: AxisSignals, shape: tuple[float, ...]) -> Array:
        """(T, 2) of a spring that grows stiffer, k r (1 + |r|/r_0) or k r (1 + r²/r_0²), r_0 under the axis' rms
        torque: what the further force k r |r|/r_0, or k r³/r_0², does to r and so to the torque, to first order."""
        if len(signals.time) < 3:
            return np.zeros((len(signals.time), 2))
        spring = _Spring(signals, shape)
        r = spring.response(signals.load)
        relative = np.abs(r) * spring.k / (signals.torque_scale or 1.0)
        further = [spring.k * r * relative**power for power in (1, 2)]
        return np.stack([spring.lacking(each, spring.response(each)) for each in further], axis=1)

    def applies(self, signals: AxisSignals) -> bool:
        if len(signals.time) < 3 or not np.any(signals.direction != 0.0):
            return False
        soft = _Spring(signals, (SOFT_HZ, USUAL_DAMPING))
        lacking = soft.lacking(signals.load, soft.response(signals.load)) / soft.omega**2
        return float(np.std(lacking)) > LEAST_SHARE * signals.torque_scale


@final
class _Spring:
    """The link on its spring in one log, of three samples at least. k [N·m/rad], d [N·m·s/rad]."""

    def __init__(self, signals: AxisSignals, shape: tuple[float, ...]) -> None:
        f, zeta = shape
        samples, J_0 = len(signals.time), signals.usual_inertia or 1.0
        self.omega, self.time = 2.0 * np.pi * f, signals.time
        self.k, self.d = J_0 * self.omega**2, 2.0 * zeta * self.omega * J_0
        self._J = np.full(samples, J_0) if signals.inertia is None else signals.inertia
        self._K = np.zeros(samples) if signals.slope is None else signals.slope
        self._step = float(signals.time[-1] - signals.time[0]) / (samples - 1)

    def response(self, load: Array) -> Array:
        """(T,) r [rad]"""
        stiffness = np.maximum(self.k + self._K, LEAST_STIFF * self.k)
        return deflection(load, self._J, self.d, stiffness, self._step)

    def lacking(self, load: Array, r: Array) -> Array:
        """(T,) -ω² (J r̈ + K r), which is ω² (load + k r + d ṙ)."""
        spring = self.k * r + self.d * rate_of_change(r, self.time)
        return np.asarray(self.omega**2 * (load + spring))


def deflection(load: Array, inertia: Array, damping: float, stiffness: Array, step: float) -> Array:
    """(T,) r of J r̈ + d ṙ + k r = -load from rest, by the trapezoidal rule, which is stable for every step [s].

    load [N·m], inertia [kg·m²], stiffness [N·m/rad]: (T,), damping [N·m·s/rad]. All steps are one triangular system of
    three diagonals.
    """
    J, d, k, h = inertia, damping, stiffness, step
    bands = np.zeros((3, len(load)))
    bands[0, :2] = 1.0
    bands[0, 2:] = (J / h**2 + 0.5 * d / h + 0.25 * k)[1:-1]
    bands[1, 1:-1] = (-2.0 * J / h**2 + 0.5 * k)[1:-1]
    bands[2, :-2] = (J / h**2 - 0.5 * d / h + 0.25 * k)[1:-1]
    pull = np.full(len(load), -load[0] / k[0])
    pull[2:] = -0.25 * (load[2:] + 2.0 * load[1:-1] + load[:-2])
    return np.asarray(dtbtrs(bands, pull[:, None], uplo="L")[0][:, 0])


EFFECT = Elasticity()
