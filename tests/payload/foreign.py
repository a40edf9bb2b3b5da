"""A wrist sensor recorded elsewhere: an arm moved and weighed by Newton and Euler in plain NumPy, at 125 Hz.

Columns have other names. It shares no code with what is tested, nor with the generator of the sample.

A chain of five joints whose axes turn x, y, z in turn. What a laboratory does to the logs is asked for by name.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

Array = NDArray[np.float64]
Spoil = Callable[[str, Array], Array]
"""(log, table of time, five angles, six of the wrench) -> the table that is written."""

RATE, PERIOD = 125.0, 0.008
AXES = np.eye(3)[[2, 1, 0, 1, 2]]
OFFSETS = np.array([[0, 0, 0.2], [0, 0.05, 0.15], [0.4, 0, 0], [0.35, 0, 0.03], [0.1, 0, 0.0]])
FLANGE = np.array([0.06, 0.0, 0.0])
HOME = np.array([0.2, -0.4, 0.3, 0.9, 0.1])
FORCE_NOISE, MOMENT_NOISE, ANGLE_NOISE = 0.15, 0.01, 2e-5
ROTATION, ACCELERATION = tuple(f"R{k}" for k in range(9)), ("A1", "A2", "A3")
COLUMNS = ("stamp", *(f"act_{k}" for k in range(5)), *(f"FT_{each}" for each in ("X", "Y", "Z", "A", "B", "C")))


@dataclass(frozen=True)
class Imu:
    """An accelerometer beside the sensor; rotations in place of joint angles. place: (3,) [m] in the sensor's axes;
    gain: (3,) of its axes; late: [s]; noise: [m/s²]."""

    place: Array
    gain: Array
    late: float = 0.0
    noise: float = 0.02

    def columns(self, seed: int, R: Array, w: Array, al: Array, acc: Array, g: Array) -> Array:
        """(T, 12) nine entries of rotations, three of accelerations; all in {B} but place."""
        turn = np.linalg.qr(np.random.default_rng(seed).standard_normal((3, 3)))[0]
        turn *= np.sign(np.linalg.det(turn))
        rng, r = np.random.default_rng([seed, len(R)]), R @ self.place
        proper = np.einsum("tji,tj->ti", R, acc + _cross(al, r) + _cross(w, _cross(w, r)) - g) @ turn * self.gain
        time = PERIOD * np.arange(len(R))
        read = CubicSpline(time, proper)(np.maximum(time - self.late, 0.0)) + 0.05
        slips = np.swapaxes(np.cross(ANGLE_NOISE * rng.standard_normal((len(R), 1, 3)), np.eye(3)), 1, 2)
        entries = (R + R @ slips).reshape(-1, 9)
        return np.column_stack([entries, read + self.noise * rng.standard_normal(read.shape)])


@dataclass(frozen=True)
class Truth:
    """phi: (10,) [m, m c, Ixx, Ixy, Iyy, Ixz, Iyz, Izz] about the sensor's origin; zero: (6,)."""

    phi: Array
    zero: Array

    @property
    def x(self) -> Array:
        return np.concatenate([self.phi, self.zero])


def urdf() -> str:
    joints = [
        f'<joint name="turn{k}" type="revolute"><parent link="part{k}"/><child link="part{k + 1}"/>'
        f'<origin xyz="{o[0]} {o[1]} {o[2]}"/><axis xyz="{a[0]} {a[1]} {a[2]}"/>'
        '<limit lower="-6" upper="6" velocity="4" effort="100"/></joint>'
        for k, (o, a) in enumerate(zip(OFFSETS, AXES, strict=True))
    ]
    end = (
        '<joint name="bolts" type="fixed"><parent link="part5"/><child link="hand"/>'
        f'<origin xyz="{FLANGE[0]} {FLANGE[1]} {FLANGE[2]}"/></joint>'
    )
    links = "".join(f'<link name="part{k}"/>' for k in range(6)) + '<link name="hand"/>'
    return f'<robot name="elsewhere">{links}{"".join(joints)}{end}</robot>'


def _cross(a: Array, b: Array) -> Array:
    return np.cross(a, b)


def sensor(q: Array, v: Array, a: Array) -> tuple[Array, Array, Array, Array]:
    """R_BS (T, 3, 3), ω, α and the acceleration of the sensor's origin (T, 3), in {B}."""
    T = len(q)
    R, w, al, acc = np.tile(np.eye(3), (T, 1, 1)), np.zeros((T, 3)), np.zeros((T, 3)), np.zeros((T, 3))
    for k in range(5):
        r = R @ OFFSETS[k]
        acc = acc + _cross(al, r) + _cross(w, _cross(w, r))
        z = R @ AXES[k]
        al = al + z * a[:, [k]] + _cross(w, z * v[:, [k]])
        w = w + z * v[:, [k]]
        i, j = {0: (1, 2), 1: (2, 0), 2: (0, 1)}[int(np.argmax(AXES[k]))]
        c, s = np.cos(q[:, k]), np.sin(q[:, k])
        turn = np.tile(np.eye(3), (T, 1, 1))
        turn[:, i, i], turn[:, j, j], turn[:, i, j], turn[:, j, i] = c, c, -s, s
        R = R @ turn
    r = R @ FLANGE
    return R, w, al, acc + _cross(al, r) + _cross(w, _cross(w, r))


def waves(rng: np.random.Generator, t: Array, size: float) -> tuple[Array, Array, Array]:
    """(T, 5) angles, rates and accelerations: five waves for each joint."""
    w = 2 * np.pi * 0.12 * np.arange(1, 6)
    amplitude = size * rng.standard_normal((5, 5)) / np.arange(1, 6)
    arg = np.multiply.outer(t, w)[:, None] + rng.uniform(0, 2 * np.pi, (5, 5))
    waved = (np.sum(amplitude * f, axis=2) for f in (np.sin(arg), w * np.cos(arg), -(w**2) * np.sin(arg)))
    q, v, a = waved
    return HOME + q, v, a


def stops(rng: np.random.Generator, count: int) -> tuple[Array, Array, Array]:
    """Holds of 1.2 s with moves of 1.2 s between them."""
    places = HOME + rng.uniform(-1.2, 1.2, (count, 5))
    n = round(1.2 * RATE)
    u = np.arange(n)[:, None] / n
    shape = (u**3 * (10 - 15 * u + 6 * u**2), 30 * u**2 * (1 - u) ** 2 / 1.2, (60 * u - 180 * u**2 + 120 * u**3) / 1.44)
    parts: list[list[Array]] = [[], [], []]
    for k, place in enumerate(places):
        step = places[min(k + 1, count - 1)] - place
        for order in range(3):
            parts[order] += [
                np.tile(place if order == 0 else 0 * place, (n, 1)),
                shape[order] * step + (order == 0) * place,
            ]
    q, v, a = (np.concatenate(each[: 2 * count - 1]) for each in parts)
    return q, v, a


def write(
    out: Path, seed: int, *, spoil: Spoil | None = None, colour: float = 0.0, postures: int = 14, seconds: float = 16.0,
    size: float = 0.4, sees: str | None = "payload_on_sensor", tests: bool = True,
    shaken: tuple[int, ...] = (0, 1, 2, 3, 4), noise: float = 1.0, imu: Imu | None = None, mass: float | None = None,
    more: tuple[str, ...] = (),
) -> Truth:  # fmt: skip
    """payload.yaml, arm.urdf, still.csv, shake.csv and other.csv. colour: what one sample of the wrench's noise hands
    on to the next. shaken: joints that move in shake.csv. noise: of what is stated, the share that the wrench has.
    more: lines of payload.yaml."""
    rng = np.random.default_rng(seed)
    drawn = rng.uniform(1.5, 4.0)
    m, c = mass or drawn, np.array([*rng.uniform(-0.05, 0.05, 2), rng.uniform(0.05, 0.15)])
    root = rng.uniform(0.03, 0.12, 3)
    turn = np.linalg.qr(rng.standard_normal((3, 3)))[0]
    about_c = turn @ np.diag(m * np.array([root[1] + root[2], root[2] + root[0], root[0] + root[1]]) * 0.1) @ turn.T
    about = about_c + m * (c @ c * np.eye(3) - np.outer(c, c))
    zero = np.concatenate([rng.uniform(-10, 10, 3), rng.uniform(-0.5, 0.5, 3)])
    tilt, way = np.radians(1.0), rng.uniform(0, 2 * np.pi)
    g = 9.81 * np.array([np.sin(tilt) * np.cos(way), np.sin(tilt) * np.sin(way), -np.cos(tilt)])
    motions = {"still": stops(rng, postures)}
    for name, long in (("shake", seconds), ("other", 10.0)):
        motions[name] = waves(rng, np.arange(round(long * RATE)) * PERIOD, size)
    q, v, a = motions["shake"]
    moves = np.isin(np.arange(5), shaken)
    motions["shake"] = (np.where(moves, q, HOME), v * moves, a * moves)
    for name, (q, v, a) in motions.items():
        R, w, al, acc = sensor(q, v, a)
        arm = R @ c
        f = m * (acc + _cross(al, arm) + _cross(w, _cross(w, arm)) - g)
        I = R @ about_c @ R.transpose(0, 2, 1)  # noqa: E741
        spin = np.einsum("tij,tj->ti", I, w)
        n = np.einsum("tij,tj->ti", I, al) + _cross(w, spin) + _cross(arm, f)
        read = -np.concatenate([np.einsum("tji,tj->ti", R, each) for each in (f, n)], axis=1) + zero
        white = rng.standard_normal((len(q), 6))
        for k in range(1, len(white)):
            white[k] = colour * white[k - 1] + np.sqrt(1.0 - colour**2) * white[k]
        read = read + noise * white * np.repeat([FORCE_NOISE, MOMENT_NOISE], 3)
        angles = q + ANGLE_NOISE * rng.standard_normal(q.shape)
        table = np.column_stack([3.0 + PERIOD * np.arange(len(q)), angles, read])
        table = table if spoil is None else spoil(name, table)
        columns = COLUMNS
        if imu is not None:
            columns = (COLUMNS[0], *ROTATION, *ACCELERATION, *COLUMNS[6:])
            table = np.column_stack([table[:, :1], imu.columns(seed, R, w, al, acc, g), table[:, 6:]])
        np.savetxt(out / f"{name}.csv", table, fmt="%.7f", delimiter=",", header=",".join(columns), comments="")
    (out / "arm.urdf").write_text(urdf(), encoding="utf-8")
    roles = {"still": "postures", "shake": "excitation"} | ({"other": "test"} if tests else {})
    lines = [
        "version: 1", "name: recorded elsewhere", "gravity: [0, 0, -9.81]", *more, "sensor:",
        *(["  frame: hand"] if imu is None else []),
        *([f"  sees: {sees}"] if sees else []), f"  wrench: [{', '.join(COLUMNS[6:])}]",
        f"  noise: {{force_n: {FORCE_NOISE}, moment_nm: {MOMENT_NOISE}}}",
        f"pose: {{noise_rad: {ANGLE_NOISE:f}, " + ("urdf: arm.urdf, base_link: part0, joints: {"
        + ", ".join(f"turn{k}: act_{k}" for k in range(5)) + "}}" if imu is None
        else f"rotation: [{', '.join(ROTATION)}]}}\nimu: {{acceleration: [{', '.join(ACCELERATION)}]}}"),
        "time: {column: stamp}", "logs:", *(f"  - {{file: {name}.csv, role: {role}}}" for name, role in roles.items()),
    ]  # fmt: skip
    (out / "payload.yaml").write_text("\n".join(lines) + "\n", encoding="utf-8")
    inertia = about[[0, 0, 1, 0, 1, 2], [0, 1, 1, 2, 2, 2]]
    return Truth(np.concatenate([[m], m * c, inertia]), zero)


def stamps_jitter(seed: int, by: float = 2e-4) -> Spoil:
    """Samples are taken evenly, stamps are off by so many seconds."""
    rng = np.random.default_rng(seed)

    def spoil(_name: str, table: Array) -> Array:
        off = np.clip(by * rng.standard_normal(len(table)), -0.45 * PERIOD, 0.45 * PERIOD)
        return np.column_stack([table[:, 0] + off, table[:, 1:]])

    return spoil


def low_passed(seconds: float) -> Spoil:
    """A sensor with one pole: what it reads of what hardly changes is late by so much."""
    pole = seconds / (seconds + PERIOD)

    def change(read: Array) -> Array:
        out = read.copy()
        for k in range(1, len(out)):
            out[k] = pole * out[k - 1] + (1.0 - pole) * read[k]
        return out

    return wrench(change)


def wrench(change: Callable[[Array], Array]) -> Spoil:
    """(T, 6) as read -> what is logged instead."""
    return lambda _name, table: np.column_stack([table[:, :6], change(table[:, 6:])])
