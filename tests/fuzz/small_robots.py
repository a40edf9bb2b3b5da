"""Two small robots on files, moved by pinocchio's own inverse dynamics: an arm, and a body that stands on a plate."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import pinocchio as pin
import pyarrow as pa
import pyarrow.parquet as pq
from tests.identification.conftest import at_place, chain_urdf, euler, fourier, random_body

RATE = 100.0
JOINTS = ("j1", "j2", "j3")
K_T = np.array([5.0, 6.5, 4.5])  # [N·m/A] true; stated a tenth less
FRICTION = {"k_d": np.array([0.5, 0.8, 0.3]), "tau_c": np.array([0.6, 1.0, 0.4]), "J_r": np.array([0.1, 0.2, 0.08])}
NOISE = {"q": 2e-5, "i": 0.02, "acc": 0.02, "gyro": 0.002, "force": 0.3, "moment": 0.03}
LOGS = {"id_1": (1, 20.0, "identification"), "id_2": (2, 20.0, "identification"), "val_1": (3, 15.0, "validation")}
SOLE = b'<link name="sole"/><joint name="to_sole" type="fixed"><parent link="base"/><child link="sole"/></joint>'
Columns = Mapping[str, np.ndarray]


def robot_yaml(floating: bool) -> str:
    base = "base: floating\nbase_link: base\nimu: {parent: base, xyz: [0.03, -0.02, 0.05], rpy: [0.4, 0, 0]}\n"
    base += "ft_sensors:\n  - {name: plate, frame: sole, role: contact, sees: world_on_robot}\n"
    joints = "".join(
        f"  - {{name: {name}, actuation: current, gear_ratio: 80, prior: {{k_T: {0.9 * k_T:.4g}}}}}\n"
        for name, k_T in zip(JOINTS, K_T, strict=True)
    )
    return f"version: 1\nurdf: robot.urdf\n{base if floating else 'base: fixed' + chr(10)}joints:\n{joints}"


def study_yaml(settings: str = "", steps: str = "[identify]") -> str:
    logs = "".join(f"  - {{file: {name}.parquet, role: {role}}}\n" for name, (_, _, role) in LOGS.items())
    return f"version: 1\nname: small\nrobot: robot.yaml\nlogs:\n{logs}steps: {steps}\nsettings: {{{settings}}}\n"


def dahl(dq: np.ndarray, bends: float) -> np.ndarray:
    """(T, J) of Coulomb friction whose bristles bend by `bends` [rad] before they slide: dz = dq - |dq| z / bends."""
    finer, z, found = 50, np.zeros(dq.shape[1]), np.empty_like(dq)
    for k, speed in enumerate(dq):
        for _ in range(finer):
            z += (speed - np.abs(speed) * z / bends) / (RATE * finer)
        found[k] = z / bends
    return found


def simulate(
    floating: bool, seed: int, seconds: float, size: float = 1.5, bends: float = 0.0, sway: float = 0.6
) -> dict[str, np.ndarray]:
    """One log: joints that swing up to some rad/s, and on a floating base the body sways. bends: see `dahl`."""
    rng, J = np.random.default_rng(seed), len(JOINTS)
    t = np.arange(0.0, seconds, 1.0 / RATE)
    q, dq, ddq = (size * each for each in fourier(rng, t, J, 0.5))
    model = pin.buildModelFromXML(chain_urdf(J).decode(), *([pin.JointModelFreeFlyer()] if floating else []))
    truth, first = np.random.default_rng(0), model.njoints - J
    for body in range(first - int(floating), model.njoints):
        if body:
            near = model.inertias[body].toDynamicParameters()
            model.inertias[body] = pin.Inertia.FromDynamicParameters(random_body(truth, near, 0.1))
    data, tau, wrench = model.createData(), np.empty((len(t), J)), np.empty((len(t), 6))
    full = (q, dq, ddq)
    if floating:
        R, w, wd = euler(*(sway * each for each in fourier(rng, t, 3, 0.4)))
        R_imu, still = pin.utils.rotate("x", 0.4), np.zeros_like(w)
        acc = at_place(R, np.array([0.0, 0.0, 9.81]), w, wd, np.array([0.03, -0.02, 0.05])) @ R_imu
        gyro, turned = w @ R_imu, [pin.Quaternion(each).coeffs() for each in R]
        full = tuple(map(np.hstack, ((still, turned, q), (still, w, dq), (still, wd, ddq))))
    for k, moved in enumerate(zip(*full, strict=True)):
        forces = pin.rnea(model, data, *moved)
        tau[k], wrench[k] = forces[-J:], forces[:6] if floating else 0.0

    def noisy(values: np.ndarray, kind: str) -> np.ndarray:
        return values + NOISE[kind] * rng.standard_normal(values.shape)

    coulomb = dahl(dq, bends) if bends else np.sign(dq)
    friction = FRICTION["k_d"] * dq + FRICTION["tau_c"] * coulomb + FRICTION["J_r"] * ddq
    current = noisy((tau + friction) / K_T, "i")
    columns = {"t": t}
    columns |= {f"q.{name}": noisy(q[:, j], "q") for j, name in enumerate(JOINTS)}
    columns |= {f"i.{name}": current[:, j] for j, name in enumerate(JOINTS)}
    if floating:
        for i, axis in enumerate("xyz"):
            columns |= {f"acc.{axis}": noisy(acc[:, i], "acc"), f"gyro.{axis}": noisy(gyro[:, i], "gyro")}
            columns[f"ft.plate.f{axis}"] = noisy(wrench[:, i], "force")
            columns[f"ft.plate.m{axis}"] = noisy(wrench[:, 3 + i], "moment")
    return columns


def write_study(
    folder: Path, floating: bool, logs: Mapping[str, Columns], robot: str = "", settings: str = "",
    steps: str = "[identify]", urdf: Callable[[bytes], bytes] = lambda text: text,
) -> Path:  # fmt: skip
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "robot.urdf").write_bytes(urdf(chain_urdf(len(JOINTS)).replace(b"</robot>", SOLE + b"</robot>")))
    (folder / "robot.yaml").write_text(robot or robot_yaml(floating))
    (folder / "study.yaml").write_text(study_yaml(settings, steps))
    for name, columns in logs.items():
        pq.write_table(pa.table(dict(columns)), folder / f"{name}.parquet")
    return folder / "study.yaml"


def simulated_logs(floating: bool) -> dict[str, dict[str, np.ndarray]]:
    return {name: simulate(floating, seed, seconds) for name, (seed, seconds, _) in LOGS.items()}
