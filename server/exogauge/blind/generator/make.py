"""All cases of a benchmark, in as many processes as asked for, and their sealed answers.

Of a robot on two feet, the sample's humanoid is simulated with MuJoCo, with what its foot sensors have wrong: no
device, no laboratory's disturbances, so that what is hidden is all that is wrong.
"""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict, replace
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from exogauge.blas_threads import limit_children
from exogauge.blind.answers import write_answers
from exogauge.blind.generator.case import write_case
from exogauge.blind.generator.foot_faults import KINDS, OUTSIDE, UNDECIDABLE, FootFault, drawn, how_large
from exogauge.blind.generator.plan import ROBOTS, STANDING, can_be_asked_for, case_name
from exogauge.errors import BadInput, Fault
from exogauge.synthetic.disturbances import IDEAL
from exogauge.synthetic.hidden import Hidden, parse_hidden
from exogauge.synthetic.inertia import of_shape
from exogauge.synthetic.lab import drawn_lab
from exogauge.synthetic.log_plans import LogPlan
from exogauge.synthetic.log_runs import Bench, run_log, write_log
from exogauge.synthetic.random_streams import stream
from exogauge.synthetic.robot_facts import LINKS, NAME
from exogauge.synthetic.sensors import ENCODER_STEP
from exogauge.synthetic.simulation import Recording
from exogauge.synthetic.tolerances import uncertainty
from exogauge.synthetic.true_robot import draw_robot, moving_bodies
from exogauge.synthetic.urdf import robot_file, robot_urdf

What = tuple[int, str, tuple[str, ...]]  # seed, robots, effects

_README = """\
SYNTHETIC DATA. Nothing in this folder was measured on a robot.

case_*/          studies of robots of our own in which effects may be hidden (`exogauge run case_0001`)
answers.json.gz  what is hidden in each; no evaluating code opens it
seal.txt         SHA-256 of the answers as JSON text
results/         what an evaluation said of each case, after `exogauge blind run`
"""


def make(
    out: Path,
    seed: int,
    cases: int,
    progress: Callable[[float, str], None] | None = None,
    processes: int = 1,
    robots: str = "both",
    effects: Sequence[str] = (),
) -> None:
    """Write `cases` studies, the answers and their seal into `out`, which must be new or empty.

    The same seed gives the same bytes, whatever `processes`; case n is the same however many there are. robots: which
    ones the cases are made of, a key of `plan.ROBOTS`, or `plan.STANDING`. effects: hide one of these in
    every case; none: all sorts, two or nothing now and then.
    """
    if seed < 0 or cases < 1:
        column, value = ("seed", seed) if seed < 0 else ("cases", cases)
        detail = "the seed must be 0 or more, and the number of cases 1 or more"
        raise BadInput(Fault(detail, "blind_numbers", column=column, value=str(value)))
    if robots not in (*ROBOTS, STANDING):
        raise _unknown("no cases are made of this robot", "robot", robots, (*ROBOTS, STANDING))
    for each in effects:
        if each not in can_be_asked_for(robots):
            raise _unknown("this is not hidden in cases of these robots", "effects", each, can_be_asked_for(robots))
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        advice = "Give a new folder, so that old results never meet new answers."
        raise BadInput(Fault(f"{out} is not an empty folder", "folder_not_empty", advice))
    out.parent.mkdir(parents=True, exist_ok=True)
    unfinished = Path(tempfile.mkdtemp(prefix=f".{out.name}-", dir=out.parent))
    try:
        (unfinished / "README.txt").write_text(_README, encoding="utf-8")
        tell = progress or (lambda share, what: None)
        answers = _make_all(unfinished, (seed, robots, tuple(effects)), cases, tell, min(processes, cases))
        write_answers(unfinished, seed, answers)
        unfinished.chmod(0o755)
        os.replace(unfinished, out)
    finally:
        shutil.rmtree(unfinished, ignore_errors=True)


def _unknown(detail: str, column: str, value: str, known: Iterable[str]) -> BadInput:
    return BadInput(Fault(detail, f"unknown_{column}", f"Known: {', '.join(known)}", column=column, value=value))


def _make_all(
    out: Path, what: What, cases: int, tell: Callable[[float, str], None], processes: int
) -> list[dict[str, Any]]:
    if processes < 2:
        answers = []
        for number in range(1, cases + 1):
            answers.append(_make(out, what, number))
            tell(number / cases, f"{number} of {cases} cases")
        return answers
    done: dict[int, dict[str, Any]] = {}
    limit_children()
    with ProcessPoolExecutor(processes, get_context("spawn")) as pool:
        running = {pool.submit(_make, out, what, number): number for number in range(1, cases + 1)}
        try:
            for each in as_completed(running):
                done[running[each]] = each.result()
                tell(len(done) / cases, f"{len(done)} of {cases} cases")
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise
    return [done[number] for number in sorted(done)]


def _make(out: Path, what: What, number: int) -> dict[str, Any]:
    seed, robots, effects = what
    name = case_name(number)
    if robots == STANDING:
        from exogauge.blind.generator.make import write_standing_case  # needs MuJoCo

        return write_standing_case(out / name, name, seed, number, effects)
    return write_case(out / name, seed, number, robots, effects)


LOGS = (
    *(LogPlan(f"id_{n + 1}", "identification", "excitation", 25.0) for n in range(3)),
    LogPlan("val_1", "validation", "excitation", 25.0),
)
VISIBLE = 3.0  # noise floors, from which docs/blind.md calls a hidden effect visible
_TRIES = 40  # draws of a place and a size, until one is visible


def write_standing_case(
    folder: Path, name: str, seed: int, number: int, effects: tuple[str, ...] = ()
) -> dict[str, Any]:
    """As `case.write_case`; effects: some of `KINDS`, in turn."""
    asked = effects or KINDS
    kind = asked[(number - 1) % len(asked)]
    rng = stream(seed, f"standing {number}")
    inside = _in_the_robot(kind, rng)
    robot = draw_robot(stream(seed, f"standing robot {number}"), inside)
    own = int(stream(seed, f"standing motion {number}").integers(2**31))
    bench = Bench(own, robot, {}, drawn_lab(own, IDEAL, LOGS))
    runs = [run_log(bench, plan, stream(own, plan.name)) for plan in LOGS]
    fault, ratio, channel = _fault(kind, rng, runs)
    (folder / "logs").mkdir(parents=True, exist_ok=True)
    for n, (plan, run) in enumerate(zip(LOGS, runs, strict=True)):
        read = replace(run, wrench=fault.read(run.wrench, n)) if fault else run
        write_log(folder / "logs" / f"{plan.name}.parquet", read, stream(own, f"noise {plan.name}"), seed)
    (folder / "robot.urdf").write_text(robot_urdf(), encoding="utf-8")
    _write_yaml(folder / "robot.yaml", robot_file(ENCODER_STEP, uncertainty("robot", IDEAL)))
    logs = [{"file": f"logs/{plan.name}.parquet", "role": plan.role} for plan in LOGS]
    study = {"version": 1, "name": f"SYNTHETIC {NAME}, blind {name}", "robot": "robot.yaml", "logs": logs,
             "steps": ["identify", "discrepancy"]}  # fmt: skip
    _write_yaml(folder / "study.yaml", study)
    return {
        "case": name, "robot": NAME, "actuation": "current", "clutter": [], "bands": {},
        "effects": _answer(fault, inside, ratio, channel), "masses": _masses(robot.masses), "rigid": _rigid(),
    }  # fmt: skip


def _in_the_robot(kind: str, rng: np.random.Generator) -> list[Hidden]:
    if kind == "stribeck":
        return parse_hidden([f"stribeck@{rng.choice(['torso_pitch', 'l_knee_pitch', 'r_shoulder_pitch'])}"], rng)
    if kind == "payload":
        return parse_hidden([f"payload@{rng.choice(['l_hand', 'r_hand'])}"], rng)
    return []


def _fault(kind: str, rng: np.random.Generator, runs: list[Recording]) -> tuple[FootFault | None, float, str]:
    """The first that was drawn and is visible, else the largest; its ratio, and the channel that shows it."""
    found: tuple[FootFault | None, float, str] = (None, 0.0, "")
    for _ in range(_TRIES):
        fault = drawn(kind, rng, len(LOGS))
        if fault is None:
            return found
        found = max(found, (fault, *how_large(fault, [run.wrench for run in runs])), key=lambda each: each[1])
        if found[1] >= VISIBLE or kind in UNDECIDABLE:
            break
    return found if found[0] is not None else (fault, 0.0, "")


def _answer(fault: FootFault | None, inside: list[Hidden], ratio: float, channel: str) -> list[dict[str, Any]]:
    told = [
        {"effect": each.effect, "where": each.where, "parameters": dict(each.parameters), "visible": True}
        for each in inside
    ]
    if fault is not None:
        values = {key: value for key, value in asdict(fault).items() if key != "name"}  # type: ignore[call-overload]
        one = {"effect": fault.name, "where": fault.where, "parameters": values, "ratio": ratio, "channel": channel,
               "visible": ratio >= VISIBLE}  # fmt: skip
        told.append(one | ({"outside": True} if fault.name in OUTSIDE else {}))
        told[-1] |= {"undecidable": True} if fault.name in UNDECIDABLE else {}
    return told


def _masses(masses: Mapping[str, Any]) -> dict[str, float]:
    """Of all, true and stated [kg]."""
    true = sum(each.mass for each in moving_bodies(masses).values())
    stated = sum(each.mass for each in moving_bodies({x.name: of_shape(x) for x in LINKS if x.mass > 0.0}).values())
    return {"true": float(true), "stated": float(stated)}


def _rigid() -> list[list[str]]:
    """Links that are fixed to each other, the moving one first."""
    groups: dict[str, list[str]] = {}
    by_name = {link.name: link for link in LINKS}
    for link in LINKS:
        top = link
        while top.joint is None and top.parent is not None:
            top = by_name[top.parent]
        groups.setdefault(top.name, []).append(link.name)
    return [names for names in groups.values() if len(names) > 1]


def _write_yaml(path: Path, content: object) -> None:
    head = "# SYNTHETIC: written by `exogauge blind make`, measured on no robot\n"
    path.write_text(
        head + yaml.safe_dump(content, sort_keys=False, width=120, default_flow_style=None), encoding="utf-8"
    )
