"""A payload recording: a 60 kg-class arm on a base that is not level carries a component behind a wrist sensor."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import final

import mujoco
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import yaml
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from exogauge.synthetic.payload_hidden import Hidden, as_read, of, parse_hidden
from exogauge.synthetic.payload_springs import Hung, hang, slides
from exogauge.synthetic.random_streams import stream

Array = NDArray[np.float64]

RATE_HZ = 250.0
GRAVITY = 9.81
MASS = 40.173
TILT_DEG = (1.824, 2.326)
FORCE_NOISE, MOMENT_NOISE, ENCODER_NOISE = 0.5, 0.05, 2e-5
POSTURES, HOLD_S, MOVE_S, EXCITATION_S = 21, 1.0, 1.0, 10.0
JOINTS = tuple(f"a{k}" for k in range(1, 7))
# Parent to joint [m], axis, and where the next one sits: an arm with a wrist that turns about x, y, x.
OFFSETS = ((0, 0, 0.6), (0.35, 0, 0.215), (0, 0, 0.85), (0.2, 0, 0.145), (0.62, 0, 0), (0.17, 0, 0))
AXES = ((0, 0, 1), (0, 1, 0), (0, 1, 0), (1, 0, 0), (0, 1, 0), (1, 0, 0))
LINK_MASS = (120.0, 90.0, 60.0, 25.0, 12.0, 5.0)
FLANGE = (0.08, 0.0, 0.0)  # the sensor's origin in the last link; its z looks out of the flange
WORK = np.array([0.0, 0.35, 0.1, 0.0, np.pi / 2 - 0.45, 0.0])  # the flange looks down
WRIST_REACH = np.array([0.7, 0.75, 2.4])  # rad about WORK: the flange stays within 60° of down
WRIST_SPEED, WRIST_ACCELERATION = np.array([1.6, 1.6, 2.4]), np.array([6.0, 6.0, 9.0])
HOSE_END = np.array([1.6, 0.4, 1.2])  # m in the cell
PUSHES = ((3.0, 0.6, (0.0, 40.0, 0.0), (0.3, 0.0, 0.05)), (6.5, 0.4, (25.0, 0.0, 10.0), (0.0, -0.4, 0.05)))


@final
@dataclass(frozen=True)
class Body:
    """mass [kg]; centre (3,) [m] and inertia (3, 3) [kg·m²] about it, in the sensor's axes; zero (6,) of the sensor."""

    mass: float
    centre: Array
    inertia: Array
    zero: Array

    @property
    def about_sensor(self) -> Array:
        """(3, 3) inertia about the sensor's origin."""
        c = self.centre
        return np.asarray(self.inertia + self.mass * (c @ c * np.eye(3) - np.outer(c, c)))


def draw_body(rng: np.random.Generator) -> Body:
    """Mass, m c_z and moments near those of the paper's component, turned and shifted a little."""
    turn = Rotation.from_rotvec(0.1 * rng.standard_normal(3)).as_matrix()
    inertia = turn @ np.diag([3.24, 0.83, 4.0]) @ turn.T
    centre = np.array([*rng.uniform(-0.02, 0.02, 2), 0.905 / MASS])
    zero = np.concatenate([rng.uniform(-20.0, 20.0, 3), rng.uniform(-1.0, 1.0, 3)])
    return Body(MASS, centre, inertia, zero)


def simulate(
    body: Body, q: Array, dq: Array, ddq: Array, pushes: Array | None = None, hidden: Sequence[Hidden] = ()
) -> Array:
    """(T, 6) wrench of the payload on the sensor, without noise, zero included. q, dq, ddq: (T, 6). pushes: (T, 6)
    wrench on the payload about the sensor's origin, in its axes. hidden: what the payload does besides."""
    body, hung = parts(body, hidden)
    model, hose = _model(body, hung), of(hidden, "hose")
    if hung is not None:
        swung = slides(model, q, RATE_HZ)
        q, dq, ddq = (np.hstack(each) for each in zip((q, dq, ddq), swung, strict=True))
    data = mujoco.MjData(model)
    site, payload = model.site("ft").id, model.body("payload").id
    out = np.empty((len(q), 6))
    for k in range(len(q)):
        data.qpos[:], data.qvel[:], data.qacc[:] = q[k], dq[k], ddq[k]
        data.xfrc_applied[:] = 0.0
        if pushes is not None and pushes[k].any():
            mujoco.mj_kinematics(model, data)
            R = data.site_xmat[site].reshape(3, 3)
            mujoco.mj_comPos(model, data)
            arm = data.xipos[payload] - data.site_xpos[site]
            f = R @ pushes[k, :3]
            data.xfrc_applied[payload] = np.concatenate([f, R @ pushes[k, 3:] - np.cross(arm, f)])
        if hose is not None:
            mujoco.mj_kinematics(model, data)
            R = data.site_xmat[site].reshape(3, 3)
            mujoco.mj_comPos(model, data)
            hold = data.site_xpos[site] + R @ np.array(hose.values["point"])
            f = hose.values["stiffness"] * (HOSE_END - hold)
            data.xfrc_applied[payload] += np.concatenate([f, np.cross(hold - data.xipos[payload], f)])
        mujoco.mj_inverse(model, data)
        out[k] = data.sensordata
    return -out + body.zero  # MuJoCo says what the sensor does to the payload


def parts(body: Body, hidden: Sequence[Hidden]) -> tuple[Body, Hung | None]:
    """What is fixed behind the sensor, and what hangs there on springs."""
    spring, second = of(hidden, "spring"), of(hidden, "second_body")
    if spring is not None:
        k = float(spring.values["stiffness"])  # type: ignore[arg-type]
        damping = 2.0 * float(spring.values["damping_ratio"]) * np.sqrt(k * body.mass)  # type: ignore[arg-type]
        hung = Hung(body.mass, body.centre, body.inertia, k, float(damping), "xy")
        return replace(body, mass=1e-6, centre=np.zeros(3), inertia=1e-9 * np.eye(3)), hung
    if second is not None:
        m = float(second.values["mass"])  # type: ignore[arg-type]
        w = 2.0 * np.pi * float(second.values["frequency_hz"])  # type: ignore[arg-type]
        damping = 2.0 * float(second.values["damping_ratio"]) * m * w  # type: ignore[arg-type]
        point = np.array(second.values["point"])
        return body, Hung(m, point, 0.005 * m * np.eye(3), m * w**2, float(damping), "xyz")
    return body, None


def together(body: Body, hidden: Sequence[Hidden]) -> Body:
    """The body with what hangs on it, as if all were rigid."""
    second = of(hidden, "second_body")
    if second is None:
        return body
    fixed, hung = parts(body, hidden)
    assert hung is not None
    mass = fixed.mass + hung.mass
    centre = (fixed.mass * fixed.centre + hung.mass * hung.centre) / mass

    def about(m: float, c: Array, inertia: Array) -> Array:
        d = c - centre
        return np.asarray(inertia + m * (d @ d * np.eye(3) - np.outer(d, d)))

    inertia = about(fixed.mass, fixed.centre, fixed.inertia) + about(hung.mass, hung.centre, hung.inertia)
    return replace(body, mass=mass, centre=centre, inertia=inertia)


def postures_motion(rng: np.random.Generator) -> tuple[Array, Array, Array]:
    """(T, 6) angles, rates, accelerations: 21 holds of 1 s, moves between them that start and end at rest."""
    share = np.array([[x, y, z] for x in (-1.0, 0.0, 1.0) for y in (-1.0, 0.0, 1.0) for z in (-1.0, 1.0)])
    share = np.vstack([share, [[0.0, 0.0, 0.0], [0.5, -0.5, 0.3], [-0.5, 0.5, -0.3]]])[:POSTURES]
    stops = np.tile(WORK, (POSTURES, 1))
    stops[:, 3:] += WRIST_REACH * share * rng.uniform(0.85, 1.0, share.shape)
    u = np.arange(round(MOVE_S * RATE_HZ)) / (MOVE_S * RATE_HZ)
    blend = (10 * u**3 - 15 * u**4 + 6 * u**5, 30 * u**2 - 60 * u**3 + 30 * u**4, 60 * u - 180 * u**2 + 120 * u**3)
    parts: list[list[Array]] = [[], [], []]
    for k in range(POSTURES):
        for order in range(3):
            parts[order].append(np.tile(stops[k] if order == 0 else np.zeros(6), (round(HOLD_S * RATE_HZ), 1)))
            if k + 1 < POSTURES:
                step = np.outer(blend[order], stops[k + 1] - stops[k]) / MOVE_S**order
                parts[order].append(step + (stops[k] if order == 0 else 0.0))
    q, dq, ddq = (np.concatenate(each) for each in parts)
    return q, dq, ddq


def wrist_motion(rng: np.random.Generator, share: float = 1.0, harmonics: int = 5) -> tuple[Array, Array, Array]:
    """(T, 6) of 10 s: Fourier series of the wrist's joints, at rest at both ends, scaled to `share` of the limits."""
    t = np.arange(round(EXCITATION_S * RATE_HZ)) / RATE_HZ
    order = np.arange(1, harmonics + 1)
    w = 2 * np.pi / EXCITATION_S * order
    sine, cosine = np.sin(np.outer(t, w)), np.cos(np.outer(t, w))
    q, dq, ddq = np.tile(WORK, (len(t), 1)), np.zeros((len(t), 6)), np.zeros((len(t), 6))
    for k in range(3):
        a, b = rng.standard_normal(harmonics) * order, rng.standard_normal(harmonics) * order
        a -= a.mean()
        ends = np.stack([1.0 / w, w])
        b -= ends.T @ np.linalg.solve(ends @ ends.T, ends @ b)
        angle, rate, acceleration = (
            (sine / w) @ a - (cosine / w) @ b,
            cosine @ a + sine @ b,
            (cosine * w) @ b - (sine * w) @ a,
        )
        size = max(
            np.abs(angle).max() / WRIST_REACH[k],
            np.abs(rate).max() / (WRIST_SPEED[k] * share),
            np.abs(acceleration).max() / (WRIST_ACCELERATION[k] * share**2),
        )
        q[:, 3 + k] += angle / size
        dq[:, 3 + k], ddq[:, 3 + k] = rate / size, acceleration / size
    return q, dq, ddq


def measured(q: Array, wrench: Array, rng: np.random.Generator) -> tuple[Array, Array]:
    """Angles (T, 6) and wrench (T, 6) with white noise of encoders and sensor."""
    noise = np.array([FORCE_NOISE] * 3 + [MOMENT_NOISE] * 3)
    return (
        q + ENCODER_NOISE * rng.standard_normal(q.shape),
        wrench + noise * rng.standard_normal(wrench.shape),
    )  # fmt: skip


def write_payload(out: Path, seed: int, specs: Sequence[str] | None = None) -> None:
    """payload.yaml, arm.urdf, five logs, README.txt, and truth.json for scoring only. specs: what is hidden."""
    body, hidden = draw_body(stream(seed, "payload")), parse_hidden(specs or (), stream(seed, "hidden in payload"))
    (out / "logs").mkdir(parents=True, exist_ok=True)
    motions = {
        "postures": postures_motion(stream(seed, "postures")),
        "excitation": wrist_motion(stream(seed, "excitation")),
        "fast": wrist_motion(stream(seed, "fast")),
        "slow": wrist_motion(stream(seed, "slow"), share=0.3, harmonics=3),
        "contact": wrist_motion(stream(seed, "contact"), share=0.3, harmonics=3),
    }
    for name, (q, dq, ddq) in motions.items():
        pushes = pushed(len(q)) if name == "contact" else None
        time = np.arange(len(q)) / RATE_HZ
        read = as_read(simulate(body, q, dq, ddq, pushes, hidden), time, name, hidden)
        angles, wrench = measured(q, read, stream(seed, f"noise of {name}"))
        columns = {"t": time} | {f"q.{joint}": angles[:, k] for k, joint in enumerate(JOINTS)}
        columns |= {axis: wrench[:, k] for k, axis in enumerate(("fx", "fy", "fz", "mx", "my", "mz"))}
        label = {"exogauge": "SYNTHETIC: simulated with MuJoCo, measured on no robot", "seed": str(seed)}
        table = pa.table({key: pa.array(values) for key, values in columns.items()}).replace_schema_metadata(label)
        pq.write_table(table, out / "logs" / f"{name}.parquet", compression="zstd")
    (out / "arm.urdf").write_text(arm_urdf(), encoding="utf-8")
    (out / "truth.json").write_text(
        json.dumps(truth(together(body, hidden), hidden), indent=1) + "\n", encoding="utf-8"
    )
    (out / "README.txt").write_text(
        "SYNTHETIC DATA. Nothing in this folder was measured on a robot.\n\n"
        f"Made by `exogauge sample --payload --seed {seed}` with MuJoCo: an arm of the 60 kg class, {MASS} kg behind\n"
        "its wrist sensor, on a base that is not level. truth.json is for scoring only.\n",
        encoding="utf-8",
    )
    (out / "payload.yaml").write_text(
        "# SYNTHETIC: written by `exogauge sample --payload`, measured on no robot\n"
        + yaml.safe_dump(
            payload_file(seed, together(body, hidden).mass), sort_keys=False, width=120, default_flow_style=None
        ),
        encoding="utf-8",
    )  # last: a folder with it is whole


def pushed(samples: int) -> Array:
    """(T, 6) wrench on the payload about the sensor's origin, in its axes: two half sines."""
    t, out = np.arange(samples) / RATE_HZ, np.zeros((samples, 6))
    for start, length, force, point in PUSHES:
        shape = np.where((t >= start) & (t < start + length), np.sin(np.pi * (t - start) / length), 0.0)
        out += shape[:, None] * np.concatenate([force, np.cross(point, force)])
    return out


def truth(body: Body, hidden: Sequence[Hidden] = ()) -> dict[str, object]:
    return {
        "synthetic": True,
        "mass": body.mass,
        "first_moment": (body.mass * body.centre).tolist(),
        "inertia_about_sensor": body.about_sensor.tolist(),
        "zero": body.zero.tolist(),
        "tilt_deg": list(TILT_DEG),
        "hidden": [{"effect": each.effect, "place": each.place, **each.values} for each in hidden],
        "pushes": [{"start": a, "length": b, "force": c, "point": d} for a, b, c, d in PUSHES],
    }


def payload_file(seed: int, mass: float = MASS) -> dict[str, object]:
    """payload.yaml as a tree of plain values."""
    roles = {"postures": "postures", "excitation": "excitation", "fast": "test", "slow": "test", "contact": "contact"}
    return {
        "version": 1,
        "name": f"SYNTHETIC component on a 60 kg arm, seed {seed}",
        "gravity": [0.0, 0.0, -GRAVITY],
        "sensor": {
            "frame": "ft",
            "sees": "payload_on_sensor",
            "wrench": ["fx", "fy", "fz", "mx", "my", "mz"],
            "noise": {"force_n": FORCE_NOISE, "moment_nm": MOMENT_NOISE},
            "range": {"force_n": [2500.0, 2500.0, 6250.0], "moment_nm": [400.0, 400.0, 400.0]},
        },
        "pose": {
            "urdf": "arm.urdf",
            "base_link": "base",
            "joints": {joint: f"q.{joint}" for joint in JOINTS},
            "noise_rad": ENCODER_NOISE,
        },
        "logs": [{"file": f"logs/{name}.parquet", "role": role} for name, role in roles.items()],
        "uncertainty": "none",  # simulated: the sensor is what it is said to be
        "ground_truth": {"mass_kg": mass},
    }


def arm_urdf() -> str:
    """Links with plain masses; the sensor's frame is a link without any."""
    lines = ['<robot name="arm60">', '  <link name="base"/>']
    for k, (joint, offset, axis, mass) in enumerate(zip(JOINTS, OFFSETS, AXES, LINK_MASS, strict=True), 1):
        i = 0.05 * mass
        lines += [
            f'  <link name="link{k}"><inertial><mass value="{mass}"/>'
            f'<inertia ixx="{i}" iyy="{i}" izz="{i}" ixy="0" ixz="0" iyz="0"/></inertial></link>',
            f'  <joint name="{joint}" type="revolute"><parent link="{"base" if k == 1 else f"link{k - 1}"}"/>'
            f'<child link="link{k}"/><origin xyz="{_text(offset)}" rpy="0 0 0"/><axis xyz="{_text(axis)}"/>'
            '<limit lower="-6.1" upper="6.1" velocity="3" effort="3000"/></joint>',
        ]
    lines += [
        '  <link name="ft"/>',
        f'  <joint name="ft_fixed" type="fixed"><parent link="link6"/><child link="ft"/>'
        f'<origin xyz="{_text(FLANGE)}" rpy="0 {np.pi / 2} 0"/></joint>',
        "</robot>",
    ]
    return "\n".join(lines) + "\n"


def _model(body: Body, hung: Hung | None = None) -> mujoco.MjModel:
    spec = mujoco.MjSpec()
    U, V = np.radians(TILT_DEG)
    spec.option.gravity = GRAVITY * np.array([np.cos(U) * np.sin(V), -np.sin(U), -np.cos(U) * np.cos(V)])
    parent = spec.worldbody
    for name, offset, axis, mass in zip(JOINTS, OFFSETS, AXES, LINK_MASS, strict=True):
        parent = parent.add_body(name=f"body of {name}", pos=offset, mass=mass, inertia=[0.05 * mass] * 3)
        parent.explicitinertial = True
        parent.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_HINGE, axis=axis)
    half = np.sqrt(0.5)
    payload = parent.add_body(name="payload", pos=FLANGE, quat=[half, 0.0, half, 0.0], mass=body.mass)
    i = body.inertia
    payload.ipos = body.centre
    payload.fullinertia = [i[0, 0], i[1, 1], i[2, 2], i[0, 1], i[0, 2], i[1, 2]]
    payload.explicitinertial = True
    payload.add_site(name="ft")
    if hung is not None:
        hang(payload, hung)
    for kind in (mujoco.mjtSensor.mjSENS_FORCE, mujoco.mjtSensor.mjSENS_TORQUE):
        spec.add_sensor(type=kind, objtype=mujoco.mjtObj.mjOBJ_SITE, objname="ft")
    return spec.compile()


def _text(values: object) -> str:
    return " ".join(f"{float(value):.12g}" for value in values)  # type: ignore[attr-defined]
