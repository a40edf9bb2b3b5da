"""What motions that are planned for findings would tell, against a plain sweep; what is named once they are recorded.

`python -m tests.bench.tell_apart SEED CASES [EFFECT,EFFECT …]`: cases of the blind benchmark's arm. `rate`: evidence of
10 s of the motion for the rival that it tells worst, of those that it tells. `sweep`: of the best single joint that is
swept; `offered`: of the motion that the finding asks for. The generator plays it twice, one held out, and the case is
evaluated once more.
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before numpy is imported

import json
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from exogauge.blind.generator.case import write_case
from exogauge.blind.generator.plan import case_name
from exogauge.blind.generator.play import play
from exogauge.blind.verdict import Verdict, verdict
from exogauge.experiment import design
from exogauge.experiment.design import Known, Outcome, Weighing, can_be_planned, reach_in
from exogauge.experiment.motion_choices import Choice
from exogauge.experiment.workspace_limits import room
from exogauge.logs.model import Log
from exogauge.robots.moving.robot import MotionRobot
from exogauge.search.ambiguity import Undecided
from exogauge.studies.evaluate import evaluate
from exogauge.terminal import text_table

ARM, KEPT = "arm6", ("id_1", "val_1")


def report(seed: int, cases: int, effects: tuple[str, ...]) -> None:
    rows = []
    for number in range(1, cases + 1):
        with tempfile.TemporaryDirectory() as folder:
            row = _case(Path(folder), seed, number, effects)
        if row is not None:
            rows.append(row)
            print(*row, sep=" | ", flush=True)
    print(text_table(("case", "hidden", "rivals", "sweep", "offered", "times", "before", "after"), rows))
    ratios = [float(row[5]) for row in rows]
    if ratios:
        most = sum(ratio >= 1.5 for ratio in ratios)
        print(f"least {min(ratios):.2f} times the sweep, 1.5 times in {most} of {len(ratios)}")


def _case(folder: Path, seed: int, number: int, effects: tuple[str, ...]) -> list[str] | None:
    """None where no motion was asked for."""
    asked: list[tuple[Undecided, Sequence[Log], MotionRobot | None, Outcome]] = []
    kept = design.tell_apart

    def listening(doubt: Undecided, logs: Sequence[Log], moving: MotionRobot | None = None) -> Outcome | None:
        outcome = kept(doubt, logs, moving)
        if outcome is not None and outcome.motions:
            asked.append((doubt, logs, moving, outcome))
        return outcome

    study = folder / "case"
    answer = write_case(study, seed, number, ARM, effects)
    _kept_of(study)
    design.tell_apart = listening
    try:
        before = _said(study, folder / "before", answer)
    finally:
        design.tell_apart = kept
    if not asked:
        print(case_name(number), [each["effect"] for each in answer["effects"]], "asks for no motion", flush=True)
        return None
    tables, sweeps, offers, rivals = [], [], [], 0
    for doubt, logs, moving, outcome in asked:
        sweep, offered = rates(doubt, logs, moving, outcome)
        sweeps.append(sweep)
        offers.append(offered)
        rivals += len(outcome.pairs)
        tables += [(each.time, each.q, each.repeats) for each in outcome.motions]
    play(study, seed, number, tables, ARM, effects)
    after = _said(study, folder / "after", answer)
    ratio = min(offered / sweep if sweep > 0.0 else np.inf for sweep, offered in zip(sweeps, offers, strict=True))
    hidden = ", ".join(each["effect"] for each in answer["effects"]) or "nothing"
    told = (f"{min(each):.1f}" for each in (sweeps, offers))
    return [case_name(number), hidden, str(rivals), *told, f"{ratio:.2f}", _right(before), _right(after)]


def _kept_of(study: Path) -> None:
    """One log to fit and one to judge by, so that findings are less sure."""
    file = study / "study.yaml"
    content = yaml.safe_load(file.read_text(encoding="utf-8"))
    content["logs"] = [each for each in content["logs"] if Path(each["file"]).stem in KEPT]
    file.write_text(yaml.safe_dump(content, sort_keys=False), encoding="utf-8")


def rates(doubt: Undecided, logs: Sequence[Log], moving: MotionRobot | None, outcome: Outcome) -> tuple[float, float]:
    """Evidence per 10 s, of the rival that is told worst: of the best plain sweep, of what is offered first."""
    assert can_be_planned(doubt)
    here, known = room(doubt.model, logs), Known.of(doubt)
    reach, rules = None if moving is None else reach_in(moving, doubt.model, here), doubt.model.criteria.planning

    def keeps(sweep: Choice) -> bool:
        hz = rules.handed_hz
        return reach is None or reach.keeps(sweep.positions(here.posture, hz), hz, rules.checked_hz)

    every = Weighing.of(known, here, reach).tries()
    plain = [each for each in every
             if isinstance(each.choice, Choice) and each.choice.companion is None and keeps(each.choice)]  # fmt: skip
    first = outcome.motions[0].pairs
    told = [k for k, pair in enumerate(outcome.pairs, 1) if pair in first]
    sweep = max((10.0 * min(each.gain[k] for k in told) / each.seconds for each in plain), default=0.0)
    return sweep, min(pair.rate for pair in first)


def _said(study: Path, out: Path, answer: dict[str, Any]) -> Verdict:
    out.mkdir()
    evaluate(study / "study.yaml", out, lambda *_: None)
    found = json.loads((out / "results.json").read_bytes())
    return verdict(answer, {"case": answer["case"], "error": None, "seconds": 0.0, "processor_seconds": 0.0,
                            "discrepancy": found.get("discrepancy"), "why": None})  # fmt: skip


def _right(found: Verdict) -> str:
    if found.first:
        return "right" if not found.also else f"right, or {len(found.also)} others"
    return "among what it may be" if found.first_or_also else "wrong"


if __name__ == "__main__":
    report(int(sys.argv[1]), int(sys.argv[2]), tuple(sys.argv[3].split(",")) if len(sys.argv) > 3 else ())
