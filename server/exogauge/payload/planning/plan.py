"""From payload.yaml to a plan: its table, and what standard deviation every number will have."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.payload_dynamic import USUAL
from exogauge.errors import BadStudy, Fault
from exogauge.payload.contract import PayloadFile, PlanEntry
from exogauge.payload.dynamics import (
    NAMES,
    ZERO_NAMES,
    DynamicSolution,
    Prior,
    dynamic_rows,
    dynamic_stage,
    static_prior,
)
from exogauge.payload.planning.arm import CONTINUOUS, Arm, Component
from exogauge.payload.planning.excitation import Task, excite
from exogauge.payload.planning.postures import Believed, algorithm_1, choose, least_travel
from exogauge.payload.planning.workspace import Cap, inside
from exogauge.payload.schema import Certainty, Found
from exogauge.payload.sensor_motion import from_joints
from exogauge.payload.statics import StaticSolution
from exogauge.robots.joint_limits import JointLimits
from exogauge.robots.parameters import UNITS
from exogauge.robots.series import Series
from exogauge.robots.tree import RigidTree
from exogauge.robots.urdf import load_tree
from exogauge.studies.intake.robot_file import SIGN
from exogauge.studies.intake.yaml_file import load_yaml, suggestion
from exogauge.terminal import text_table

Array = NDArray[np.float64]
Progress = Callable[[float, str], None]

TRIED = 4000  # postures at random within the joints' limits
ON_THE_WAY = 12  # places between two postures at which a straight move is tried
SEED = 0
STATIC_NAMES = ("m", "cx", "cy", "cz", *ZERO_NAMES, "U", "V")
STATIC_UNITS = ("kg", *("m",) * 3, *("N",) * 3, *("N·m",) * 3, "°", "°")


@final
@dataclass(frozen=True)
class Asked:
    """What was handed in, checked."""

    file: PayloadFile
    plan: PlanEntry
    tree: RigidTree
    arm: Arm
    limits: JointLimits
    caps: tuple[Cap, ...]

    @property
    def std(self) -> Array:
        noise = self.file.sensor.noise
        return np.repeat([noise.force_n, noise.moment_nm], 3)

    @property
    def sign(self) -> int:
        return -int(SIGN[self.file.sensor.sees or "payload_on_sensor"])

    @property
    def believed(self) -> Believed:
        held = max(self.plan.postures.hold_s * self.plan.excitation.rate_hz, 1.0)
        component, gravity = self.arm.component, np.array(self.file.gravity)
        return Believed(component.mass, component.centre, gravity, self.sign, self.std / np.sqrt(held))

    @property
    def warnings(self) -> list[str]:
        said = []
        if self.arm.pairs == 0:
            said.append("The URDF has no collision shapes: collisions were not looked for.")
        if self.file.sensor.range is None:
            said.append("`sensor.range` is not stated: no bound on the wrench.")
        return said


@final
@dataclass(frozen=True)
class Plan:
    """columns: name -> (T,) of the CSV."""

    found: Found
    columns: Mapping[str, Array]


def open_plan(path: Path) -> Asked:
    """path: payload.yaml with `plan`, or its folder. Raises BadInput."""
    path = path / "payload.yaml" if path.is_dir() else path
    if not path.is_file():
        raise BadStudy(Fault("there is no such file", "no_file", "Name payload.yaml or its folder.", str(path)))
    file = load_yaml(path.read_bytes(), PayloadFile, file=path.name)
    plan, pose = file.plan, file.pose
    if plan is None:
        raise _fault(path, "nothing says what may be planned", "no_plan", "Add `plan` with joints, home, …", "plan")
    if pose.joints is None or pose.urdf is None or pose.base_link is None:
        advice = "Give `pose.urdf`, `pose.base_link` and `pose.joints`."
        raise _fault(path, "a plan needs the robot", "no_robot", advice, "pose")
    joints = list(pose.joints)
    for key in ("joints", "home", "acceleration", "position", "velocity", "torque"):
        for name in getattr(plan, key):
            if name not in joints:
                detail = "no such joint in `pose.joints`"
                raise _fault(path, detail, "unknown_joint", suggestion(name, joints), f"plan.{key}", name)
    for key, names in (("home", joints), ("acceleration", plan.joints)):
        lacking = [name for name in names if name not in getattr(plan, key)]
        if lacking:
            detail, advice = f"a joint has no {key}", f"Add `{lacking[0]}` to `plan.{key}`."
            raise _fault(path, detail, f"no_{key}", advice, f"plan.{key}", lacking[0])
    urdf = path.parent / pose.urdf
    if not urdf.is_file():
        raise _fault(path, "there is no such file", "no_file", "Paths are relative to payload.yaml.", "pose.urdf",
                     pose.urdf)  # fmt: skip
    tree = load_tree(urdf.read_bytes(), joints=joints, base_link=pose.base_link, floating=False, file=pose.urdf)
    frame = file.sensor.frame or ""
    if frame not in tree.frames:
        advice = suggestion(frame, list(tree.frames))
        raise _fault(path, "the URDF has no such frame", "unknown_frame", advice, "sensor.frame", frame)
    limits = _limits(path, plan, tree)
    body = Component(plan.payload.mass_kg, np.array(plan.payload.centre_m), np.array(plan.payload.size_m))
    home = np.array([plan.home[name] for name in joints])
    arm = Arm(
        urdf.read_bytes(), joints, pose.base_link, frame, np.array(file.gravity), body, plan.joints, home,
        folder=urdf.parent, file=pose.urdf,
    )  # fmt: skip
    caps = caps_of(plan)
    outside = [joints[k] for k in range(len(joints)) if not limits.lower[k] <= home[k] <= limits.upper[k]]
    if outside:
        k = joints.index(outside[0])
        detail = f"home of {outside[0]} is outside {limits.lower[k]:.4g} to {limits.upper[k]:.4g} rad"
        advice = "Angles are in rad; correct `home`, or the limits in `plan.position`."
        raise _fault(path, detail, "home_outside", advice, "plan.home", f"{home[k]:.4g}")
    here = home[arm.moved][None]
    if not inside(caps, arm.rotations(here))[0]:
        advice = "Correct `home`, or widen `plan.workspace`; theta is from +z of the base, phi about it."
        raise _fault(path, "home lies outside the workspace", "home_outside", advice, "plan.workspace")
    touching = arm.touching(here[0])
    if touching:
        said = "; ".join(f"{one} with {other}" for one, other in touching[:3])
        advice = "Correct `home`, the box of `plan.payload`, or the collision shapes of the URDF."
        raise _fault(path, f"the robot collides at home: {said}", "home_collides", advice, "plan.home", said)
    return Asked(file, plan, tree, arm, limits, caps)


def caps_of(plan: PlanEntry) -> tuple[Cap, ...]:
    return tuple(
        Cap("xyz".index(cap.axis), *((np.radians(a), np.radians(b)) for a, b in (cap.phi_deg, cap.theta_deg)))
        for cap in plan.workspace
    )


def plan_postures(asked: Asked, progress: Progress) -> Plan:
    """Raises NotIdentifiable."""
    progress(0.0, "postures")
    angles, solution = _chosen(asked)
    progress(0.6, "order")
    arm = asked.arm
    speed, home = asked.limits.velocity[arm.moved], arm.home[arm.moved]

    def passable(a: Array, b: Array) -> bool:
        way = a + np.linspace(0.0, 1.0, ON_THE_WAY)[:, None] * (b - a)
        return bool(inside(asked.caps, arm.rotations(way)).all() and not arm.collides(way).any())

    order = least_travel(angles, home, speed, passable)
    angles = angles[order]
    stops = np.vstack([home, angles])
    warnings = asked.warnings + [
        f"The straight move to posture {k + 1} leaves the workspace or collides: go round."
        for k in range(len(angles)) if not passable(stops[k], stops[k + 1])
    ]  # fmt: skip
    scale = np.array([1.0] * 10 + [np.degrees(1.0)] * 2)
    certain = [
        Certainty(name=name, unit=unit, std=float(std), before=None, decided=True)
        for name, unit, std in zip(STATIC_NAMES, STATIC_UNITS, scale * solution.std, strict=True)
    ]
    travel = float(np.max(np.abs(np.diff(stops, axis=0)) / speed, axis=1).sum())
    found = Found(
        name=asked.file.name, kind="postures", choice=asked.plan.postures.choice, certainties=certain,
        undecided=list(NAMES[4:]), seconds=travel + len(angles) * asked.plan.postures.hold_s,
        condition=solution.condition, warnings=warnings,
    )  # fmt: skip
    down = np.einsum("kji,j->ki", arm.rotations(angles), arm.gravity / np.linalg.norm(arm.gravity))
    columns = {"posture": np.arange(1.0, len(angles) + 1)} | _named("q", arm, arm.posture(angles))
    progress(1.0, "done")
    return Plan(found, columns | {f"gravity.{axis}": down[:, k] for k, axis in enumerate("xyz")})


def plan_excitation(asked: Asked, progress: Progress) -> Plan:
    """After postures as planned: their static stage is the prior. Raises NotIdentifiable."""
    progress(0.0, "postures")
    choice, rated = asked.plan.excitation, asked.file.sensor.range
    prior = static_prior(_chosen(asked)[1])
    task = Task(
        asked.arm, Series(choice.duration_s, choice.harmonics), asked.limits, asked.caps, asked.sign, asked.std,
        choice.rate_hz, prior, np.full(6, np.inf) if rated is None else np.array([*rated.force_n, *rated.moment_nm]),
    )  # fmt: skip
    motions = excite(
        task, np.random.default_rng(SEED), choice.starts,
        progress=lambda fraction, phrase: progress(0.1 + 0.8 * fraction, phrase),
    )  # fmt: skip
    progress(0.9, "rehearsal")
    time = np.arange(round(choice.duration_s * choice.rate_hz) + 1) / choice.rate_hz
    motion = task.series.motion(motions[0].x, time)
    solution = rehearse(asked, time, motion, prior)
    certain = [
        Certainty(
            name=name, unit=unit, std=float(std), before=float(before),
            decided=bool(sure or before < USUAL.decided * most),
        )
        for name, unit, std, before, sure, most in zip(
            (*NAMES, *ZERO_NAMES), (*UNITS, *("N",) * 3, *("N·m",) * 3), solution.std, solution.prior_std,
            solution.decided, np.sqrt(np.diag(static_prior(None).covariance)), strict=True,
        )
    ]  # fmt: skip
    warnings = [*asked.warnings]
    if motions[0].smaller:
        warnings.append(
            "The motion is smaller than the bounds allow, so that nothing touches: a home farther from the robot, or a "
            "smaller box of `plan.payload`, may tell more."
        )
    found = Found(
        name=asked.file.name, kind="excitation", choice="least_std", certainties=certain,
        undecided=[each.name for each in certain if not each.decided], seconds=choice.duration_s,
        strain=motions[0].strain, starts=[each.cost for each in motions], warnings=warnings,
    )  # fmt: skip
    columns = {"t": time}
    for key, values in zip(("q", "dq", "ddq"), motion, strict=True):
        full = asked.arm.posture(values) if key == "q" else np.zeros((len(time), len(asked.arm.joints)))
        full[:, asked.arm.moved] = values
        columns |= _named(key, asked.arm, full)
    progress(1.0, "done")
    return Plan(found, columns)


def rehearse(asked: Asked, time: Array, motion: tuple[Array, Array, Array], prior: Prior) -> DynamicSolution:
    """The dynamic stage's answer to the motion (T, n) q, q̇, q̈ as the believed payload and the stated noise of
    sensor and encoders would log it: smoothed, with residuals that are not white."""
    rng, arm, gravity = np.random.default_rng(SEED), asked.arm, np.array(asked.file.gravity)
    seen = arm.posture(motion[0])
    seen = seen + asked.file.pose.noise_rad * rng.standard_normal(seen.shape)
    smoothed = from_joints(
        asked.tree, asked.file.sensor.frame or "", time, seen, asked.file.pose.noise_rad, gravity,
        density=asked.file.settings.jerk_density,
    )  # fmt: skip
    exact = arm.wrench(arm.moving(*motion), asked.sign)
    wrench = exact + asked.std * rng.standard_normal(exact.shape)
    inner = slice(smoothed.edge, len(time) - smoothed.edge)
    rows = dynamic_rows(smoothed.inner(), wrench[inner], gravity, asked.sign, asked.std)
    return dynamic_stage(rows, prior, asked.file.settings.method)


def write_plan(plan: Plan, out: Path) -> tuple[Path, Path]:
    """postures.csv or excitation.csv, and the JSON beside it, in `out`."""
    out.mkdir(parents=True, exist_ok=True)
    table, told = (out / f"{plan.found.kind}.{ending}" for ending in ("csv", "json"))
    rows = np.column_stack(list(plan.columns.values()))
    lines = [",".join(plan.columns), *(",".join(f"{value:.12g}" for value in row) for row in rows)]
    table.write_text("\n".join(lines) + "\n", encoding="utf-8")
    content = json.dumps(plan.found.model_dump(mode="json"), indent=1, ensure_ascii=False)
    told.write_text(content + "\n", encoding="utf-8")
    return table, told


def summary(found: Found) -> str:
    """Text for a terminal."""
    parts = [f"{found.name}: {found.kind}, {found.seconds:.3g} s"]
    if found.condition:
        parts.append(f"condition {found.condition[0]:.1f} (force) and {found.condition[1]:.1f} (moment)")
    if found.strain is not None:
        parts.append(f"nearest bound: {100 * found.strain:.1f} %")
    rows: list[list[Any]] = [
        [each.name, f"{each.std:.2g}", each.unit, "" if each.decided else "not decided"] for each in found.certainties
    ]
    parts.append(text_table(("", "±", "unit", ""), rows))
    if found.undecided:
        parts.append(f"not decided: {', '.join(found.undecided)}")
    return "\n".join([*parts, *(f"warning: {each}" for each in found.warnings)])


def _chosen(asked: Asked) -> tuple[Array, StaticSolution]:
    """(K, n) angles of the postures, and what the static stage will say."""
    arm, choice, believed = asked.arm, asked.plan.postures, asked.believed
    lower, upper = asked.limits.lower[arm.moved], asked.limits.upper[arm.moved]
    if choice.choice == "algorithm_1":
        reached: dict[bytes, Array] = {}

        def feasible(rotation: Array) -> NDArray[np.bool_]:
            allowed = inside(asked.caps, rotation)
            for k in np.flatnonzero(allowed):
                angles = arm.reach(rotation[k], lower, upper)
                allowed[k] = angles is not None and not arm.collides(angles[None])[0]
                if angles is not None:
                    reached[rotation[k].tobytes()] = angles
            return allowed

        wanted = algorithm_1(choice.count, choice.K, feasible)
        return np.array([reached[R.tobytes()] for R in wanted]), believed.solution(wanted)
    angles = np.random.default_rng(SEED).uniform(lower, upper, (TRIED, len(arm.moved)))
    angles = np.vstack([arm.home[arm.moved], angles])
    angles = angles[inside(asked.caps, arm.rotations(angles))]
    angles = angles[~arm.collides(angles)]
    rotation = arm.rotations(angles)
    chosen = choose(rotation, choice.count, believed)
    return angles[chosen], believed.solution(rotation[chosen])


def _limits(path: Path, plan: PlanEntry, tree: RigidTree) -> JointLimits:
    """The URDF's, with those of the plan in their place."""
    joints = tree.joints

    def stated(limit: Array, given: Mapping[str, float]) -> Array:
        return np.array([given.get(name, x) for name, x in zip(joints, limit.tolist(), strict=True)])

    position = np.clip(np.stack([tree.lower, tree.upper], axis=1), -CONTINUOUS, CONTINUOUS)
    for name, pair in plan.position.items():
        if pair[0] >= pair[1]:
            advice = "Give [from, to] in rad with from < to."
            raise _fault(path, "an empty range", "empty_range", advice, f"plan.position.{name}", str(list(pair)))
        position[joints.index(name)] = pair
    velocity = stated(tree.velocity_limit, plan.velocity)
    for name in plan.joints:
        if not np.isfinite(velocity[joints.index(name)]):
            advice = f"Add `{name}` to `plan.velocity` [rad/s]."
            raise _fault(path, "neither the URDF nor the plan limits the velocity", "no_velocity", advice,
                         "plan.velocity", name)  # fmt: skip
    return JointLimits(
        position[:, 0], position[:, 1], velocity, stated(np.full(len(joints), np.inf), plan.acceleration),
        stated(tree.effort_limit, plan.torque),
    )  # fmt: skip


def _named(key: str, arm: Arm, values: Array) -> dict[str, Array]:
    return {f"{key}.{joint}": values[:, k] for k, joint in enumerate(arm.joints)}


def _fault(path: Path, detail: str, rule: str, advice: str, column: str, value: str | None = None) -> BadStudy:
    return BadStudy(Fault(detail, rule, advice, path.name, None, column, value))
