"""The score as tables for a terminal."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from exogauge.blind.interval import in_words, interval_95
from exogauge.terminal import text_table


def score_text(found: Mapping[str, Any]) -> str:
    parts = [_head(found), _right(found), _others(found), _effects(found["by_effect"]), _confusion(found["confusion"])]
    return "\n\n".join(parts)


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


def _confusion(entries: list[Mapping[str, Any]]) -> str:
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
