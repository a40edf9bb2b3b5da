"""Three workshop tools of another simulation, with the four levels of noise of who published them, and their metric.

Nadeau, Giamou, Kelly: The Sum of Its Parts, ICRA 2023. `python -m tests.payload.tools` prints what comes out.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
from numpy.typing import NDArray

from exogauge.payload.dynamics import DynamicSolution, Method, Prior, dynamic_rows, dynamic_stage, static_prior
from exogauge.payload.sensor_motion import SensorMotion
from exogauge.terminal import text_table

Array = NDArray[np.float64]

TOOLS = Path(__file__).resolve().parents[3] / "shared/data/starlab_tools"
NAMES = ("Hammer", "Clamp", "Screwdriver")
GRAVITY = np.array([0.0, 0.0, 9.81])  # along +z there
NOISE = {"none": 0.0, "low": 0.5, "moderate": 1.0, "high": 2.0}
ACCELERATION, ANGULAR, FORCE, MOMENT = 0.05, 0.5, 0.1, 0.005  # std at `moderate` [m/s², rad/s², N, N·m]


@dataclass(frozen=True)
class Tool:
    """motion, wrench (T, 6) in the sensor's axes, without noise; phi: (10,) of who simulated them, our order."""

    motion: SensorMotion
    wrench: Array
    phi: Array

    @property
    def extents(self) -> Array:
        """(3,) [m] of the homogeneous box of this mass and inertia, in place of the tool's bounding box."""
        m, c = self.phi[0], self.phi[1:4] / self.phi[0]
        Ixx, _, Iyy, _, _, Izz = self.phi[4:]
        central = np.array([Ixx, Iyy, Izz]) - m * (c @ c - c**2)
        return np.sqrt(np.maximum(6.0 / m * (central.sum() - 2.0 * central), 1e-6))


def tool(name: str) -> Tool:
    table = pq.read_table(TOOLS / f"{name}.parquet").to_pydict()

    def columns(*names: str) -> Array:
        return np.stack([np.array(table[each]) for each in names], axis=1)

    R = columns(*(f"R{i}{j}" for i in "123" for j in "123")).reshape(-1, 3, 3)
    a, alpha, omega, f, n = (
        np.einsum("tji,tj->ti", R, columns(*(f"{each}{axis}" for axis in "xyz"))) for each in ("a", "al", "w", "f", "m")
    )
    motion = SensorMotion(np.array(table["t"]), R, a, alpha, omega, np.zeros((len(R), 9, 1)))
    told = json.loads((TOOLS / "truth.json").read_text())[name]["phi_of_the_generator"]
    order = ("m", "mcx", "mcy", "mcz", "Ixx", "Ixy", "Iyy", "Ixz", "Iyz", "Izz")
    return Tool(motion, np.concatenate([f, n], axis=1), np.array([told[each] for each in order]))


def identified(of: Tool, level: str, seed: int, method: Method) -> DynamicSolution:
    """The zero is known, as they know it; nothing else is."""
    size, rng = max(NOISE[level], 1e-7), np.random.default_rng(seed)
    std = size * np.repeat([FORCE, MOMENT], 3)
    root = size * np.diag(np.repeat([ACCELERATION, ANGULAR, 0.0], 3))
    T = len(of.wrench)
    error = rng.standard_normal((T, 9)) @ root
    motion = SensorMotion(
        of.motion.time, of.motion.rotation, of.motion.acceleration + error[:, :3], of.motion.alpha + error[:, 3:6],
        of.motion.omega, np.broadcast_to(root, (T, 9, 9)).copy(),
    )  # fmt: skip
    rows = dynamic_rows(motion, of.wrench + std * rng.standard_normal((T, 6)), GRAVITY, 1, std)
    nothing = static_prior(None, mass_scale=10.0)
    covariance = nothing.covariance.copy()
    covariance[10:, 10:] = np.diag((1e-3 * std) ** 2)
    return dynamic_stage(rows, Prior(nothing.value, covariance), method)


def errors(of: Tool, phi: Array) -> Array:
    """(3,) [%] of the mass; of the centre by the extents; of the inertia by that of the box, as they count them."""
    a, order = of.extents, [(0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2)]
    centre = np.abs(phi[1:4] / phi[0] - of.phi[1:4] / of.phi[0]) / a
    by = np.array([of.phi[0] / 12.0 * ((i == j) * float(a @ a) - a[i] * a[j]) for i, j in order])
    inertia = np.abs((phi[4:10] - of.phi[4:10]) / by)
    return 100.0 * np.array([abs(phi[0] / of.phi[0] - 1.0), centre.mean(), inertia.mean()])


def report(seeds: int = 20) -> None:
    rows = []
    for level in NOISE:
        for method, physical in (("ls", False), ("gtls", False), ("gtls", True)):
            found = [(of, identified(of, level, seed, method)) for of in map(tool, NAMES) for seed in range(seeds)]  # type: ignore[arg-type]
            mean = np.mean([errors(of, each.physical if physical else each.value[:10]) for of, each in found], axis=0)
            inside = np.mean([np.abs(each.value[:10] - of.phi) < 1.96 * each.std[:10] for of, each in found])
            name = f"{method}, possible" if physical else method
            rows.append([level, name, *(f"{each:.2g}" for each in mean), "" if physical else f"{100 * inside:.1f} %"])
    print(text_table(("noise", "", "m [%]", "centre [%]", "inertia [%]", "95 % hold"), rows))


if __name__ == "__main__":
    report()
