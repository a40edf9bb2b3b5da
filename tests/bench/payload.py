"""Payload: errors, coverage and bias against the truth of the sample's arm. `python -m tests.bench.payload [FIRST]`.

The paper's numbers: 40.173 kg, 21 postures of 1 s, 10 s at 250 Hz, 0.5 N and 0.05 N·m, encoders 2e-5 rad.
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before numpy is imported

import sys

import numpy as np
from numpy.typing import NDArray
from tests.payload.conftest import case

from exogauge.payload.dynamics import DynamicSolution, Method, dynamic_stage, static_prior
from exogauge.synthetic import payload as generator
from exogauge.terminal import text_table

Array = NDArray[np.float64]

SEEDS = 30
NOISY = 1e3  # rad²/s⁵: a jerk density that leaves 0.4 rad/s² of error in α
METHODS: tuple[Method, ...] = ("ls", "tls", "gtls")


def report(first: int = 0) -> None:
    """first: of thirty seeds."""
    seeds = range(first, first + SEEDS)
    print(f"\nPayload, seeds {first} to {first + SEEDS - 1}")
    print(text_table(("root mean square of the error", ""), recovery(seeds)))
    print(f"bias at a jerk density of {NOISY:g} rad²/s⁵, ± its chance")
    print(text_table(("", "m [kg]", "m c_z [kg·m]", "Ixx [kg·m²]", "μ"), [bias(seeds, each) for each in METHODS]))


def solved(seed: int, density: float | None, method: Method) -> DynamicSolution:
    static = case(seed).static
    return dynamic_stage(case(seed).rows(static.gravity, density), static_prior(static), method)


def recovery(seeds: range) -> list[list[str]]:
    found = [solved(seed, None, "gtls") for seed in seeds]
    error = np.array([each.value - case(seed).truth for each, seed in zip(found, seeds, strict=True)])
    inside = np.abs(error) < 1.96 * np.array([each.std for each in found])
    tilt = np.degrees([case(seed).static.tilt for seed in seeds]) - generator.TILT_DEG
    tilt_std = np.degrees([case(seed).static.std[10:] for seed in seeds])
    rms = np.sqrt(np.mean(error**2, axis=0))
    rows = [
        ("m", rms[0], "kg"), ("m c, worst axis", rms[1:4].max(), "kg·m"), ("I, worst entry", rms[4:10].max(), "kg·m²"),
        ("U, V, worst", np.sqrt(np.mean(tilt**2, axis=0)).max(), "°"), ("F_0, worst axis", rms[10:13].max(), "N"),
    ]  # fmt: skip
    shares = {
        "95 % intervals hold": inside, "of m, m c": inside[:, :4], "of I": inside[:, 4:10],
        "of the zero": inside[:, 10:], "of U, V": np.abs(tilt) < 1.96 * tilt_std,
    }  # fmt: skip
    held = [[name, f"{100 * np.mean(each):.1f} %"] for name, each in shares.items()]
    return [*([name, f"{value:.2g} {unit}"] for name, value, unit in rows), *held]


def bias(seeds: range, method: Method) -> list[str]:
    found = [solved(seed, NOISY, method) for seed in seeds]
    error = np.array([each.value - case(seed).truth for each, seed in zip(found, seeds, strict=True)])[:, [0, 3, 4]]
    chance = error.std(axis=0) / np.sqrt(len(error))
    mu = [each.mu for each in found]
    cells = [f"{mean:+.4f} ± {std:.4f}" for mean, std in zip(error.mean(axis=0), chance, strict=True)]
    return [method, *cells, f"{np.mean(mu):.3f}: {min(mu):.3f} to {max(mu):.3f}" if method == "gtls" else ""]


if __name__ == "__main__":
    report(*map(int, sys.argv[1:2]))
