"""Teeth that change flank when the load changes its sign.

A body between two teeth that give way a little: free flight, landing, ringing and rest, step by step.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import numpy as np

from exogauge.effects.effect import Quantity
from exogauge.effects.shaped import Array, AxisSignals, Shape


@final
class Backlash:
    """τ = ½ b (K s + J s̈), encoder at the motor: the link lags by ½ b s, |s| ≤ 1 in the gap, and beyond as teeth give.

    What the model asks for at the encoder's angle is then too much by what gravity (slope K [N·m/rad]) and inertia
    (J [kg·m²], J_0 its mean) make of that lag, both of the posture. Once the load changes its sign the link flies:
    only drag d [1/s] holds it, it lands on the other tooth, which gives way as a spring does (J_0 on it swings at f,
    damped by ζ), and rebounds (`between_teeth`). t_f is the time that a flight takes under the axis' rms torque with
    its usual inertia and no drag: t_f² = 2 b J_0 / τ, if the teeth were stiff. load_offset [N·m]: at which load of the
    model the teeth bear none; a model's load that is off by a hundredth changes its sign much too late.

    An encoder at the link misses no load, and only the rotor jumps: there backlash is not looked for. Where the load
    never changes its sign, s is constant, and masses explain it.
    """

    name = "backlash"
    words = "backlash"
    place = "joint"
    sentence = "The gear has play: when the load changes its sign, the link falls to the other side of a gap."
    coefficients = (Quantity("b", "rad", low=0.0, high=0.2, words="width of the gap, as an angle of the joint"),)
    shapes = (
        Shape(
            "t_f",
            "s",
            0.01,
            0.3,
            tuple(float(x) for x in np.geomspace(0.02, 0.16, 13)),
            words="time in which the link flies through the gap",
        ),
        Shape("f", "Hz", 8.0, 80.0, (30.0,), words="resonance of the link on the teeth"),
        Shape("zeta", "1", 0.02, 0.9, (0.25,), words="damping of that resonance, as a share of critical"),
        Shape("d", "1/s", 0.0, 10.0, (2.0,), words="drag on the link in the gap"),
        Shape("load_offset", "rms torque", -0.05, 0.05, (0.0,), words="load at which the teeth bear none"),
    )
    confounds = ("coulomb", "motor_offset")
    needs = "Motion in which the joint's load changes its sign many times, such as swings through the vertical."
    coordinate = "load"
    at_turns = True

    def columns(self, signals: AxisSignals, shape: tuple[float, ...]) -> Array:
        return self.columns_of_all(signals, [shape]).T

    def columns_of_all(self, signals: AxisSignals, shapes: Sequence[tuple[float, ...]]) -> Array:
        t_f, f, zeta, d, load_offset = np.array(shapes).T
        J, K, share = (each[:, None] for each in _swing(signals))
        scale = signals.torque_scale or 1.0
        kappa = 0.25 * scale * t_f**2 * share  # ½ b J: 2 = ½ (τ / κ) t_f²
        omega, step = 2.0 * np.pi * f, _step(signals.time)
        s, s_ddot = between_teeth(
            (signals.load[:, None] - load_offset * scale) / kappa,
            np.divide(K, J, out=np.zeros_like(K), where=J > 0.0)[:, 0],
            omega**2 / share,
            2.0 * zeta * omega / share,
            d / share,
            step,
        )
        return np.ascontiguousarray((0.5 * (K * s + J * s_ddot)).T)

    def applies(self, signals: AxisSignals) -> bool:
        least_load = 0.02  # of the axis' rms torque: what rounding and noise make of no load is none
        pressed = 0.1  # of the log's rms load: what counts as a load of one sign and of the other
        if len(signals.load) == 0:
            return False
        usual = float(np.sqrt(np.mean(signals.load**2)))
        both = np.max(signals.load) > pressed * usual and np.min(signals.load) < -pressed * usual
        return bool(both) and usual > least_load * signals.torque_scale


def _step(time: Array) -> float:
    return float(time[-1] - time[0]) / (len(time) - 1) if len(time) > 1 else 1.0


def _swing(signals: AxisSignals) -> tuple[Array, Array, Array]:
    """J, K, and J over its usual size, (T,) each; where they are not known, what the load itself shows in the log."""
    if signals.inertia is not None and signals.slope is not None:
        return signals.inertia, signals.slope, signals.inertia / (signals.usual_inertia or 1.0)
    sine, cosine = np.sin(signals.position), np.cos(signals.position)
    rigid = np.stack([sine, cosine, signals.acceleration], axis=1)
    a, b, J = np.linalg.lstsq(rigid, signals.load, rcond=None)[0]
    return np.full(len(sine), J), np.asarray(a * cosine - b * sine), np.ones(len(sine))


EFFECT = Backlash()


def between_teeth(
    pull: Array, back: Array, tooth: Array, damping: Array, drag: Array, step: float
) -> tuple[Array, Array]:
    """s and s̈, (T, L) each and means over the time to the next sample, of what follows

    s̈ = pull - back s - drag ṡ - [tooth (s ∓ 1) + damping ṡ where |s| > 1],

    pull, tooth [1/s²], damping, drag [1/s]: (T, L), L bodies that know nothing of each other, side by side; back
    [1/s²]: (T,); step [s] between samples. From rest on the tooth that the first pull presses to. Implicit steps,
    stable however stiff a tooth is.
    """
    finest_s = 2.5e-4  # of a step: teeth ring at some tens of hertz
    from exogauge.loops.dead_zone import fly

    if len(pull) < 2:
        return np.where(pull < 0.0, -1.0, 1.0), np.zeros(pull.shape)
    parts = max(1, int(np.ceil(step / finest_s)))
    s, s_ddot = np.empty(pull.shape), np.empty(pull.shape)
    fly(pull, back, tooth, damping, drag, step / parts, parts, s, s_ddot)
    return s, s_ddot
