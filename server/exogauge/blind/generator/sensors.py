"""From what is to what is logged: steps and noise of encoder, current and thermometer."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

ENCODER_COUNTS = 2**14  # per motor turn
CURRENT_NOISE, CURRENT_STEP = 0.02, 0.005  # [A]
TEMPERATURE_NOISE, TEMPERATURE_STEP = 0.05, 0.1  # [°C]
ZERO = 3.0  # std of a force/torque sensor's zero error, in noises
_FINEST = 0.05  # step of its converters, in noises


def encoder(rng: np.random.Generator, angle: Array, gear: float) -> Array:
    """Counts of the motor encoder, in joint angle [rad]; a jitter of half a step goes before the counting."""
    step = encoder_step(gear)
    return np.asarray(np.round(angle / step + 0.5 * rng.standard_normal(angle.shape)) * step)


def encoder_step(gear: float) -> float:
    return float(2 * np.pi / (ENCODER_COUNTS * gear))


def encoder_std(gear: float) -> float:
    """[rad] of what `encoder` adds: jitter and counting."""
    return float(encoder_step(gear) * np.sqrt(0.25 + 1.0 / 12.0))


def current(rng: np.random.Generator, values: Array) -> Array:
    """[A]"""
    return _stepped(values + CURRENT_NOISE * rng.standard_normal(values.shape), CURRENT_STEP)


def current_std() -> float:
    """[A] of what `current` adds."""
    return float(np.sqrt(CURRENT_NOISE**2 + CURRENT_STEP**2 / 12.0))


def thermometer(rng: np.random.Generator, values: Array) -> Array:
    """[°C]"""
    return _stepped(values + TEMPERATURE_NOISE * rng.standard_normal(values.shape), TEMPERATURE_STEP)


def noisy(rng: np.random.Generator, values: Array, std: float) -> Array:
    """An axis of a force/torque sensor."""
    return _stepped(values + std * rng.standard_normal(values.shape), _FINEST * std)


def _stepped(values: Array, step: float) -> Array:
    return np.asarray(np.round(values / step) * step)
