"""What will be known once a planned motion was recorded: its log is made as the robot that is stated would have made
it, with its sensors' noise, and identified as any other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal, final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.motion_excite import MotionExcite
from exogauge.experiment.felt import borne_by_feet, felt_channels
from exogauge.identification.identify import identify
from exogauge.identification.noise_bias import noise_kind
from exogauge.identification.prior import joint_prior
from exogauge.identification.result import Identification
from exogauge.identification.settings import Recording, Settings
from exogauge.logs.model import Log
from exogauge.motion.excite.excited import Excited
from exogauge.progress import Progress, unwatched
from exogauge.robots.description import Robot

Array = NDArray[np.float64]

NAME = "planned"
AS_STATED = Settings(prior_strength=1.0)  # of a robot that is as it is stated, held-out data would have it weigh more


Kind = Literal["base", "joint", "link", "added"]
COUNTED: tuple[Kind, ...] = ("base", "joint")


@final
@dataclass(frozen=True)
class Certain:
    """One parameter: its standard deviation before a motion was recorded, and then. decided: by the data.

    kind: a base parameter, a coefficient of a joint, one of a link's ten, which motion shows in combinations alone, or
    what a log adds (zeros of sensors).
    """

    name: str
    unit: str
    before: float
    std: float
    decided: bool
    kind: Kind


@final
@dataclass(frozen=True)
class Count:
    """How many of the parameters of a kind, of which something was left to know, the data decide. left: median share
    of the doubt before."""

    kind: Kind
    decided: int
    of: int
    left: float


@final
@dataclass(frozen=True)
class Promise:
    """certain: of every parameter that an identification tells. cutoff_hz: up to which it looks."""

    certain: tuple[Certain, ...]
    cutoff_hz: float

    def open(self, kind: Kind) -> tuple[Certain, ...]:
        """Of which something was left to know."""
        return tuple(each for each in self.certain if each.kind == kind and each.before > 0.0)

    @property
    def counts(self) -> tuple[Count, ...]:
        """Of base and joint parameters. Those of links say the same once more: base parameters are made of them."""
        found = []
        for kind in COUNTED:
            of = self.open(kind)
            left = float(np.median([each.std / each.before for each in of])) if of else 1.0
            found.append(Count(kind, sum(each.decided for each in of), len(of), left))
        return tuple(found)


def promised(
    robot: Robot, planned: Sequence[Excited], logs: Sequence[Log] = (), before: Mapping[str, float] | None = None,
    settings: Settings = AS_STATED, progress: Progress = unwatched, seed: int = 0,
) -> Promise:  # fmt: skip
    """Of logs that there are and motions that are planned, all together. before: name -> standard deviation, the
    prior's where none is named. Raises as `identify`."""
    rng = np.random.default_rng(seed)
    made = [
        _noisy(robot, planned_log(robot, each, f"{NAME} {k + 1}"), each.task.criteria, rng)
        for k, each in enumerate(planned)
    ]
    found = identify(robot, [Recording(log, False) for log in (*logs, *made)], settings, progress)
    decided = found.model.criteria.identifying.decided
    kinds = _kinds(found)
    certain = []
    for each, white, kind in zip(found.parameters, white_std(found).tolist(), kinds, strict=True):
        std = min(max(each.std, white), each.prior_std)
        known = each.prior_std if before is None else before.get(each.name, each.prior_std)
        sure = each.identifiable and std <= decided * each.prior_std
        certain.append(Certain(each.name, each.unit, known, std, sure, kind))
    return Promise(tuple(certain), found.cutoff_hz)


def _kinds(found: Identification) -> tuple[Kind, ...]:
    """(parameters,) by place, as `identification.parameters` lists them: a link may be called as a joint is."""
    equations = found.model.equations
    links, joints = equations.robot.tree.phi.size, len(equations.robot.joints) * len(equations.effects)
    base = len(equations.base.columns)
    sizes: tuple[tuple[Kind, int], ...] = (
        ("link", links), ("joint", joints), ("added", len(found.parameters) - links - joints - base), ("base", base)
    )  # fmt: skip
    return tuple(kind for kind, size in sizes for _ in range(size))


def white_std(found: Identification) -> Array:
    """(parameters,) what the noise that the weights state leaves: of a log of seconds, few stretches of which count as
    independent, the scatter of its residuals says too little."""
    model = found.model
    standard = model.solution.prior.lift_covariance(model.solution.unbounded.covariance())
    regroup = model.equations.base.regroup
    size = regroup.shape[1]
    base = np.einsum("bi,ij,bj->b", regroup, standard[:size, :size], regroup)
    return np.asarray(np.sqrt(np.maximum(np.concatenate([np.diag(standard), base]), 0.0)))


def _noisy(robot: Robot, log: Log, criteria: MotionExcite, rng: np.random.Generator) -> Log:
    noise = {name: robot.noise.get(noise_kind(name), 0.0) for name in log.channels}
    heavy = dict(zip(robot.tree.joints, robot.tree.effort_limit, strict=True))
    for joint in robot.joints:
        unknown = criteria.unknown_noise * heavy[joint.name]
        for name, gain in ((f"tau.{joint.name}", 1.0), (f"i.{joint.name}", joint_prior(joint, "k_T"))):
            if name in noise and not noise[name] and np.isfinite(unknown):
                noise[name] = unknown / abs(gain)
    return replace(log, channels={
        name: values + noise[name] * rng.standard_normal(log.samples) for name, values in log.channels.items()
    })  # fmt: skip


def planned_log(robot: Robot, planned: Excited, name: str = NAME) -> Log:
    """As the a-priori robot's sensors without noise would read it, at the rate of `MotionExcite`."""
    task = planned.task
    rate = task.criteria.rate_hz
    time = np.arange(int(planned.duration * rate)) / rate
    whole = planned.at(time)
    motion = task.motion(whole)
    loads = task.information.loads(motion)
    channels = felt_channels(robot, motion, loads)
    told = task.information.of(motion, planned.duration, borne_by_feet(robot, motion, loads))
    for k, joint in enumerate(robot.joints):
        if joint.actuation == "current":
            channels[f"i.{joint.name}"] = told.motor[:, k] / told.gain[k]
        elif joint.actuation == "torque":
            channels[f"tau.{joint.name}"] = (told.motor @ robot.axes_from_joints)[:, k]
    return Log(name, time, channels)
