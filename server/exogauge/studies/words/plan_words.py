"""What is said of a planned motion and the logs that are of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from exogauge.studies.words.rounding import significant


def followed_sentence(plan: str, logs: Sequence[Mapping[str, Any]]) -> str:
    """logs: as in results.json."""
    if not logs:
        return f"No log is of {plan}."
    sure = [log for log in logs if log["state"] == "follows"]
    said = []
    if sure:
        log, far = max(((log, log["joints"][0]) for log in sure), key=lambda pair: float(pair[1]["most"]))
        count = f"{len(sure)} logs follow {plan}" if len(sure) > 1 else f"{log['log']} follows {plan}"
        said.append(
            f"{count}; farthest from it is {far['joint']}, by {significant(far['most'], 2)} {far['unit']} at "
            f"{far['at_s']:.2f} s of {log['log']}."
        )
    for log in logs:
        if log["state"] == "undecided" and log["or_plans"]:
            said.append(f"{log['log']} may be of {plan} or of {', '.join(log['or_plans'])}: they are too much alike.")
        elif log["state"] == "undecided":
            share = 100.0 * log["share"]
            said.append(f"{log['log']} may be of {plan}, but strays by {share:.0f} % of its motion: undecided.")
    return " ".join(said)
