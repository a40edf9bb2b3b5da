"""A whole study folder: robot, devices, logs, study file, and beside them the truth that no evaluating code opens;
and README.txt, which says that none of it was measured.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path

import yaml

from exogauge.errors import BadInput, Fault
from exogauge.synthetic.disturbances import IDEAL, Disturbances
from exogauge.synthetic.hidden import Hidden, parse_hidden, specs_to_hide
from exogauge.synthetic.lab import drawn_lab
from exogauge.synthetic.log_plans import SUITS, LogPlan, log_plans
from exogauge.synthetic.log_runs import Bench, Progress, run_log, write_logs
from exogauge.synthetic.mjcf import mujoco_model
from exogauge.synthetic.played import PlayedMotion
from exogauge.synthetic.random_streams import stream
from exogauge.synthetic.robot_facts import NAME
from exogauge.synthetic.simulation import LOG_RATE_HZ
from exogauge.synthetic.suit import Suit, bands_record, device_file, fitted_suit
from exogauge.synthetic.tolerances import declared, uncertainty
from exogauge.synthetic.true_robot import a_priori_robot, draw_robot, truth_record
from exogauge.synthetic.urdf import robot_file, robot_urdf


def write_study(
    out: Path,
    seed: int,
    hidden: Sequence[str] | None = None,
    suit: str = "both",
    progress: Progress | None = None,
    logs: Sequence[LogPlan] | None = None,
    processes: int = 1,
    disturbed: Disturbances = IDEAL,
    played: Sequence[PlayedMotion] = (),
) -> None:
    """Write a synthetic study of `hrp4_like` into `out`; the same seed gives the same bytes, with any `processes`.

    hidden: `EFFECT@PLACE` put into the true robot and not into the a-priori one; by default what `specs_to_hide` says.
    suit: none, normal, modified, or both: which are worn in the logs with a device. progress: called with the share
    done (0 to 1) and what is being done. logs: which ones, by default all of `log_plans`. More than one process needs
    a main module that can be imported. disturbed: what the laboratory does to it, see `disturbances`. played:
    motions from files, in place of bends and twists; the files lie in `plans/`, and the study names them.
    """
    if suit not in SUITS:
        detail, advice = f"a sample with suit {suit!r} cannot be made", f"Known: {', '.join(SUITS)}"
        raise BadInput(Fault(detail, "unknown_suit", advice, column="suit", value=suit))
    if seed < 0:
        raise BadInput(Fault("the seed must be 0 or more", "seed_negative", column="seed", value=str(seed)))
    effects = parse_hidden(specs_to_hide(hidden, suit), stream(seed, "hidden"))
    plans = log_plans(suit, {each.name: each.duration_s for each in played}) if logs is None else logs
    bench = _bench(seed, effects, suit, plans, disturbed, played)
    suits, lab = dict(bench.suits), bench.lab
    files = {kind: f"device{'' if n == 0 else f'_{kind}'}.yaml" for n, kind in enumerate(suits)}
    write_logs(out, bench, plans, progress or (lambda share, what: None), processes)
    for each in played:
        (out / "plans").mkdir(exist_ok=True)
        (out / _plan_file(each)).write_bytes(each.source)
    (out / "robot.urdf").write_text(robot_urdf(), encoding="utf-8")
    _write_yaml(out / "robot.yaml", robot_file(lab.encoder_step, uncertainty("robot", disturbed)))
    for kind, file in files.items():
        _write_yaml(out / file, device_file(lab.as_measured(suits[kind]), uncertainty("device", disturbed)))
    (out / "README.txt").write_text(readme(seed, plans, files, disturbed), encoding="utf-8")
    truth = truth_record(bench.robot, effects) | _bands_of(list(suits.values())) | lab.record(plans, suits)
    if disturbed:
        truth["tolerances"] = declared(disturbed)
    (out / "truth.json").write_text(json.dumps(truth, indent=1) + "\n", encoding="utf-8")
    _write_yaml(
        out / "study.yaml", _study_file(seed, plans, files, disturbed, lab.session.start_s, played)
    )  # last: a folder with it is whole


def rehearse(seed: int, suit: str, disturbed: Disturbances, played: Sequence[PlayedMotion]) -> None:
    """Every run of the played motions that `write_study` would record, kept nowhere. Raises BadMotion (`fell_over`) at
    the first in which the robot falls."""
    plans = log_plans(suit, {each.name: each.duration_s for each in played})
    effects = parse_hidden(specs_to_hide(None, suit), stream(seed, "hidden"))
    bench = _bench(seed, effects, suit, plans, disturbed, played)
    for plan in plans:
        if plan.motion in bench.played:
            run_log(bench, plan, stream(seed, plan.name))


def _bench(
    seed: int, effects: Sequence[Hidden], suit: str, plans: Sequence[LogPlan], disturbed: Disturbances,
    played: Sequence[PlayedMotion],
) -> Bench:  # fmt: skip
    planner = mujoco_model(a_priori_robot())
    suits = {kind: fitted_suit(kind, planner, stream(seed, "suit")) for kind in SUITS[suit]}  # the study's own first
    lab = drawn_lab(seed, disturbed, plans)
    return Bench(seed, draw_robot(stream(seed, "robot"), effects), suits, lab, {each.name: each for each in played})


def _bands_of(suits: Sequence[Suit]) -> dict[str, object]:
    """What truth.json says of the devices: the study's own as `bands`, every one by its name as `devices`."""
    if not suits:
        return {}
    return {"bands": bands_record(suits[0]), "devices": {suit.name: bands_record(suit) for suit in suits}}


def _study_file(
    seed: int,
    plans: Sequence[LogPlan],
    devices: Mapping[str, str],
    disturbed: Disturbances,
    started: Mapping[str, float],
    played: Sequence[PlayedMotion],
) -> dict[str, object]:
    """devices: file by kind of suit; a log names its own where it is not the study's. started: log -> [s]."""
    own = next(iter(devices), None)
    entries = []
    for plan in plans:
        entry: dict[str, object] = {"file": f"logs/{plan.name}.parquet", "role": plan.role}
        if plan.motion != "excitation":
            entry["motion"] = plan.motion
        if plan.suit is not None and plan.suit != own:
            entry["device"] = devices[plan.suit]
        if own:
            entry["started"] = round(started[plan.name], 3)
        entries.append(entry)
    name = f"SYNTHETIC {NAME}, seed {seed}{', as in a laboratory' if disturbed else ''}"
    head: dict[str, object] = {"version": 1, "name": name, "robot": "robot.yaml"}
    named = {"plans": [_plan_file(each) for each in played]} if played else {}
    return {**head, **({"device": devices[own]} if own else {}), **named, "logs": entries}


def _plan_file(played: PlayedMotion) -> str:
    return f"plans/{played.name}.csv"


def _write_yaml(path: Path, content: object) -> None:
    head = "# SYNTHETIC: written by `exogauge sample`, measured on no robot\n"
    path.write_text(
        head + yaml.safe_dump(content, sort_keys=False, width=120, default_flow_style=None), encoding="utf-8"
    )


_SUIT = (
    "The suit is drawn after what is published of the Smart Suit Lite: two bands A from the shoulders over the back",
    "to the thighs (197.8 N/m each, twice that in the modified suit), two short bands B round the sides of the waist.",
    "Bands pull and never push, and have no mass and no damping. Repetitions of a motion follow one plan; each log",
    "begins at another moment and has noise of its own. `ground_truth` marks a stiffness measured on the bare band.",
)


_LAB = (
    "It is as a laboratory would record it: runs of a motion differ, motors and friction warm up, sensors have gains,",
    "zeros and mountings of their own, via points are known by tape measure. truth.json has what of it is in here.",
)


def readme(seed: int, plans: Sequence[LogPlan], devices: Mapping[str, str], disturbed: Disturbances) -> str:
    """devices: file by kind of suit."""
    return "\n".join(
        [
            "SYNTHETIC DATA. Nothing in this folder was measured on a robot.",
            "",
            f"Made by `exogauge sample --seed {seed}` with MuJoCo: `{NAME}`, a humanoid of our own drawn from what is",
            "published of HRP-4 (1.51 m, 39 kg, 34 joints), stands on both feet under a position controller.",
            f"Logs at {LOG_RATE_HZ:.0f} Hz from a simulation at 1 kHz, raw: no filter anywhere.",
            *_log_lines(plans),
            *(f"  {file}  the {kind} suit" for kind, file in devices.items()),
            *(_SUIT if devices else ()),
            *(_LAB if disturbed else ()),
            "robot.urdf and robot.yaml hold the a-priori robot. The robot that made the logs differs from it by",
            "what the standard deviations in robot.yaml say, and may do what the a-priori model has no term for; it",
            "is written in truth.json, for scoring only.",
            *(["The torque that the suit really gave in each log is in truth/."] if devices else []),
            "",
        ]
    )  # fmt: skip


def _log_lines(plans: Sequence[LogPlan]) -> list[str]:
    """One line per log; repetitions together."""
    lines: dict[str, int] = {}
    for plan in plans:
        name = f"{plan.name.rpartition('_')[0]}_*" if plan.repeats else plan.name
        worn = f", {plan.suit} suit" if plan.suit else ""
        line = f"  logs/{name}.parquet  {plan.duration_s:.0f} s, {plan.motion}, {plan.role}{worn}"
        lines[line] = lines.get(line, 0) + 1
    return [f"{line}, {count} repetitions" if count > 1 else line for line, count in lines.items()]
