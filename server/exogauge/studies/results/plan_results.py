"""Which logs are of which planned motion, as results.json and the report hold it."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Any, final

from exogauge.logs.followed import Followed, Match
from exogauge.studies.intake.plans import StudyPlan, named
from exogauge.studies.words.plan_words import followed_sentence

FOLLOWED = "followed_plan_*.csv"


@final
@dataclass(frozen=True)
class PlansOfStudy:
    """found: one of each log that is, or may be, of a plan. sliding: joints whose positions are in metres."""

    plans: Sequence[StudyPlan] = ()
    found: Sequence[Followed] = ()
    sliding: Collection[str] = ()

    def told(self) -> list[tuple[StudyPlan, str, list[Followed]]]:
        """Those that study.yaml names, and of the service's those that a log is, or may be, of."""
        whole = []
        for k, (plan, name) in enumerate(zip(self.plans, named(self.plans), strict=True)):
            logs = [each for each in self.found if k == each.match.plan or k in each.rivals]
            if logs or plan.file is not None:
                whole.append((plan, name, logs))
        return whole


def plan_entries(plans: PlansOfStudy) -> list[dict[str, Any]]:
    """`plans[]` of results.json."""
    names = named(plans.plans)
    entries = []
    for plan, name, logs in plans.told():
        number = names.index(name)
        own = [_log_entry(each, number, names, plans.sliding) for each in logs]
        entries.append({
            "plan": name, "file": plan.file, "plan_id": plan.plan_id, "sha256": plan.sha256,
            "seconds": plan.series.seconds, "logs": own, "sentence": followed_sentence(name, own),
        })  # fmt: skip
    return entries


def followed_files(plans: PlansOfStudy) -> list[tuple[str, bytes]]:
    """`followed_plan_1` … and the tables of the plans that a log surely follows: by their content the service knows
    which plan of its own they are."""
    sure = [plan for plan, _, logs in plans.told() if any(each.sure for each in logs)]
    return [(f"followed_plan_{number}", plan.source) for number, plan in enumerate(sure, 1)]


def _log_entry(found: Followed, number: int, names: Sequence[str], sliding: Collection[str]) -> dict[str, Any]:
    match, nearest = found.match, found.match.plan == number
    others = [names[k] for k in (match.plan, *found.rivals) if k != number]
    return {
        "log": found.log, "state": "follows" if found.sure else "undecided",
        "begins_s": match.begins_s if nearest else None, "share": match.share if nearest else None,
        "covered": match.covered if nearest else None, "or_plans": others,
        "joints": _joints(match, sliding) if nearest else [],
    }  # fmt: skip


def _joints(match: Match, sliding: Collection[str]) -> list[dict[str, Any]]:
    return [
        {"joint": each.joint, "unit": "m" if each.joint in sliding else "rad", "rms": each.rms, "most": each.most,
         "at_s": each.at_s, "later_s": each.later_s}
        for each in sorted(match.strays, key=lambda each: -each.most)
    ]  # fmt: skip
