"""Robots of `example_robot_data` with a made log each: the same numbers for every way of identifying them."""

from __future__ import annotations

import sysconfig
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import final

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from exogauge.robots.motion import Motion
from exogauge.robots.parameters import BaseParameters, find_base_parameters
from exogauge.robots.row_blocks import RowBlocks
from exogauge.robots.tree import RigidTree
from exogauge.robots.urdf import load_tree

Array = NDArray[np.float64]

FOLDER = Path(sysconfig.get_path("purelib")) / "cmeel.prefix/share/example-robot-data/robots"
ROBOTS = {  # urdf, base link, floating, joints held at zero
    "Talos": ("talos_data/robots/talos_reduced.urdf", "base_link", True, ()),
    "Panda": (
        "panda_description/urdf/panda.urdf",
        "panda_link0",
        False,
        ("panda_finger_joint1", "panda_finger_joint2"),
    ),
    "UR5": ("ur_description/urdf/ur5_robot.urdf", "base_link", False, ()),
}
RATE_HZ = 200.0
NOISE = 0.5  # [N·m or N] on every measured force, so that the residual is not zero
STEP = 5000  # samples at once when forces are made


@final
@dataclass(frozen=True)
class Problem:
    """A robot and its log. forces: (T, 6+J) floating or (T, J), measured; columns of the base parameters in `base`."""

    name: str
    urdf: Path
    held: tuple[str, ...]
    tree: RigidTree
    model: pin.Model
    base: BaseParameters
    motion: Motion
    forces: Array

    @property
    def samples(self) -> int:
        return self.motion.samples

    @property
    def columns(self) -> NDArray[np.intp]:
        """(B,) columns of pinocchio's regressor that hold the base parameters; its bodies come in another order."""
        first = 6 if self.tree.floating else 0
        place = {joint.idx_v: index - 1 for index, joint in enumerate(self.model.joints) if index}
        body, kind = np.divmod(self.base.columns, 10)
        bodies = [place[first + dof if dof >= 0 else 0] for dof in self.tree.dof[body]]
        return 10 * np.array(bodies) + kind

    def first(self, samples: int) -> Problem:
        """The beginning of the same log."""
        part = slice(0, samples)
        return Problem(self.name, self.urdf, self.held, self.tree, self.model, self.base,
                       self.motion.rows(part), self.forces[part])  # fmt: skip

    def pinocchio(self) -> tuple[Array, Array, Array]:
        """q (T, nq), v (T, nv), a (T, nv) of the pinocchio model.

        A floating base stands at the origin and turns; gravity is in its proper acceleration.
        """
        motion = self.motion
        if not self.tree.floating:
            return motion.q, motion.dq, motion.ddq
        pose = np.tile([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0], (self.samples, 1))
        still = np.zeros((self.samples, 3))
        return (
            np.hstack([pose, motion.q]),
            np.hstack([still, motion.gyro, motion.dq]),
            np.hstack([motion.acc, motion.gyro_dot, motion.ddq]),
        )


def make(name: str, samples: int, seed: int = 0) -> Problem:
    """A robot of `ROBOTS` with a log of smooth random motions at 200 Hz."""
    file, base_link, floating, held = ROBOTS[name]
    urdf = FOLDER / file
    model = pin.buildModelFromUrdf(str(urdf), *([pin.JointModelFreeFlyer()] if floating else []))
    model = pin.buildReducedModel(model, [model.getJointId(joint) for joint in held], pin.neutral(model))
    model.armature[:] = 0.0
    if floating:
        model.gravity = pin.Motion.Zero()
    joints = [joint for joint in model.names if joint not in ("universe", "root_joint")]
    tree = load_tree(urdf.read_bytes(), joints=joints, base_link=base_link, floating=floating)
    base = find_base_parameters(tree)
    motion = smooth_motion(tree, np.arange(samples) / RATE_HZ, np.random.default_rng(seed))
    rng = np.random.default_rng(seed + 1)
    rows = RowBlocks(tree, base, np.eye(len(joints)))
    phi_base = base.regroup @ (tree.phi.ravel() * (1.0 + 0.1 * rng.normal(size=tree.phi.size)))
    forces = np.concatenate([_forces(rows, motion.rows(part), phi_base) for part in parts(samples, STEP)])
    forces += NOISE * rng.normal(size=forces.shape)
    return Problem(name, urdf, held, tree, model, base, motion, forces)


def _forces(rows: RowBlocks, motion: Motion, phi_base: Array) -> Array:
    """(T, rows) regressor times base parameters."""
    pairs = zip(rows.fill(motion), rows.columns, strict=True)
    return np.column_stack([block @ phi_base[own] for block, own in pairs])


def parts(samples: int, size: int) -> Iterator[slice]:
    """Consecutive slices."""
    for start in range(0, samples, size):
        yield slice(start, min(start + size, samples))


def smooth_motion(tree: RigidTree, time: Array, rng: np.random.Generator) -> Motion:
    """Sums of sines on every joint and, floating, on the base; time: (T,) [s]."""
    q, dq, ddq = _sines(rng, time, len(tree.joints), 0.35)
    up, still = np.tile([0.0, 0.0, 9.81], (len(time), 1)), np.zeros((len(time), 3))
    if not tree.floating:
        return Motion(q, dq, ddq, up, still, still)
    tilt, gyro, gyro_dot = _sines(rng, time, 3, 0.3)
    _, _, push = _sines(rng, time, 3, 0.1)
    return Motion(q, dq, ddq, up + push + 3.0 * tilt, gyro, gyro_dot)


def _sines(rng: np.random.Generator, time: Array, width: int, size: float) -> tuple[Array, Array, Array]:
    """(T, width) values, rates and accelerations: five sines between 0.1 and 2 Hz each."""
    total = [np.zeros((len(time), width)) for _ in range(3)]
    for _ in range(5):
        omega, phase = 2.0 * np.pi * rng.uniform(0.1, 2.0, width), rng.uniform(0.0, 2.0 * np.pi, width)
        amplitude = size * rng.uniform(0.3, 1.0, width) / np.maximum(omega / 4.0, 1.0)
        angle = time[:, None] * omega + phase
        total[0] += amplitude * np.sin(angle)
        total[1] += amplitude * omega * np.cos(angle)
        total[2] -= amplitude * omega**2 * np.sin(angle)
    return total[0], total[1], total[2]
