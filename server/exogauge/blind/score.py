"""How often an evaluation was right: numbers over all cases that have a result, and the same as text."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from exogauge.blind.answers import read_answers
from exogauge.blind.interval import intervals
from exogauge.blind.verdict import Verdict, verdict
from exogauge.errors import BadInput, Fault

NOTHING = "none"


def score(out: Path) -> dict[str, Any]:
    """The score of a benchmark folder; BadInput where its seal is broken or nothing was evaluated."""
    answers = read_answers(out)["cases"]
    paths = {answer["case"]: out / "results" / f"{answer['case']}.json" for answer in answers}
    verdicts = [
        verdict(answer, json.loads(paths[answer["case"]].read_bytes()))
        for answer in answers
        if paths[answer["case"]].is_file()
    ]
    if not verdicts:
        advice = "First `exogauge blind run` it."
        raise BadInput(Fault("no case of this folder was evaluated", "no_results", advice, file=str(out)))
    return {**summary(verdicts), "missing": len(answers) - len(verdicts)}


def summary(verdicts: Sequence[Verdict]) -> dict[str, Any]:
    """`visible` and `all` are of cases in which one effect is hidden; what else each key means is in docs/blind.md."""
    found = _counts(verdicts)
    return {**found, "interval_95": intervals(found)}


def _counts(verdicts: Sequence[Verdict]) -> dict[str, Any]:
    single = [each for each in verdicts if len(each.truth) == 1]
    pairs = [each for each in verdicts if len(each.truth) > 1]
    clean = [each for each in verdicts if not each.truth]
    hidden = [each for each in verdicts if each.truth]
    named = [each for each in hidden if each.named]
    right = [each for each in hidden if each.right]
    return {
        "synthetic": True,
        "cases": len(verdicts),
        "failed": [each.case for each in verdicts if each.error],
        "visible": _named_right([each for each in single if each.visible]),
        "visible_without_clutter": _named_right([each for each in single if each.visible and not each.clutter]),
        "visible_with_clutter": _named_right([each for each in single if each.visible and each.clutter]),
        "all": _named_right(single),
        "without_clutter": _named_right([each for each in single if not each.clutter]),
        "with_clutter": _named_right([each for each in single if each.clutter]),
        "clean": {
            **_false_alarms(clean),
            "without_clutter": _false_alarms([each for each in clean if not each.clutter]),
            "with_clutter": _false_alarms([each for each in clean if each.clutter]),
        },
        "pairs": {
            "n": len(pairs),
            "both": _count(pairs, lambda each: each.all_found),
            "exact": _count(pairs, lambda each: each.exact),
            "one": _count(pairs, lambda each: not each.all_found and bool(set(each.truth) & set(each.named))),
        },
        "wrong_names": {
            "n": len(named),
            "cases": _count(named, lambda each: bool(each.wrong)),
            "beside_the_truth": _count(named, lambda each: bool(each.wrong) and each.first),
            "names": sum(len(each.wrong) for each in named),
        },
        "restored": {
            "n": len(right),
            "within_1_1": _count(right, lambda each: each.restored),
            "named": {"n": len(named), "within_1_1": _count(named, lambda each: each.restored)},
        },
        "by_robot": {
            robot: _named_right([each for each in single if each.robot == robot])
            for robot in sorted({each.robot for each in verdicts})
        },
        "by_effect": {
            effect: _named_right([each for each in single if each.truth[0][0] == effect])
            for effect in sorted({each.truth[0][0] for each in single})
        },
        "confusion": _confusion([*single, *clean]),
        "seconds": _spread([each.seconds for each in verdicts if not each.error]),
    }


def _named_right(cases: Sequence[Verdict]) -> dict[str, int]:
    return {
        "n": len(cases),
        "top1": _count(cases, lambda each: each.first),
        "top3": _count(cases, lambda each: each.among_three),
        "top1_or_also_possible": _count(cases, lambda each: each.first_or_also),
        "exact": _count(cases, lambda each: each.exact),
        "silent": _count(cases, lambda each: not each.named),
    }


def _false_alarms(cases: Sequence[Verdict]) -> dict[str, int]:
    return {"n": len(cases), "false_alarms": _count(cases, lambda each: bool(each.wrong))}


def _confusion(cases: Sequence[Verdict]) -> list[dict[str, Any]]:
    """How often the first finding of a case with `truth` was `named`, and how often of these at the right place."""
    pairs, placed = Counter[tuple[str, str]](), Counter[tuple[str, str]]()
    for each in cases:
        true_name, true_place = (each.truth[0][0], each.truth[0][1:]) if each.truth else (NOTHING, None)
        said, said_place = (each.named[0][0], each.named[0][1:]) if each.named else (NOTHING, None)
        pairs[true_name, said] += 1
        placed[true_name, said] += true_place == said_place
    return [
        {"truth": truth, "named": said, "n": n, "right_place": placed[truth, said]}
        for (truth, said), n in sorted(pairs.items(), key=lambda one: (one[0][0], -one[1], one[0][1]))
    ]


def _count(cases: Sequence[Verdict], claim: Callable[[Verdict], bool]) -> int:
    return sum(claim(each) for each in cases)


def _spread(values: Sequence[float]) -> dict[str, float | None]:
    if not values:
        return {"median": None, "mean": None, "most": None}
    return {
        "median": round(float(np.median(values)), 2),
        "mean": round(float(np.mean(values)), 2),
        "most": round(max(values), 2),
    }
