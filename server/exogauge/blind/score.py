"""How often an evaluation was right: numbers over all cases that have a result, and the same as text.

The score as tables for a terminal.

How far a count out of few cases can be believed.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import scipy

from exogauge.blind.answers import read_answers
from exogauge.blind.verdict import Verdict, verdict
from exogauge.errors import BadInput, Fault
from exogauge.terminal import text_table

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
    outside = [each for each in verdicts if each.outside]
    undecidable = [each for each in verdicts if each.undecidable]
    every, verdicts = verdicts, [each for each in verdicts if not (each.outside or each.undecidable)]
    single = [each for each in verdicts if len(each.truth) == 1]
    pairs = [each for each in verdicts if len(each.truth) > 1]
    clean = [each for each in verdicts if not each.truth]
    hidden = [each for each in verdicts if each.truth]
    named = [each for each in hidden if each.named]
    right = [each for each in hidden if each.right]
    return {
        "synthetic": True,
        "cases": len(every),
        "failed": [each.case for each in every if each.error],
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
        "outside": _unnamed(outside),
        "outside_visible": _unnamed([each for each in outside if each.visible]),
        "undecidable": _unnamed(undecidable),
        "by_robot": {
            robot: _named_right([each for each in single if each.robot == robot])
            for robot in sorted({each.robot for each in verdicts})
        },
        "by_effect": {
            effect: _named_right([each for each in single if each.truth[0][0] == effect])
            for effect in sorted({each.truth[0][0] for each in single})
        },
        "confusion": _confusion([*single, *clean, *outside, *undecidable]),
        "seconds": _spread([each.seconds for each in every if not each.error]),
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


def _unnamed(cases: Sequence[Verdict]) -> dict[str, int]:
    """Of cases in which any name is wrong: what was said. unexplained_there: and at the right place. named_and_left: a
    name, and beside it that something is left at the right place."""
    return {
        "n": len(cases),
        "unexplained": _count(cases, lambda each: each.said == "unexplained"),
        "unexplained_there": _count(cases, lambda each: each.said == "unexplained" and each.where_it_is),
        "undecided": _count(cases, lambda each: each.said == "undecided"),
        "silent": _count(cases, lambda each: each.said in ("", "none")),
        "named": _count(cases, lambda each: bool(each.named)),
        "named_and_left": _count(cases, lambda each: bool(each.named) and each.where_it_is),
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


def score_text(found: Mapping[str, Any]) -> str:
    parts = [
        _head(found),
        _right(found),
        _others(found),
        _without_name(found),
        _effects(found["by_effect"]),
        _confusion_table(found["confusion"]),
    ]
    return "\n\n".join(part for part in parts if part)


def _head(found: Mapping[str, Any]) -> str:
    seconds = found["seconds"]
    lines = [f"BLIND BENCHMARK, synthetic: {found['cases']} cases"]
    if seconds["median"] is not None:
        lines[0] += f", {seconds['median']:.1f} s each (median), {seconds['most']:.1f} s at most"
    if found.get("missing"):
        lines.append(f"{found['missing']} cases are not evaluated yet, and not counted")
    if found["failed"]:
        lines.append(f"failed, and counted as saying nothing: {', '.join(found['failed'])}")
    return "\n".join(lines)


def _right(found: Mapping[str, Any]) -> str:
    rows = {
        "visible (three noise floors)": found["visible"],
        "visible, no clutter": found["visible_without_clutter"],
        "visible, clutter": found["visible_with_clutter"],
        "all": found["all"],
        "all, no clutter": found["without_clutter"],
        "all, clutter": found["with_clutter"],
        **{f"all, {robot}": row for robot, row in found["by_robot"].items()},
    }
    columns = (
        "one effect hidden",
        "cases",
        "name and place first",
        "among three",
        "or also possible",
        "nothing else",
        "silent",
    )
    return text_table(columns, [[name, *_shares(row)] for name, row in rows.items()])


def _shares(row: Mapping[str, int]) -> list[Any]:
    keys = ("top1", "top3", "top1_or_also_possible", "exact", "silent")
    return [row["n"], *(_share(row[key], row["n"]) for key in keys)]


def _others(found: Mapping[str, Any]) -> str:
    clean, pairs, wrong, restored = (found[key] for key in ("clean", "pairs", "wrong_names", "restored"))
    named = restored["named"]
    plain, cluttered = clean["without_clutter"], clean["with_clutter"]
    rows = [
        ["false alarms where nothing is hidden", _of(clean["false_alarms"], clean["n"])],
        ["· without clutter", _of(plain["false_alarms"], plain["n"])],
        ["· with clutter", _of(cluttered["false_alarms"], cluttered["n"])],
        ["pairs: both named", _of(pairs["both"], pairs["n"])],
        ["pairs: both and nothing else", _of(pairs["exact"], pairs["n"])],
        ["where something was named: a wrong name among them", _of(wrong["cases"], wrong["n"])],
        ["· beside the right one", _of(wrong["beside_the_truth"], wrong["n"])],
        ["· held-out RMSE back within 1.1 noise floors", _of(named["within_1_1"], named["n"])],
        ["right: held-out RMSE back within 1.1 noise floors", _of(restored["within_1_1"], restored["n"])],
    ]
    return text_table(("", "of cases"), rows, widest=60)


def _effects(by_effect: Mapping[str, Mapping[str, int]]) -> str:
    columns = ("hidden", "cases", "name and place first", "among three", "or also possible", "nothing else", "silent")
    return text_table(columns, [[effect, *_shares(row)] for effect, row in by_effect.items()])


def _without_name(found: Mapping[str, Any]) -> str:
    rows = {
        "outside the catalogue": found["outside"],
        "outside, visible": found["outside_visible"],
        "not to be decided": found["undecidable"],
    }
    keys = ("unexplained", "unexplained_there", "undecided", "silent", "named", "named_and_left")
    columns = ("no name is right", "cases", "unexplained", "and where", "undecided", "silent", "named", "and left told")
    told = [[name, row["n"], *(_share(row[key], row["n"]) for key in keys)] for name, row in rows.items() if row["n"]]
    return text_table(columns, told) if told else ""


def _confusion_table(entries: list[Mapping[str, Any]]) -> str:
    rows = [[each["truth"], each["named"], each["n"], each["right_place"]] for each in entries]
    return text_table(("hidden", "named first", "cases", "right place"), rows)


def _share(count: int, n: int) -> str:
    """`93 % (88-96)`, the interval of 95 %."""
    if not n:
        return "–"
    low, high = interval_95(count, n)
    return f"{100.0 * count / n:.0f} % ({100.0 * low:.0f}-{100.0 * high:.0f})"


def _of(count: int, n: int) -> str:
    return f"{count} of {n} ({in_words(count, n)})" if n else "–"


CONFIDENCE = 0.95
NO_CASES = ("n", "names")  # keys of a score that count no cases of its n


def interval_95(count: int, n: int) -> tuple[float, float]:
    """The shares that `count` of `n` cases leave possible, by Clopper and Pearson: exact, never too narrow.

    Two-sided, 2.5 % to either side; where none or all were counted one side is certain, and the other one has all 5 %:
    0 of 50 is below 5.8 %.
    """
    if n == 0:
        return 0.0, 1.0
    beyond = (1.0 - CONFIDENCE) / (1.0 if count in (0, n) else 2.0)
    low = 0.0 if count == 0 else float(scipy.special.betaincinv(count, n - count + 1, beyond))
    high = 1.0 if count == n else float(scipy.special.betaincinv(count + 1, n - count, 1.0 - beyond))
    return low, high


def intervals(found: Mapping[str, Any]) -> dict[str, Any]:
    """The interval of every count in `found` that has its number of cases `n` beside it, under the same keys."""
    told: dict[str, Any] = {}
    for key, value in found.items():
        if isinstance(value, Mapping):
            if inner := intervals(value):
                told[key] = inner
        elif found.get("n") and isinstance(value, int) and key not in NO_CASES:
            told[key] = [round(bound, 4) for bound in interval_95(value, found["n"])]
    return told


def in_words(count: int, n: int) -> str:
    """`94 %, 83 to 99 %`; `0 %, below 5.8 %`."""
    low, high = (100.0 * bound for bound in interval_95(count, n))
    if count == 0:
        doubt = f"below {_per_cent(high)} %"
    elif count == n:
        doubt = f"above {low:.0f} %"
    else:
        doubt = f"{_per_cent(low)} to {_per_cent(high)} %"
    return f"{100.0 * count / n:.0f} %, {doubt}"


def _per_cent(value: float) -> str:
    """Two digits below ten, whole from there on, tenths where it is next to nothing: never a power of ten."""
    if value < 0.1:
        return f"{value:.1f}"
    return f"{value:.2g}" if value < 9.95 else f"{value:.0f}"
