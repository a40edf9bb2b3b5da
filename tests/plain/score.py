"""What a plain study should say: `none`, every channel at its noise floor, parameters inside their intervals."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

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
    """Counts, the worst, and how many parameters lie inside 95 %."""
    ended = [each for each in found if "floors" in each]
    lines = [
        f"{sum(each.get('good', False) for each in found)} of {len(found)} are `none` at {FLOORS} floors or less; "
        f"{sum(each['floors'] <= FLOORS for each in ended)} stand there, "
        f"{sum(each['verdict'] == 'none' for each in ended)} are told `none`, {len(found) - len(ended)} did not end",
        "worst floors: " + ", ".join(f"{each['floors']:.2f}" for each in sorted(ended, key=lambda e: -e["floors"])[:5]),
    ]
    for name in PARAMETERS:
        inside = [abs(z) <= SIGMAS for each in ended for key, z in each["off"].items() if key.startswith(f"{name}[")]
        if inside:
            low, high = binom.interval(0.95, len(inside), 0.95)
            lines.append(
                f"{name}: {100.0 * sum(inside) / len(inside):.1f} % of {len(inside)} inside 95 % "
                f"(chance allows {100.0 * low / len(inside):.1f} to {100.0 * high / len(inside):.1f})"
            )
    return "\n".join(lines)
