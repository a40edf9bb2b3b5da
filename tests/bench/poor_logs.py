"""Arms whose logs are poor: only fast or slow, at one speed, slowly one way, over a small part of the range, or of one
joint alone; something is hidden.

What they do is MuJoCo's inverse dynamics of a robot that is not quite as its maker says, with friction of our own and
with one thing more at one joint, in formulas that are none of the catalogue's.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, final

import mujoco
import numpy as np
import yaml
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from exogauge.logs.model import Log

Array = NDArray[np.float64]
RATE_HZ, NOISE, ENCODER = 200.0, 0.05, 1e-5  # [N·m], [rad]
JOINTS = ("j1", "j2", "j3")

STYLES = {  # speeds up and down [rad/s], ways to either side [rad], whether all joints move
    "fast": ((0.8, 1.8), (0.8, 1.8), (0.5, 0.9), True),
    "slow": ((0.05, 0.3), (0.05, 0.3), (0.1, 0.4), True),
    "even": ((0.6, 0.75), (0.6, 0.75), (0.4, 0.8), True),
    "narrow": ((0.1, 0.6), (0.1, 0.6), (0.08, 0.2), True),
    "one way": ((0.1, 0.4), (0.8, 1.8), (0.5, 0.9), True),
    "alone": ((0.2, 1.8), (0.2, 1.8), (0.3, 0.9), False),
}


@final
@dataclass(frozen=True)
class Moved:
    """t: (T,). q, v, a, load, drive: (T, J); drive with the friction that the model knows."""

    t: Array
    q: Array
    v: Array
    a: Array
    load: Array
    drive: Array


def _delayed(m: Moved, size: float) -> Array:
    return np.stack([np.interp(m.t - size, m.t, x) for x in m.drive.T], axis=1) - m.drive


HIDDEN: dict[str, tuple[Callable[[Moved, float], Array], float]] = {  # (T, J) on every joint, and size
    "stribeck": (lambda m, s: s * np.sign(m.v) / (1.0 + (m.v / 0.5) ** 2), 2.0),
    "nonlinear_viscous": (lambda m, s: s * np.sign(m.v) * np.abs(m.v) ** 2.4, 0.35),
    "asym_viscous": (lambda m, s: s * np.abs(m.v) ** 1.1, 0.3),
    "load_coulomb": (lambda m, s: s * np.abs(m.load) * (1.0 + 0.02 * np.abs(m.load)) * np.sign(m.v), 0.08),
    "joint_spring": (lambda m, s: s * np.maximum(m.q - 0.1, 0.0) ** 1.2, 2.5),
    "torque_ripple": (lambda m, s: s * np.sin(14.0 * m.q + 0.4), 0.4),
    "kt_saturation": (lambda m, s: s * np.sign(m.drive) * np.abs(m.drive / 10.0) ** 2.6, 0.5),
    "torque_delay": (_delayed, 0.02),
    "kt_gain": (lambda m, s: s * m.drive, 0.15),
    "link_mass": (lambda m, s: np.zeros_like(m.q), 0.3),  # it is in MuJoCo's model
    "presliding": (lambda m, s: -s * _since_turn(m.q, 0.03), 1.2),
}


def _since_turn(q: Array, way: float) -> Array:
    """(T, J) what friction still lacks after each turn, along the motion: e^(-way/d), signed."""
    out = np.zeros_like(q)
    for k in range(1, len(q)):
        step = np.abs(q[k] - q[k - 1]) / way
        out[k] = (out[k - 1] - np.sign(q[k] - q[k - 1])) * np.exp(-step) + np.sign(q[k] - q[k - 1])
    return np.sign(np.gradient(q, axis=0)) - out


@final
class PoorArm:
    """Three joints, drawn by `seed`. hides: a key of `HIDDEN`; joint: number of the one that has it, or that the link
    comes after. doubt: share by which the maker may be off in masses and centres, and is; None: more, and unsaid. It
    is that of torque constants too, where `currents` are logged of all joints but the first."""

    def __init__(
        self, seed: int, hides: str, joint: int, times: float = 1.0, doubt: float | None = None, currents: bool = False
    ) -> None:
        rng = np.random.default_rng(seed)
        self.hides, self.joint, self.times, self.doubt = hides, joint, times, doubt
        self.k_T = {JOINTS[1]: 5.0, JOINTS[2]: 3.0} if currents else {}
        axes = [("0 0 1", "0 1 0", "1 0 0"), ("0 0 1", "0 1 0", "0 1 0"), ("0 1 0", "0 0 1", "0 1 0")]
        self.axes = axes[seed % len(axes)]
        self.mass = np.array([4.0, 3.0, 2.0]) * rng.uniform(0.7, 1.4, 3)
        self.long = rng.uniform(0.22, 0.38, 3)
        self.wrong = rng.uniform(0.9, 1.15, (3, 2))  # true masses and centres over those that are stated
        if doubt is not None:
            self.wrong = 1.0 + doubt * rng.standard_normal((3, 2))
        if hides == "link_mass":
            self.wrong[joint, 0] *= 1.0 + HIDDEN[hides][1] * times
        self.k_d, self.tau_c = rng.uniform(0.3, 0.8, 3), rng.uniform(0.5, 1.2, 3)
        self.tau_o = rng.uniform(-0.3, 0.3, 3)
        spec = mujoco.MjSpec.from_string(self.urdf(true=True))
        self.model = spec.compile()
        self.model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
        self.model.dof_damping[:] = self.model.dof_frictionloss[:] = self.model.dof_armature[:] = 0.0

    def urdf(self, true: bool = False) -> str:
        links = ['<link name="base"><collision><geometry><cylinder radius="0.08" length="0.1"/></geometry></collision>'
                 '</link>']  # fmt: skip
        above = "base"
        for k, name in enumerate(JOINTS):
            m = self.mass[k] * (self.wrong[k, 0] if true else 1.0)
            at = np.array([0.04, -0.03, 0.45 * self.long[k]]) * (self.wrong[k, 1] if true else 1.0)
            xyz = " ".join(f"{x:.6f}" for x in at)
            links.append(
                f'<link name="l{name}"><inertial><origin xyz="{xyz}"/><mass value="{m:.6f}"/>'
                f'<inertia ixx="{0.02 * m}" ixy="0" ixz="0" iyy="{0.025 * m}" iyz="0" izz="{0.01 * m}"/></inertial>'
                f'<collision><origin xyz="0 0 {0.5 * self.long[k]}"/><geometry><cylinder radius="0.04" '
                f'length="{0.7 * self.long[k]}"/></geometry></collision></link>'
                f'<joint name="{name}" type="revolute"><parent link="{above}"/><child link="l{name}"/>'
                f'<origin xyz="0 0 {0.1 if k == 0 else self.long[k - 1]}"/><axis xyz="{self.axes[k]}"/>'
                '<limit lower="-2.4" upper="2.4" velocity="3" effort="60"/></joint>'
            )
            above = f"l{name}"
        head = "" if not true else (
            '<mujoco><compiler discardvisual="true" fusestatic="false" balanceinertia="false"/></mujoco>'
        )  # fmt: skip
        return f'<robot name="arm">{head}{"".join(links)}</robot>'

    def folder(self, made: Path) -> Path:
        """robot.yaml, as the maker states it."""
        made.mkdir(parents=True, exist_ok=True)
        (made / "robot.urdf").write_text(self.urdf())
        content: dict[str, Any] = {
            "version": 1, "name": "arm", "urdf": "robot.urdf", "base": "fixed",
            "joints": [{"name": name, "actuation": "torque"} for name in JOINTS],
            "noise": {"q": ENCODER, "tau": NOISE}, "uncertainty": "none",
            "home": dict.fromkeys(JOINTS, 0.3), "limits": {"acceleration": 20.0},
        }  # fmt: skip
        if self.doubt is not None:
            content["inertial_prior_std"] = {"default": self.doubt}
            content["joints"] = [self._joint(name, self.doubt) for name in JOINTS]
        (made / "robot.yaml").write_text(yaml.safe_dump(content))
        return made / "robot.yaml"

    def _joint(self, name: str, doubt: float) -> dict[str, Any]:
        if name not in self.k_T:
            return {"name": name, "actuation": "torque"}
        k = self.k_T[name]
        return {"name": name, "actuation": "current", "prior": {"k_T": k}, "prior_std": {"k_T": doubt * k}}

    def moved(self, q: Array, rate_hz: float) -> Moved:
        """q (T, J) as a table of `rate_hz` says, played at `RATE_HZ`."""
        path = CubicSpline(np.arange(len(q)) / rate_hz, q, bc_type="clamped")
        t = np.arange(int((len(q) - 1) / rate_hz * RATE_HZ) + 1) / RATE_HZ
        q, v, a = (path(t, k) for k in range(3))
        v[np.abs(v) < 1e-9] = 0.0
        data, load = mujoco.MjData(self.model), np.empty_like(q)
        for k in range(len(t)):
            data.qpos[:], data.qvel[:], data.qacc[:] = q[k], v[k], a[k]
            mujoco.mj_inverse(self.model, data)
            load[k] = data.qfrc_inverse
        drive = load + self.k_d * v + self.tau_c * np.sign(v) - self.tau_o
        return Moved(t, q, v, a, load, drive)

    def played(self, name: str, q: Array, rate_hz: float, seed: int) -> Log:
        rng, m = np.random.default_rng(seed), self.moved(q, rate_hz)
        torque, size = HIDDEN[self.hides]
        own = np.arange(len(JOINTS)) == self.joint
        tau = m.drive + own * torque(m, size * self.times) + NOISE * rng.standard_normal(m.q.shape)
        measured = m.q + ENCODER * rng.standard_normal(m.q.shape)
        channels = {f"q.{each}": measured[:, j] for j, each in enumerate(JOINTS)}
        for j, each in enumerate(JOINTS):
            channels["i." + each if each in self.k_T else "tau." + each] = tau[:, j] / self.k_T.get(each, 1.0)
        return Log(name, m.t, channels)

    def poor(self, name: str, style: str, seconds: float, seed: int) -> Log:
        """Every joint to and fro at steady speeds about .3 rad."""
        up, down, ways, every = STYLES[style]
        rng, n = np.random.default_rng(seed), round(seconds * RATE_HZ)
        window = np.hanning(43)[1:-1] / np.hanning(43)[1:-1].sum()
        paths = []
        for k in range(len(JOINTS)):
            speeds: list[float] = [0.0] * 60
            at, side = 0.0, float(rng.choice([-1.0, 1.0]))
            while len(speeds) < n - 60:
                v, end = rng.uniform(*(up if side > 0.0 else down)), side * rng.uniform(*ways)
                steps = max(1, round(abs(end - at) / v * RATE_HZ))
                speeds += [float(np.sign(end - at)) * v] * steps
                at, side = end, -side
            speeds = [*speeds[: n - 60], *[0.0] * 60]
            moves = every or k == self.joint
            paths.append(0.3 + moves * np.cumsum(np.convolve(speeds, window, mode="same")) / RATE_HZ)
        return self.played(name, np.array(paths).T, RATE_HZ, seed + 1000)
