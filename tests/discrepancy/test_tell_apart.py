"""What a planned motion promises is what a recording of it keeps; what no motion can tell apart is said to be so."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin
import pytest
import yaml
from scipy.interpolate import CubicSpline
from tests.discrepancy.conftest import FRICTION, JOINTS, RATE, SETTINGS, inverse_dynamics

from exogauge.criteria.planning import Planning
from exogauge.detect.pipeline import find_missing_effects
from exogauge.effects.catalogue import shaped_effects
from exogauge.effects.effect import Quantity
from exogauge.experiment.design import Known, Weighing, reach_in, tell_apart, with_motions
from exogauge.experiment.motion_choices import choices
from exogauge.experiment.planned_rows import as_log, new_rows, with_next_log
from exogauge.experiment.workspace_limits import carrying, room
from exogauge.findings.basis import OfRobot
from exogauge.findings.result import Alternative, Evidence, Finding, HeldOut, Place
from exogauge.findings.verdict import Objection, Why
from exogauge.identification.identify import identify
from exogauge.identification.per_log import PerLog
from exogauge.identification.settings import Recording
from exogauge.identification.sites import AxisSite
from exogauge.logs.model import Log
from exogauge.motion.robot_file import load_motion_robot
from exogauge.robots.description import Joint, Robot, WrenchSensor
from exogauge.robots.urdf import load_tree
from exogauge.search.ambiguity import Undecided, undecided
from exogauge.search.baseline import lay_ground
from exogauge.search.candidates import Candidate
from exogauge.search.refine import closest
from exogauge.search.score import Baseline, Score, score
from exogauge.search.site_rows import collect_rows, sums_of
from exogauge.studies.words.motion_sentences import motion_words, not_told, planned_sentence

ENOUGH = Planning().enough

SWEPT = AxisSite(1)
FASTER_THAN = 0.8  # [rad/s] whatever the logs hold
PEAK, WIDTH = 2.0, 0.7  # [N·m], [rad/s] of the friction that falls with speed


def hidden_friction(v: np.ndarray) -> np.ndarray:
    """Larger at low speed, as a rational curve and not as the catalogue's exponential."""
    return np.array([0.0, 1.0, 0.0]) * PEAK * np.sign(v) / (1.0 + (v / WIDTH) ** 2)


def driven(name: str, q: np.ndarray, seed: int, times: float = 1.0) -> Log:
    """A log of the true arm moved along q (T, 3). times: by which the hidden friction is larger."""
    rng, t = np.random.default_rng(seed), np.arange(len(q)) / RATE
    path = CubicSpline(t, q)
    v, a = path(t, 1), path(t, 2)
    drive = inverse_dynamics(q, v, a) + FRICTION["k_d"] * v + FRICTION["tau_c"] * np.sign(v) - FRICTION["tau_o"]
    tau = drive + times * hidden_friction(v) + 0.05 * rng.normal(size=q.shape)
    measured = q + 1e-5 * rng.normal(size=q.shape)
    channels = {f"q.{name}": measured[:, j] for j, name in enumerate(JOINTS)}
    return Log(name, t, channels | {f"tau.{name}": tau[:, j] for j, name in enumerate(JOINTS)})


def fast(seed: int, seconds: float = 40.0, times: float = 1.0) -> Log:
    """Every joint to and fro at steady speeds, none below `FASTER_THAN`."""
    rng, n, paths = np.random.default_rng(seed), round(seconds * RATE), []
    window = np.hanning(27)[1:-1] / np.hanning(27)[1:-1].sum()
    for _ in JOINTS:
        speeds: list[float] = []
        at, side = 0.0, 1.0
        while len(speeds) < n:
            v, end = rng.uniform(FASTER_THAN, 1.8), side * rng.uniform(0.5, 0.9)
            steps = max(1, round(abs(end - at) / v * RATE))
            v = v if end > at else -v
            speeds += [v] * steps
            at, side = at + v * steps / RATE, -side
        paths.append(np.cumsum(np.convolve(speeds[:n], window, mode="same")) / RATE)
    return driven(f"fast{seed}", np.array(paths).T, seed, times)


@dataclass(frozen=True)
class Fast:
    recordings: list[Recording]
    found: object

    @property
    def logs(self) -> list[Log]:
        return [each.log for each in self.recordings if not each.held_out]


@pytest.fixture(scope="module")
def fast_only(robot):
    recordings = [Recording(fast(1), False), Recording(fast(2), False)]
    return Fast(recordings, identify(robot, recordings, SETTINGS))


def best(found, recordings, name) -> Score:
    """With the shape that fits best, at the joint with the hidden friction."""
    effect = shaped_effects()[name]
    ground = lay_ground(found.model, recordings, [effect], lambda *_: None)
    rows = collect_rows(found.model, recordings, [SWEPT])
    of_grid = [each for each in ground.scores if each.candidate.site == SWEPT]
    return closest(ground.baseline, of_grid, rows[SWEPT])


def doubt_between(found, recordings, scores) -> Undecided:
    rows = collect_rows(found.model, recordings, [SWEPT])
    (kind,) = SWEPT.kinds(found.model.equations)
    return undecided(found.model, scores, kind, float(found.model.solution.weights[kind]) ** -0.5, rows)


def fitted(found, recordings, effect, shape) -> Score:
    rows = collect_rows(found.model, recordings, [SWEPT])
    candidate = Candidate(effect, SWEPT, shape)
    memory = dict.fromkeys(range(len(found.model.equations.layout)), 1.0)
    scored = score(Baseline(found.model, memory), candidate, sums_of(rows[SWEPT], effect, shape))
    assert scored is not None
    return scored


@pytest.fixture(scope="module")
def pair(fast_only):
    """Stribeck and nonlinear viscous friction, each as it fits best."""
    return [best(fast_only.found, fast_only.recordings, name) for name in ("stribeck", "nonlinear_viscous")]


@pytest.fixture(scope="module")
def doubt(fast_only, pair):
    return doubt_between(fast_only.found, fast_only.recordings, pair)


@pytest.mark.slow
def test_fast_logs_cannot_tell_stribeck_friction_from_a_progressive_one(pair):
    stribeck, progressive = pair
    assert min(stribeck.evidence, progressive.evidence) > ENOUGH  # either explains what is there
    assert stribeck.evidence - progressive.evidence < ENOUGH


@pytest.mark.slow
def test_slow_motion_is_planned_and_its_recording_decides(robot, fast_only, doubt):
    outcome = tell_apart(doubt, fast_only.logs)
    (motion,), (promised,) = outcome.motions, outcome.pairs
    assert motion.joint == "j2"
    speed = np.abs(np.gradient(motion.q[:, 1], motion.time))
    slow = (speed > 0.01) & (speed < 0.25 * FASTER_THAN)
    assert slow.mean() > 0.2  # of its time
    assert promised.seconds is not None
    assert promised.evidence > ENOUGH
    assert promised.evidence_now < ENOUGH

    t = np.arange(0.0, motion.time[-1], 1.0 / RATE)
    recorded = driven("planned", CubicSpline(motion.time, motion.q)(t), seed=5)
    more = [*fast_only.recordings, Recording(recorded, False)]
    again = identify(robot, more, SETTINGS)
    stribeck, progressive = (best(again, more, name) for name in ("stribeck", "nonlinear_viscous"))
    assert stribeck.evidence - progressive.evidence > ENOUGH


@pytest.mark.slow
def test_a_finding_gets_its_motion_in_words_and_as_a_path(fast_only, doubt):
    nothing = np.zeros(0)
    place = Place("joint", "j2")
    finding = Finding(
        1, "stribeck", place, {}, HeldOut("tau.j2", "N·m", 2.0, 1.0, 1.0), 0.9,
        OfRobot(shaped_effects()["stribeck"]), (),
        (Alternative("nonlinear_viscous", place, 0.9, Objection(Why.ALIKE)),), Evidence("", "", *([nothing] * 5)),
    )  # fmt: skip
    alone = replace(finding, also_possible=())
    told, untouched = with_motions([finding, alone], {("stribeck", place): doubt}, fast_only.logs)
    assert motion_words(told) == planned_sentence(told.plans[0])
    assert [each.rival for each in told.apart] == ["nonlinear_viscous"]
    assert told.plans[0].q.shape == (len(told.plans[0].time), len(JOINTS))
    assert (motion_words(untouched), untouched.plans) == ("", ())
    assert motion_words(finding) == shaped_effects()["stribeck"].needs


def test_an_effect_is_never_told_from_itself(fast_only, pair):
    same = doubt_between(fast_only.found, fast_only.recordings, [pair[0], pair[0]])
    outcome = tell_apart(same, fast_only.logs)
    assert outcome.motions == ()
    (apart,) = outcome.pairs
    assert apart.seconds is None
    assert apart.left_now < 1e-9
    assert apart.left_then < 1e-9
    assert "both look the same" in not_told(apart)


CAPSULES = {"base": (0.08, 0.05), "lj1": (0.04, 0.15), "lj2": (0.04, 0.15), "lj3": (0.04, 0.15)}  # radius, length [m]


def moving_arm(folder, arm_urdf, most):
    """The arm as motions are planned for it, every bound of which its file tells. most: [rad/s²]."""
    (folder / "robot.urdf").write_text(arm_urdf)
    shapes = {link: [{"capsule": list(size), "xyz": [0.0, 0.0, 0.1]}] for link, size in CAPSULES.items()}
    content = {
        "version": 1, "name": "arm", "urdf": "robot.urdf", "base": "fixed", "uncertainty": "none",
        "joints": [{"name": name, "actuation": "torque"} for name in JOINTS], "noise": {"tau": 0.05},
        "limits": {"acceleration": most}, "collision": {"shapes": shapes},
    }  # fmt: skip
    (folder / "robot.yaml").write_text(yaml.safe_dump(content))
    return load_motion_robot(folder / "robot.yaml")


def nearest(urdf: str, q: np.ndarray) -> float:
    """[m] of capsules that no one joint lies between, by points along their axes."""
    model = pin.buildModelFromXML(urdf)
    data, found = model.createData(), np.inf
    for posture in q:
        pin.framesForwardKinematics(model, data, posture)
        axes = {}
        for link, (_, length) in CAPSULES.items():
            along = np.outer(0.1 + np.linspace(-0.5, 0.5, 31) * length, [0.0, 0.0, 1.0])
            at = data.oMf[model.getFrameId(link, pin.FrameType.BODY)]
            axes[link] = along @ at.rotation.T + at.translation
        for one, other in (("base", "lj2"), ("base", "lj3"), ("lj1", "lj3")):
            far = np.linalg.norm(axes[one][:, None] - axes[other][None], axis=2).min()
            found = min(found, far - CAPSULES[one][0] - CAPSULES[other][0])
    return found


@pytest.mark.slow
@pytest.mark.parametrize(("most", "looked_hz"), [(20.0, 20.0), (2.0, 2.0)])
def test_what_tells_most_a_second_is_offered_and_keeps_every_bound(
    fast_only, doubt, tmp_path, arm_urdf, most, looked_hz
):
    """looked_hz: at 2 Hz turns are not seen, so that what breaks a bound as it is written is found at the end."""
    model, moving = doubt.model, moving_arm(tmp_path, arm_urdf, most)
    criteria = replace(model.criteria, planning=replace(model.criteria.planning, varied=8, looked_hz=looked_hz))
    quickly = replace(doubt, model=replace(model, criteria=criteria))
    here, known = room(model, fast_only.logs), Known.of(quickly)
    sweeps = Weighing.of(known, here, reach_in(moving, model, here)).tries()
    outcome = tell_apart(quickly, fast_only.logs, moving)
    (motion,), (promised,) = outcome.motions, outcome.pairs
    assert (motion.kept, motion.unknown) == (("touch", "torque"), ())
    for each in sweeps:
        written = as_log(model, here, each.choice, 50.0)
        path = CubicSpline(written.time, written.stack([f"q.{name}" for name in JOINTS]))
        if each.sort == "sweep" and np.abs(path(np.arange(0.0, written.time[-1], 1.0 / RATE), 2)).max() <= most:
            assert promised.rate >= 10.0 * each.gain[1] / each.seconds

    path = CubicSpline(motion.time, motion.q)
    t = np.arange(0.0, motion.time[-1], 1.0 / RATE)
    q, v, a = path(t), path(t, 1), path(t, 2)
    assert np.abs(q).max() <= 3.0
    assert np.abs(v).max() <= Planning().of_top * 10.0
    assert np.abs(a).max() <= most
    drive = inverse_dynamics(q, v, a) + FRICTION["k_d"] * v + FRICTION["tau_c"] * np.sign(v)
    assert np.abs(drive).max() <= 100.0
    assert nearest(arm_urdf, q[::10]) > 0.01 - 1e-3


class _Scaled:
    """Another effect, in another unit."""

    def __init__(self, other, size):
        self.other, self.size = other, size
        self.coefficients = tuple(Quantity(q.name, q.unit, q.low / size, q.high / size) for q in other.coefficients)

    def __getattr__(self, name):
        return getattr(self.other, name)

    def columns(self, signals, shape):
        return self.size * self.other.columns(signals, shape)


@pytest.mark.slow
def test_units_change_nothing(fast_only, pair, doubt):
    first, second = pair
    rescaled = []
    for one, size in ((first, 7.0), (second, 0.01)):
        candidate = replace(one.candidate, effect=_Scaled(one.candidate.effect, size))
        rescaled.append(replace(one, candidate=candidate, coefficients=one.coefficients / size))
    told, anew = (
        tell_apart(each, fast_only.logs).pairs[0]
        for each in (doubt, doubt_between(fast_only.found, fast_only.recordings, rescaled))
    )
    for name in ("left_now", "left_then", "evidence_now", "evidence", "rate", "seconds"):
        assert getattr(anew, name) == pytest.approx(getattr(told, name), rel=1e-6)


def test_what_is_left_is_what_a_fit_of_all_rows_leaves(fast_only, doubt):
    """Logs, planned motion and prior stacked and solved at once."""
    model = with_next_log(fast_only.found.model)
    here, known = room(model, fast_only.logs), Known.of(doubt)
    sweep = choices(model, here, SWEPT.kinds(model.equations), [SWEPT.axis], slow_change=False)[0]
    new = new_rows(doubt, model, here, sweep, known.kept)
    after = known.after(new).left(3.0)

    prior, strength, own = model.solution.prior, model.solution.strength, model.equations.columns()
    H = strength * prior.whitening.T @ prior.whitening
    normal, _, _ = model.solution.statistics.normal(model.solution.weights)
    H = H + normal[np.ix_(prior.free, prior.free)]
    B, S = doubt.B[prior.free].copy(), doubt.S + 3.0 * new.c.T @ new.c
    place = np.searchsorted(prior.free, known.kept)
    H[np.ix_(place, place)] += 3.0 * new.A.T @ new.A
    B[place] += 3.0 * new.A.T @ new.c
    dense = S - B.T @ np.linalg.solve(H, B)
    assert after == pytest.approx(dense, rel=1e-5, abs=1e-8 * float(np.abs(S).max()))
    assert set(np.concatenate([own[kind] for kind in SWEPT.kinds(model.equations)])) >= set(known.kept)


@pytest.mark.parametrize("repeated", [1, 200])
def test_a_motion_that_tells_nothing_of_the_parameters_adds_its_columns_alone(fast_only, doubt, repeated):
    """As a sweep of a joint about the vertical does of masses: few such rows, and more than there are parameters."""
    model = with_next_log(fast_only.found.model)
    here, known = room(model, fast_only.logs), Known.of(doubt)
    sweep = choices(model, here, SWEPT.kinds(model.equations), [SWEPT.axis], slow_change=False)[0]
    new = new_rows(doubt, model, here, sweep, known.kept)
    c = np.tile(new.c[:3], (repeated, 1))
    after = known.after(replace(new, A=np.zeros((len(c), new.A.shape[1])), c=c)).left(2.0)
    assert len(known.kept) < 600
    np.testing.assert_allclose(after, known.now + 2.0 * c.T @ c, rtol=1e-9)


class _Twin(_Scaled):
    """Another effect, with Coulomb and viscous friction that the model has anyway."""

    def columns(self, signals, shape):
        friction = 0.4 * signals.direction + 0.7 * signals.velocity
        return self.size * self.other.columns(signals, shape) - friction[:, None]


def test_what_the_baseline_makes_alike_is_never_told_apart(fast_only, pair):
    stribeck = pair[0].candidate
    twin = fitted(fast_only.found, fast_only.recordings, _Twin(stribeck.effect, 1.0), stribeck.shape)
    (apart,) = tell_apart(doubt_between(fast_only.found, fast_only.recordings, [pair[0], twin]), fast_only.logs).pairs
    assert apart.seconds is None
    assert apart.left_then < 0.02


def narrow(robot: Robot, speed: float) -> Robot:
    tree = replace(
        robot.tree,
        lower=np.array([-0.6, -0.4, -3.0]),
        upper=np.array([0.7, 0.5, 3.0]),
        velocity_limit=np.full(3, speed),
    )
    return replace(robot, tree=tree)


@pytest.mark.parametrize("speed", [0.5, 10.0])
def test_no_choice_leaves_the_limits(robot, fast_only, speed):
    tight = narrow(robot, speed)
    model = fast_only.found.model
    model = replace(model, equations=replace(model.equations, robot=tight), computed=PerLog())
    here = room(model, fast_only.logs)
    every = choices(model, here, SWEPT.kinds(model.equations), [SWEPT.axis], slow_change=True)
    assert {each.sweep.kind for each in every} == {"speeds", "sine", "small"}
    for each in every:
        q = each.positions(here.posture, 100.0)
        assert np.all(q >= tight.tree.lower)
        assert np.all(q <= tight.tree.upper)
        assert np.abs(np.diff(q, axis=0)).max() * 100.0 <= speed
        assert np.abs(q[0] - q[-1]).max() < 0.05  # so that it can be repeated


def test_a_motor_is_not_asked_for_more_than_it_has(robot, fast_only, doubt):
    model = with_next_log(fast_only.found.model)
    here, known = room(model, fast_only.logs), Known.of(doubt)
    choice = choices(model, here, SWEPT.kinds(model.equations), [SWEPT.axis], slow_change=False)[0]
    assert new_rows(doubt, model, here, choice, known.kept) is not None
    weak = replace(robot, tree=replace(robot.tree, effort_limit=np.full(3, 0.5)))  # [N·m]; the arm weighs 9 kg
    too_weak = replace(model, equations=replace(model.equations, robot=weak), computed=PerLog())
    assert new_rows(doubt, too_weak, here, choice, known.kept) is None


def test_only_the_swept_joint_and_its_companion_move(fast_only):
    model = fast_only.found.model
    here = room(model, fast_only.logs)
    for each in choices(model, here, SWEPT.kinds(model.equations), [SWEPT.axis], slow_change=False):
        log = as_log(model, here, each, 50.0)
        moved = {name for name in JOINTS if np.ptp(log.channels[f"q.{name}"]) > 0.0}
        assert moved == {JOINTS[k] for k in (each.lead, each.companion) if k is not None}


def test_legs_carry_the_robot_and_arms_do_not():
    def link(name: str) -> str:
        inertia = '<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/>'
        return f'<link name="{name}"><inertial><mass value="2"/>{inertia}</inertial></link>'

    def joint(name: str, a: str, b: str) -> str:
        limit = '<limit lower="-1" upper="1" velocity="2" effort="50"/>'
        ends = f'<parent link="{a}"/><child link="{b}"/><origin xyz="0 0 -0.3"/><axis xyz="0 1 0"/>'
        return f'<joint name="{name}" type="revolute">{ends}{limit}</joint>'

    parts = [link(name) for name in ("pelvis", "thigh", "shank", "arm")]
    parts += [joint("hip", "pelvis", "thigh"), joint("knee", "thigh", "shank"), joint("shoulder", "pelvis", "arm")]
    names = ["hip", "knee", "shoulder"]
    tree = load_tree(
        f'<robot name="r">{"".join(parts)}</robot>'.encode(), joints=names, base_link="pelvis", floating=True
    )
    foot = WrenchSensor("foot", "shank", "contact", 1.0)
    robot = Robot("r", tree, tuple(Joint(name, "torque") for name in names), None, (foot,), np.eye(3))
    assert carrying(robot).tolist() == [True, True, False]
    assert not carrying(replace(robot, sensors=())).any()


@pytest.mark.slow
def test_a_search_that_cannot_decide_says_what_to_record(robot):
    seconds = {1: 20.0, 2: 20.0, 9: 20.0}
    recordings = [Recording(fast(seed, s, times=1.15), held_out=seed == 9) for seed, s in seconds.items()]
    effects = [shaped_effects()[name] for name in ("stribeck", "nonlinear_viscous")]
    found = find_missing_effects(identify(robot, recordings, SETTINGS), recordings, effects, SETTINGS)
    (finding,) = found.discrepancy.findings
    (also,) = finding.also_possible
    assert {finding.effect, also.effect} == {"stribeck", "nonlinear_viscous"}
    (apart,) = finding.apart
    assert apart.rival == also.effect
    assert finding.plans[0].joint == "j2"
    assert motion_words(finding) == planned_sentence(finding.plans[0])
