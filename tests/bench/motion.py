"""CPU time and memory of a planned motion, in a process of its own: `python -m tests.bench.motion SECONDS`.

The sample robot bends, twists and swings its arms on both feet, every bound in; then what was planned is judged.
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before numpy is imported

import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import pinocchio as pin
import yaml

from exogauge.motion.person import Person
from exogauge.motion.plan.judge import judge
from exogauge.motion.plan.retarget import ask
from exogauge.motion.plan.solve import plan
from exogauge.motion.robot_file import load_motion_robot
from exogauge.robots.moving.segments import Segment
from exogauge.synthetic.urdf import robot_file, robot_urdf

ROOT = Path(__file__).parents[2]
LENGTHS = (15.0, 60.0)  # [s]


def report() -> None:
    print("\nA motion planned for the sample robot, 34 joints, every bound: CPU seconds per second of motion")
    for seconds in LENGTHS:
        command = [sys.executable, "-m", "tests.bench.motion", str(seconds)]
        print("  " + subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout.strip())


def person(seconds: float) -> Person:
    t = np.arange(0.0, seconds, 0.01)
    bend, twist, swing = 0.8 * np.sin(0.5 * t) ** 2, 0.5 * np.sin(0.7 * t), np.sin(1.1 * t)
    trunk = np.stack([pin.rpy.rotate("z", a) @ pin.rpy.rotate("y", b) for a, b in zip(twist, bend, strict=True)])
    turn = np.stack([pin.rpy.rotate("y", 0.3 * b) for b in bend])
    down = np.stack([np.sin(0.8 * swing), 0.0 * t, -np.cos(0.8 * swing)], axis=1)
    parts: tuple[Segment, ...] = ("l_upper_arm", "r_upper_arm", "l_forearm", "r_forearm")
    return Person("bench", t, np.zeros((len(t), 3)), turn, trunk, dict.fromkeys(parts, down), 0.8)


def measured(seconds: float) -> str:
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "robot.urdf").write_text(robot_urdf())
        (Path(folder) / "robot.yaml").write_text(yaml.safe_dump(dict(robot_file())))
        robot = load_motion_robot(Path(folder) / "robot.yaml")
    began = time.process_time()
    asked, _ = ask(robot, person(seconds))
    planned = plan(robot, asked)
    middle = time.process_time()
    judged = judge(robot, planned.spline, asked.place[0], planned=planned)
    ended = time.process_time()
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3
    long = planned.spline.duration
    spent = f"planned in {(middle - began) / long:.2f}, judged at 200 Hz in {(ended - middle) / long:.3f}"
    return f"{long:5.0f} s: {spent}; {most:.0f} MB; {len(judged.broken)} bounds broken"


if __name__ == "__main__":
    print(measured(float(sys.argv[1])))
