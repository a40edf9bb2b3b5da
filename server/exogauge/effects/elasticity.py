"""A gear that gives way like a spring.

A link on a spring that may grow stiffer, step by step.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import numpy as np

from exogauge.effects.effect import Quantity
from exogauge.effects.shaped import Array, AxisSignals, Shape

SOFTEST = (2.0 * np.pi * 2.0) ** -2  # [s²] the link on its spring at 2 Hz; a softer joint is no robot's
USUAL_DAMPING = 0.15  # ζ


@final
class Elasticity:
    """τ = -ω² c (J r̈ + K r), ω = 2π f, encoder at the motor: the link lies r beyond the motor on a spring
    k = J_0 ω² with damping 2 ζ ω J_0, so that J r̈ + 2 ζ ω J_0 ṙ + k r (1 + γ |r/r_0|^p) + K r = -τ_load, and τ_load
    lacks J r̈ + K r. r_0: what it gives, were it straight, under the axis' rms torque.

    J: inertia of what the axis turns, J_0 its mean; K: slope of gravity's load over the angle; both change with the
    posture (`deflection`). c = 1/ω² if all of the load is on the spring. For a stiff spring that is c τ̈_load.

    With an encoder at the link the rotor turns by τ_load/k more, which is the same column with c < 0. That is not
    looked for: noise of the positions makes c < 0 by itself.

    It cannot be told where the motion is slow against ω and no weight bends the spring (`applies` says so), nor well
    from rotor inertia where the load is mostly gravity, whose second derivative goes with the acceleration.
    """

    name = "elasticity"
    words = "elasticity of the drive"
    place = "joint"
    sentence = "The gear gives way like a spring, so the link does not move as the motor's encoder says."
    coefficients = (Quantity("c", "s²", low=0.0, high=SOFTEST, words="1/ω² where all of the load is on the spring"),)
    shapes = (
        Shape("f", "Hz", 2.0, 30.0, (3.5, 5.0, 7.5, 15.0), words="resonance of the link on the spring"),
        Shape("zeta", "1", 0.02, 0.7, (USUAL_DAMPING,), words="damping of that resonance, as a share of critical"),
        Shape("gamma", "1", 0.0, 0.5, (0.0,), words="share by which the spring is stiffer under the usual torque"),
        Shape("power", "1", 1.0, 3.0, (2.0,), words="power with which it grows stiffer"),
    )
    confounds = ("rotor_inertia", "motor_gain")
    needs = "Fast motion with quick starts and stops, or a second encoder at the link."
    coordinate = "acceleration"
    at_turns = True

    def columns(self, signals: AxisSignals, shape: tuple[float, ...]) -> Array:
        return self.columns_of_all(signals, [shape]).T

    def columns_of_all(self, signals: AxisSignals, shapes: Sequence[tuple[float, ...]]) -> Array:
        least_stiff = 0.1  # of the spring's stiffness, that gravity leaves: with less a link would topple
        f, zeta, gamma, power = np.array(shapes).T
        samples, J_0 = len(signals.time), signals.usual_inertia or 1.0
        if samples < 3:
            return np.zeros((len(shapes), samples))
        omega = 2.0 * np.pi * f
        k = J_0 * omega**2
        usual = (signals.torque_scale or 1.0) / k
        J = np.full(samples, J_0) if signals.inertia is None else signals.inertia
        slope = np.zeros(samples) if signals.slope is None else signals.slope
        K = np.maximum(slope[:, None], (least_stiff - 1.0) * k)
        step = float(signals.time[-1] - signals.time[0]) / (samples - 1)
        r, r_ddot = deflection(signals.load, J, 2.0 * zeta * omega * J_0, k, gamma / usual**power, power, K, step)
        return np.ascontiguousarray((-(omega**2) * (J[:, None] * r_ddot + K * r)).T)

    def applies(self, signals: AxisSignals) -> bool:
        least_share = 0.01  # of the rms torque
        soft_hz = 5.0  # a soft joint's resonance; where it would not show, none does
        if len(signals.time) < 3 or not np.any(signals.direction != 0.0):
            return False
        lacking = self.columns(signals, (soft_hz, USUAL_DAMPING, 0.0, 2.0)) / (2.0 * np.pi * soft_hz) ** 2
        return float(np.std(lacking)) > least_share * signals.torque_scale


EFFECT = Elasticity()


def deflection(
    load: Array,
    inertia: Array,
    damping: Array,
    stiffness: Array,
    harder: Array,
    power: Array,
    slope: Array,
    step: float,
) -> tuple[Array, Array]:
    """r [rad] and r̈ [rad/s²], (T, L) each, of J r̈ + d ṙ + k r (1 + c |r|^p) + K r = -load, from rest.

    load [N·m], inertia J [kg·m²]: (T,); slope K [N·m/rad]: (T, L); all linear between samples. Damping d [N·m·s/rad],
    stiffness k [N·m/rad], harder c [1/rad^p], power p: (L,), of springs that know nothing of each other, side by side.
    By the trapezoidal rule, which is stable for every step [s].
    """
    coarsest_s = 1.25e-3  # of a step: a stiff gear rings at 30 Hz
    from exogauge.loops.deflection import bend

    parts = max(1, int(np.ceil(step / coarsest_s)))
    r, r_ddot = np.empty(slope.shape), np.empty(slope.shape)
    bend(load, inertia, damping, stiffness, harder, power, slope, step / parts, parts, r, r_ddot)
    return r, r_ddot
