"""A payload of a table of postures, small enough to hand in again and again, and one that only plans."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

MASS, CENTRE, ZERO = 3.2, np.array([0.01, -0.02, 0.08]), np.array([1.0, -2.0, 3.0, 0.1, 0.2, -0.3])
GRAVITY = np.array([0.0, 0.0, -9.81])
NOISE = (0.05, 0.005)
ENTRIES = [f"r{i}{j}" for i in (1, 2, 3) for j in (1, 2, 3)]
WRENCH = ["fx", "fy", "fz", "mx", "my", "mz"]
YAML = f"""version: 1
name: Gripper
gravity: [0, 0, -9.81]
sensor:
  wrench: [fx, fy, fz, mx, my, mz]
  noise: {{force_n: {NOISE[0]}, moment_nm: {NOISE[1]}}}
pose:
  rotation: [{", ".join(ENTRIES)}]
  noise_rad: 1.0e-5
logs:
  - {{file: logs/poses.csv, role: postures, each_row: true}}
settings: {{inclination: ignore}}
"""


def table(count: int = 12, seed: int = 0) -> str:
    """Rows of R_base_sensor and of what the payload does to the sensor, with noise."""
    rng = np.random.default_rng(seed)
    rows = [",".join([*ENTRIES, *WRENCH])]
    for R in Rotation.random(count, random_state=rng).as_matrix():
        force = MASS * R.T @ GRAVITY
        wrench = np.concatenate([force, np.cross(CENTRE, force)]) + ZERO
        wrench += rng.standard_normal(6) * np.repeat(NOISE, 3)
        rows.append(",".join(f"{x:.9f}" for x in (*R.ravel(), *wrench)))
    return "\n".join(rows) + "\n"


def payload_files() -> dict[str, bytes]:
    """path -> content of a payload that is right in every way; tests break it."""
    return {"payload.yaml": YAML.encode(), "logs/poses.csv": table().encode()}
