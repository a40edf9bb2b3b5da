"""Lengths and Jacobians of bands on Talos against a loop over samples in pinocchio. Memory in a process of its own:
`python -m tests.bench.bands T`."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import final

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray
from tests.bench.memory import added
from tests.bench.problems import Problem, make, parts
from tests.bench.timing import in_turns, seconds_of

from exogauge.devices.device import Band, ViaPoint
from exogauge.devices.routing import Routing

Array = NDArray[np.float64]

ROOT = Path(__file__).parents[2]
CHUNK = 5000  # samples whose Jacobians are held at once
AGREEMENT = 1e-10  # [m, m/rad]


@final
@dataclass(frozen=True)
class BandSpeeds:
    """rate: samples per CPU second by way. difference: [m, m/rad] largest from pinocchio's, by way."""

    rate: dict[str, float]
    difference: dict[str, float]


def measure(samples: int, short: int, repeats: int) -> BandSpeeds:
    """short: samples for pinocchio. Ours walk through a log of one chunk until they have seen `samples`."""
    problem = make("Talos", CHUNK)
    q = problem.motion.q
    routing = Routing(problem.tree, suit())
    brief = q[:: max(1, CHUNK // short)][:short]
    rivals = {"pin loop": seconds_of(lambda: pinocchio_loop(problem, brief))}
    rivals["ours"] = seconds_of(lambda: walk(routing, q, samples))
    length, jacobian = pinocchio_loop(problem, brief)
    ours = routing.geometry(brief)
    pairs = ((ours.length, length), (ours.jacobian, jacobian[:, :, routing.columns]))
    difference = {"ours": max(float(np.abs(mine - theirs).max()) for mine, theirs in pairs)}
    seconds = in_turns(rivals, repeats)
    return BandSpeeds(
        {name: (len(brief) if name == "pin loop" else samples) / s for name, s in seconds.items()}, difference
    )


BACK = {  # the left one, [m]
    "torso_2_link": ((-0.05, 0.15, 0.45), (-0.12, 0.12, 0.3), (-0.13, 0.1, 0.1)),
    "base_link": ((-0.14, 0.09, 0.05), (-0.15, 0.1, -0.05)),
    "leg_{}_3_link": ((-0.11, 0.0, -0.05), (-0.1, 0.0, -0.15), (-0.09, 0.0, -0.25)),
}
WAIST = {
    "torso_2_link": ((0.12, 0.15, 0.3), (0.1, 0.18, 0.2), (0.0, 0.2, 0.15)),
    "torso_1_link": ((-0.08, 0.12, 0.05),),
    "base_link": ((-0.12, 0.02, 0.02), (-0.1, -0.1, -0.02), (0.0, -0.17, -0.04), (0.1, -0.14, -0.05)),
}


def suit() -> list[Band]:
    """Two bands from the shoulders over the back to the thighs, two about the waist, eight via points each."""
    return [
        Band(
            f"{name}_{side}",
            name,
            tuple(ViaPoint(link.format(side), (x, sign * y, z)) for link, at in way.items() for x, y, z in at),
        )
        for side, sign in (("left", 1.0), ("right", -1.0))
        for name, way in (("A", BACK), ("B", WAIST))
    ]


def walk(routing: Routing, q: Array, samples: int) -> None:
    """Geometry of `samples` samples, chunk by chunk, thrown away."""
    for part in parts(samples, len(q)):
        routing.geometry(q[: part.stop - part.start])


def pinocchio_loop(problem: Problem, q: Array) -> tuple[Array, Array]:
    """Lengths (T, W) and Jacobians (T, W, J), one sample at a time; each link's frame Jacobian is computed once."""
    model, bands = problem.model, suit()
    data, full = model.createData(), pin.neutral(model)
    links = sorted({via.link for band in bands for via in band.via_points})
    frames = [model.getFrameId(link) for link in links]
    of_link = [[links.index(via.link) for via in band.via_points] for band in bands]
    xyz = [np.array([via.xyz for via in band.via_points]) for band in bands]
    length = np.empty((len(q), len(bands)))
    jacobian = np.empty((len(q), len(bands), model.nv - 6))
    for t, row in enumerate(q):
        full[7:] = row
        pin.computeJointJacobians(model, data, full)
        pin.updateFramePlacements(model, data)
        J = np.array([pin.getFrameJacobian(model, data, f, pin.LOCAL_WORLD_ALIGNED)[:, 6:] for f in frames])
        R, o = (
            np.array(x) for x in zip(*((data.oMf[f].rotation, data.oMf[f].translation) for f in frames), strict=True)
        )
        for w, (where, x) in enumerate(zip(of_link, xyz, strict=True)):
            arm = np.einsum("pij,pj->pi", R[where], x)
            d = np.diff(o[where] + arm, axis=0)
            l = np.linalg.norm(d, axis=1)  # noqa: E741 (the paper's letter)
            e = d / l[:, None]
            force = np.zeros_like(arm)  # of a unit pull at each via point: l̇ = Σ force · ṗ
            force[1:] += e
            force[:-1] -= e
            wrench = np.hstack([force, np.cross(arm, force)])
            length[t, w] = l.sum()
            jacobian[t, w] = np.einsum("pv,pvj->j", wrench, J[where])
    return length, jacobian


def memory(samples: int) -> float:
    """[MB] that `samples` samples add at their peak, in a child that gives freed arrays back at once."""
    command = [sys.executable, "-m", "tests.bench.bands", str(samples)]
    environment = {**os.environ, "MALLOC_MMAP_THRESHOLD_": "32768"}
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=True)
    return float(done.stdout)


def main() -> None:
    problem = make("Talos", CHUNK)
    routing = Routing(problem.tree, suit())
    walk(routing, problem.motion.q, 10)  # imports, compilation
    print(added(lambda: walk(routing, problem.motion.q, int(sys.argv[1]))))


if __name__ == "__main__":
    main()
