"""What a plain study should say: `none`, every channel at its noise floor, parameters inside their intervals."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.stats import binom

FLOORS = 1.05  # noise floors that a channel may stand at in steady motion
PARAMETERS = ("k_T", "k_d", "tau_c")
SIGMAS = 1.96


def facts(results: dict[str, Any], truth: dict[str, dict[str, float]]) -> dict[str, Any]:
    """Of one study: verdict, what is named, the worst ratio of error to floor among joints in steady motion, and how
    far each parameter is from the truth, in stated standard deviations."""
    identification, discrepancy = results["identification"], results["discrepancy"] or {}
    ratios = {
        f"{row['channel']}@{row['log']}": row["rmse_moving"] / row["noise_floor"]
        for row in identification["validation"]
        if row["held_out"] and row["rmse_moving"] is not None
    }
    worst = max(ratios, key=lambda key: ratios[key], default="")
    moved = {row["joint"] for row in results["scope"]["identified"]} - set(results["scope"].get("not_moved", []))
    off = {
        f"{name}[{row['joint']}]": (row[name]["value"] - truth[name][row["joint"]]) / row[name]["std"]
        for row in identification["joints"]
        for name in PARAMETERS
        if row["joint"] in moved and row["joint"] in truth[name] and row[name]["std"] > 0.0
    }
    verdict = discrepancy.get("verdict", "skipped")
    floors = ratios.get(worst, float("nan"))
    return {
        "verdict": verdict,
        "named": [f"{finding['effect']}@{finding['where']}" for finding in discrepancy.get("findings", [])],
        "floors": floors,
        "worst": worst,
        "channels": len(ratios),
        "off": off,
        "cutoff_hz": identification["cutoff_hz"],
        "strength": identification["prior_strength"],
        "good": verdict == "none" and floors <= FLOORS,
    }


def summary(found: Sequence[dict[str, Any]]) -> str:
    """Verdicts and the worst, soft friction apart; then how many parameters lie inside 95 %, and of which kind."""
    sharp = [each for each in found if "soft" not in _kinds(each["name"])]
    soft = [each for each in found if each not in sharp]
    lines = [_verdicts("at once", sharp)] if sharp else []
    lines += [_verdicts("soft", soft)] if soft else []
    for title, group in (("at once", sharp), ("soft", soft)):
        lines += [f"{title}: {line}" for name in PARAMETERS if (line := _coverage(name, group))]
    for kind in sorted({kind for each in sharp for kind in _kinds(each["name"])}):
        group = [each for each in sharp if kind in _kinds(each["name"])]
        lines += [f"  {kind:16s} {line}" for name in PARAMETERS if (line := _coverage(name, group))]
    return "\n".join(lines)


def _kinds(name: str) -> list[str]:
    """Robot, style, rate and actuation, and whether soft: `0011-UR5-sines-250Hz-current-soft` without its number."""
    return name.split("-")[1:]


def _verdicts(title: str, found: Sequence[dict[str, Any]]) -> str:
    ended = [each for each in found if "floors" in each]
    worst = ", ".join(f"{each['floors']:.3f}" for each in sorted(ended, key=lambda e: -e["floors"])[:5])
    return (
        f"{title}: {sum(each.get('good', False) for each in found)} of {len(found)} are `none` at {FLOORS} floors or "
        f"less; {sum(each['floors'] <= FLOORS for each in ended)} stand there, "
        f"{sum(each['verdict'] == 'none' for each in ended)} are told `none`, {len(found) - len(ended)} did not end; "
        f"worst floors: {worst}"
    )


def _coverage(name: str, found: Sequence[dict[str, Any]]) -> str:
    """Of one parameter; nothing where no study has it. z: distance from the truth in stated standard deviations, of
    which the root mean square is 1 where the stated ones hold."""
    z = np.array([z for each in found for key, z in each.get("off", {}).items() if key.startswith(f"{name}[")])
    if not len(z):
        return ""
    low, high = binom.interval(0.95, len(z), 0.95)
    return (
        f"{name:5s} {100.0 * np.mean(np.abs(z) <= SIGMAS):5.1f} % of {len(z)} inside 95 % (chance allows "
        f"{100.0 * low / len(z):.1f} to {100.0 * high / len(z):.1f}), z rms {np.sqrt(np.mean(z**2)):.2f}, "
        f"mean {np.mean(z):+.2f}, farthest {np.abs(z).max():.1f}"
    )
