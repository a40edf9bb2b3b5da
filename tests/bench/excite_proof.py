"""What a motion that identifies promises, against what comes of it: recorded by MuJoCo on robots drawn about the stated
one, with sensors' noise, identified, and compared with the truth.

`python -m tests.bench.excite_proof [ROBOTS] [ARM …]`. Ratios are geometric means over base parameters of what the
random motion leaves over what the planned one does: promised, of standard deviations; found, of errors' root mean
squares over the robots. The random motion is the median one of `tests.bench.excite`. `again`: errors after the first
motion twice over those after the first and another one that was planned knowing its log.
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before numpy is imported

import sys
import tempfile
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import mujoco
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray
from tests.bench.excite import RANDOM, SECONDS, base_std, task
from tests.motion.robots import ARMS, arm_folder

from exogauge.criteria.motion_excite import USUAL
from exogauge.experiment.envelope import random_motion, within
from exogauge.identification.identify import identify
from exogauge.identification.prior import inertial_std
from exogauge.identification.settings import Recording, Settings
from exogauge.logs.model import Log
from exogauge.motion.excite.excited import Excited
from exogauge.motion.excite.known import information_of
from exogauge.motion.excite.plan import plan_excitation
from exogauge.motion.excite.promise import promised
from exogauge.motion.excite.search import best_motion
from exogauge.motion.excite.task import task_of
from exogauge.motion.robot_file import load_motion_robot
from exogauge.robots.consistency import is_physical
from exogauge.robots.description import Robot
from exogauge.studies.intake.robot_file import load_robot
from exogauge.terminal import text_table

Array = NDArray[np.float64]
RATE_HZ, ROBOTS, DRAWS = 200.0, 8, 10000
AS_NUMBERS: tuple[Settings, ...] = (  # the robots are drawn as the prior says
    Settings(prior_strength=1.0, consistency="free"), Settings(prior_strength=1.0),
)  # fmt: skip


def report(robots: int = ROBOTS, names: tuple[str, ...] = tuple(ARMS)) -> None:
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for name in names:
            for settings in AS_NUMBERS:
                rows.append(
                    [name, settings.consistency, *proved(arm_folder(Path(folder) / name, name), robots, settings)]
                )
                print(*rows[-1], flush=True)
    print(f"\n{robots} robots each, recorded by MuJoCo")
    heads = (
        "robot",
        "links",
        "promised",
        "found",
        "planned: error / std",
        "random: error / std",
        "again, mean ln",
        "median",
    )
    print(text_table(heads, rows))


def proved(path: Path, robots: int, settings: Settings) -> list[str]:
    robot = load_robot(path.parent, path.name)
    first = plan_excitation(path, SECONDS).planned
    other = Excited(first.task, usual_random(path))
    said = [doubt(robot, [each]) for each in (first, other)]
    rng = np.random.default_rng(5)
    missed: list[list[Array]] = [[], [], [], []]
    second: Excited | None = None
    for _ in range(robots):
        urdf = drawn(path, robot, rng)
        truth = base_of(path, urdf)
        logs = [recorded(urdf, robot, each, f"{k}", rng) for k, each in enumerate((first, other, first))]
        if second is None:
            found = identify(robot, [Recording(logs[0], False)], settings)
            moving = load_motion_robot(path)
            of = task_of(robot, moving, SECONDS, USUAL, information_of(found))
            second = Excited(of, best_motion(of, np.random.default_rng(1)))
        logs.append(recorded(urdf, robot, second, "3", rng))
        for which, used in enumerate(([0], [1], [0, 2], [0, 3])):
            fitted = identify(robot, [Recording(logs[k], False) for k in used], settings)
            told = [each.value for each in fitted.parameters if each.name.startswith("base[")]
            missed[which].append(np.array(told) - truth)
    planned, by_chance, repeated, knowing = (np.sqrt(np.mean(np.square(each), axis=0)) for each in missed)
    again = np.log(repeated / knowing)
    return [
        f"{np.exp(np.mean(np.log(said[1] / said[0]))):.2f}", f"{np.exp(np.mean(np.log(by_chance / planned))):.2f}",
        f"{np.median(planned / said[0]):.2f}", f"{np.median(by_chance / said[1]):.2f}",
        f"{again.mean():+.3f}", f"{np.median(again):+.3f}",
    ]  # fmt: skip


def usual_random(path: Path) -> Array:
    """The one that leaves the median doubt of those that leave less of the two kinds."""
    slower = replace(USUAL, top_hz=USUAL.top_hz / 2)
    of, slow = task(path, USUAL), task(path, slower)
    drawn = [within(of, random_motion(of, np.random.default_rng(100 + seed))) for seed in range(RANDOM)]
    doubts = [float(np.median(base_std(of, x))) for x in drawn]
    beside = [float(np.median(base_std(slow, within(slow, random_motion(slow, np.random.default_rng(100 + seed))))))
              for seed in range(RANDOM)]  # fmt: skip
    print(f"median doubt of random motions {np.median(doubts):.3g}, of half as fast ones {np.median(beside):.3g}")
    return drawn[int(np.argsort(doubts)[RANDOM // 2])]


def doubt(robot: Robot, planned: list[Excited]) -> Array:
    """(B,) promised."""
    return np.array([each.std for each in promised(robot, planned).certain if each.kind == "base"])


def drawn(path: Path, robot: Robot, rng: np.random.Generator) -> bytes:
    """All ten numbers of every moving link as far off as its prior says; what cannot be is drawn anew.

    A draw of mass, centre and size alone leaves what is zero in the URDF as it is: of UR10 half of the base parameters
    were then exactly as stated, and their errors smaller than any prior would have them.
    """
    root = ElementTree.fromstring((path.parent / "robot.urdf").read_bytes())
    for link in root.iter("link"):
        for each in [each for each in link if each.tag in ("visual", "collision", "inertial")]:
            link.remove(each)
    for joint in root.findall("joint"):
        if joint.get("name") not in robot.tree.joints:  # held at zero: what it carries belongs to the link before
            joint.set("type", "fixed")
    links = {link.get("name"): link for link in root.iter("link")}
    for name, phi, std in zip(robot.tree.bodies, robot.tree.phi, inertial_std(robot), strict=True):
        for _ in range(DRAWS):
            body = phi + std * rng.standard_normal(10)
            if is_physical(body):
                break
        else:
            raise ValueError(f"{name}: no body of {DRAWS} that were drawn can exist")
        own = pin.Inertia.FromDynamicParameters(body)
        inertial = ElementTree.SubElement(links[name], "inertial")
        ElementTree.SubElement(inertial, "mass", value=repr(float(own.mass)))
        ElementTree.SubElement(inertial, "origin", xyz=" ".join(repr(float(each)) for each in own.lever), rpy="0 0 0")
        turns = {f"i{'xyz'[a]}{'xyz'[b]}": repr(float(own.inertia[a, b])) for a in range(3) for b in range(a, 3)}
        ElementTree.SubElement(inertial, "inertia", turns)
    return ElementTree.tostring(root)


def base_of(path: Path, urdf: bytes) -> Array:
    """(B,) of the robot that is true."""
    folder = path.parent / "true"
    folder.mkdir(exist_ok=True)
    (folder / "robot.urdf").write_bytes(urdf)
    (folder / "robot.yaml").write_bytes(path.read_bytes())
    true = load_robot(folder, "robot.yaml")
    moving = replace(load_motion_robot(path), shapes=())
    base = task_of(load_robot(path.parent, path.name), moving, SECONDS).information.equations.base
    return np.asarray(base.regroup @ true.tree.phi.ravel())


def recorded(urdf: bytes, robot: Robot, planned: Excited, name: str, rng: np.random.Generator) -> Log:
    """By MuJoCo's inverse dynamics, with the noise that robot.yaml states."""
    as_it_is = b'<mujoco><compiler discardvisual="true" fusestatic="false" balanceinertia="false"/></mujoco></robot>'
    model = mujoco.MjSpec.from_string(urdf.replace(b"</robot>", as_it_is).decode()).compile()
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    model.dof_damping[:] = model.dof_frictionloss[:] = model.dof_armature[:] = 0.0
    data = mujoco.MjData(model)
    time = np.arange(int(planned.duration * RATE_HZ)) / RATE_HZ
    names = planned.task.stance.robot.joints
    at = np.array([model.joint(each).dofadr[0] for each in names])
    q, v, a = planned.at(time)
    torque = np.empty((len(time), len(at)))
    for t in range(len(time)):
        data.qpos[:] = data.qvel[:] = data.qacc[:] = 0.0
        data.qpos[at], data.qvel[at], data.qacc[at] = q[t], v[t], a[t]
        mujoco.mj_inverse(model, data)
        torque[t] = data.qfrc_inverse[at]
    channels = {}
    for k, joint in enumerate(names):
        if joint in {each.name for each in robot.joints}:
            channels[f"q.{joint}"] = q[:, k] + robot.noise["q"] * rng.standard_normal(len(time))
            channels[f"tau.{joint}"] = torque[:, k] + robot.noise["tau"] * rng.standard_normal(len(time))
    return Log(name, time, channels)


if __name__ == "__main__":
    report(int(sys.argv[1]) if sys.argv[1:] else ROBOTS, tuple(sys.argv[2:]) or tuple(ARMS))
