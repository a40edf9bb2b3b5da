"""Captures of others planned for robots, exported, and judged by MuJoCo: `python -m tests.bench.retarget [NAME ...]`.

NAME is a part of `robot, capture`. Nothing but the exported samples at 200 Hz and 1 kHz is judged: MuJoCo's inverse
dynamics and its own collisions of the URDF's shapes. Recordings of ../shared/data; one process, its CPU seconds.
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before numpy is imported

import contextlib
import gzip
import io
import json
import shutil
import sys
import tempfile
import time
from collections.abc import Callable, Mapping
from importlib.metadata import distribution
from pathlib import Path
from typing import Any

import numpy as np
from tests.motion.by_mujoco import ByMuJoCo, Shapes, bare, felt, limits
from tests.motion.robots import STOCK, sample_folder

from exogauge.cli import main
from exogauge.criteria.motion_plan import USUAL
from exogauge.motion.plan.written import read_written
from exogauge.motion.robot_file import load_motion_robot
from exogauge.robots.moving.robot import MotionRobot
from exogauge.robots.moving.touching import Pairs
from exogauge.terminal import text_table

DATA = Path(__file__).parents[3] / "shared" / "data"
TALOS = f"{STOCK}/talos_data/robots/talos_reduced.urdf"
URDF = {
    "Talos": Path(str(distribution("example-robot-data").locate_file(TALOS))),
    "JVRC-1": DATA / "model_jvrc1" / "jvrc_description" / "urdf" / "jvrc1.urdf",
}
CMU = "cmu_mocap_bend_twist"
CAPTURES: Mapping[str, tuple[str, tuple[str, ...], float, float]] = {  # file, options, from, to [s]
    "bend (CMU 02_06)": (f"{CMU}/02_06.amc", ("--skeleton", f"{CMU}/02.asf"), 0.0, 16.4),
    "twist (CMU 13_29)": (f"{CMU}/13_29.amc", ("--skeleton", f"{CMU}/02.asf"), 4.0, 10.0),
    "toe touch (CMU 13_29)": (f"{CMU}/13_29.amc", ("--skeleton", f"{CMU}/02.asf"), 16.0, 22.4),
    "squat (CMU 13_29)": (f"{CMU}/13_29.amc", ("--skeleton", f"{CMU}/02.asf"), 31.8, 38.2),
    "squat.c3d": ("mocap_c3d/squat.c3d", (), 0.0, 9.0),
    "STS1": ("opencap_sts_trc_grf/STS1.trc", ("--static", "opencap_subject4/static1.trc"), 0.0, 9.0),
}
ASKED = (
    *(("sample", capture) for capture in CAPTURES), ("JVRC-1", "bend (CMU 02_06)"), ("Talos", "bend (CMU 02_06)"),
)  # fmt: skip


def report(*names: str) -> None:
    head = ("robot, capture", "CPU s", "a second of motion", "rate", "pressure inside, mm", "feet, mm, °",
            "beyond, rad", "speed", "torque, trunk and arms", "legs, evenly", "friction", "weight", "nearest, mm",
            "broken")  # fmt: skip
    for robot, capture in ASKED:
        if all(name in f"{robot}, {capture}" for name in names):
            with tempfile.TemporaryDirectory() as folder:
                rows, said = measured(Path(folder), robot, capture)
            print(
                "\n".join([text_table(head, rows), *(f"  {key}: {value}" for key, value in said.items())]), flush=True
            )


def measured(folder: Path, name: str, capture: str) -> tuple[list[list[str]], dict[str, Any]]:
    file, options, begin, end = CAPTURES[capture]
    given = [str(there(folder, each)) if "/" in each else each for each in (file, *options)]
    description = robot_of(folder, name)
    table = folder / "plan.csv"
    began = time.process_time()
    said = told("motion", "retarget", *given, "--robot", str(description), "--from", f"{begin:g}", "--to", f"{end:g}",
                "--no-what-would-do", "--despite", "--json", "--out", str(table))  # fmt: skip
    spent = time.process_time() - began
    robot = load_motion_robot(description, beside=True)
    urdf, assets = felt(folder)
    rows = list[list[str]]()
    for rate in ("200", "1000"):
        out = folder / f"at_{rate}.npz"
        told("motion", "export", str(table), "--robot", str(description), "--rate", rate, "--format", "mujoco",
             "--despite", "--out", str(out))  # fmt: skip
        with np.load(out) as samples:
            seen = ByMuJoCo.of_file(robot, samples, bare(urdf))
        first = [f"{name}, {capture}", f"{spent:.0f}", f"{spent / said['seconds']:.2f}"] if not rows else [""] * 3
        rows.append([*first, f"{rate} Hz", *judged(robot, seen, limits(urdf, robot.joints)), "", ""])
    rows[0][-1] = "; ".join(said["broken"]) if isinstance(said["broken"], list) else str(said["broken"])
    rows[0][-2] = f"{1e3 * nearest(robot, Shapes(robot, urdf, assets), read_written(robot, table).q):.1f}"
    shown = ("trunk", "nearest", "rounds", "seconds")
    return rows, {key: value for key, value in said.items() if key.startswith(shown)}


def judged(robot: MotionRobot, seen: ByMuJoCo, said: Mapping[str, np.ndarray]) -> list[str]:
    legs = np.concatenate([robot.leg(foot) for foot in (0, 1)]) - robot.base
    upper = np.setdiff1d(np.arange(len(robot.joints)), legs)
    strays, turns = np.linalg.norm(seen.feet - seen.feet[0], axis=2).max(), seen.turned.max()
    beyond = np.maximum(said["lower"] - seen.angle, seen.angle - said["upper"]).max()
    share: Callable[[np.ndarray, np.ndarray], str] = lambda x, most: f"{100 * (np.abs(x) / most).max():.1f} %"  # noqa: E731
    return [
        f"{1e3 * seen.inside.min():.1f}", f"{1e3 * strays:.4f}, {np.degrees(turns):.4f}", f"{max(beyond, 0.0):.1g}",
        share(seen.speed, said["velocity"]), share(seen.torque[:, upper], said["effort"][upper]),
        share(seen.evenly[:, legs], said["effort"][legs]), f"{seen.rubbed.max():.2f}",
        f"{seen.carried.min() / robot.weight:.2f}",
    ]  # fmt: skip


def nearest(robot: MotionRobot, shapes: Shapes, q: np.ndarray) -> float:
    """[m] of the pairs that are looked at, as MuJoCo's collision detection finds them below 50 mm."""
    pairs = {frozenset(pair) for pair in Pairs(robot, USUAL.clearance_m).names}
    found = [apart for pair, apart in shapes.nearest(0.05, q).items() if pair in pairs]
    return min(found, default=0.05)


def told(*command: str) -> dict[str, Any]:
    out = io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(io.StringIO()):
        main([*command])
    return dict(json.loads(out.getvalue())) if "--json" in command else {}


def there(folder: Path, name: str) -> Path:
    """A recording, unpacked."""
    packed = DATA / f"{name}.gz"
    path = folder / Path(name).name
    path.write_bytes(gzip.decompress(packed.read_bytes()) if packed.exists() else (DATA / name).read_bytes())
    return path


def robot_of(folder: Path, name: str) -> Path:
    if name == "sample":
        return sample_folder(folder)
    shutil.copy(URDF[name], folder / "robot.urdf")
    told("motion", "robot", str(folder / "robot.urdf"))
    return folder / "robot.yaml"


if __name__ == "__main__":
    report(*sys.argv[1:])
