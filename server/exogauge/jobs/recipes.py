"""What kinds of jobs there are: what is computed, and for how long at most.

The worker lays the pinned files of what the job is of out in a folder, the compute child calls
`compute(folder, out, progress, settings)`, and the worker keeps every file that appeared below `out`.
The computation knows neither database nor blob store.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, final

from pydantic import BaseModel, ConfigDict, ValidationError

from exogauge.errors import BadInput, BadStudy, Fault
from exogauge.payload.contract import SettingsEntry as PayloadSettings
from exogauge.studies.device_pages.change_entries import WhatIfSettings
from exogauge.studies.intake.contract import SettingsEntry

Owner = Literal["study", "payload", "motion", "plan"]


@final
@dataclass(frozen=True)
class Recipe:
    """compute: `package.module:function`. settings: what a request may set; None takes anything.

    lacking: what a study's stored summary says to be missing for this kind; None asks for nothing.
    result: the file that must be there when it is done, and that is the job's result. of: what it is a job of.
    """

    kind: str
    compute: str
    timeout_s: float
    settings: type[BaseModel] | None = None
    lacking: Callable[[Mapping[str, Any]], Sequence[Fault]] | None = None
    result: str = "results.json"
    of: Owner = "study"

    def checked(self, settings: Mapping[str, Any]) -> dict[str, Any]:
        """The settings as they are kept, or BadInput that names each wrong one."""
        if self.settings is None:
            return dict(settings)
        try:
            asked = self.settings.model_validate(settings)
            return asked.model_dump(mode="json", exclude_none=True, exclude_unset=True)
        except ValidationError as error:
            raise BadInput([as_fault(entry["loc"], entry["msg"], entry["type"]) for entry in error.errors()]) from error

    def refuse_unsuited(self, summary: Mapping[str, Any]) -> None:
        """BadStudy with what is lacking, where the summary tells; what it does not tell, the computation finds."""
        faults = self.lacking(summary) if self.lacking else ()
        if faults:
            raise BadStudy(faults)


def as_fault(place: tuple[int | str, ...], text: str, rule: str) -> Fault:
    return Fault(text, rule, column=".".join(["settings", *map(str, place)]))


def a_worn_log(summary: Mapping[str, Any]) -> list[Fault]:
    """What says that nothing was worn; a worn log without a device that it names is refused with its study."""
    logs = summary.get("logs")
    if not logs or any(log.get("role") == "with_device" for log in logs):
        return []
    found = ", ".join(dict.fromkeys(str(log.get("role")) for log in logs))
    advice = "Hand in a study with a device and a log recorded with it on; `evaluate` makes the steps without."
    detail = "no log of this study was recorded with a device on"
    return [Fault(detail, "no_worn_log", advice, "study.yaml", column="logs", value=found)]


def a_log_that_identifies(summary: Mapping[str, Any]) -> list[Fault]:
    found = dict.fromkeys(str(log.get("role")) for log in summary.get("logs", ()))
    if {"postures", "excitation"} & set(found):
        return []
    advice = "Give a log the role `postures` (the arm stops here and there) or `excitation`."
    told = ", ".join(found) or "none"
    return [Fault("no log identifies the payload", "no_role", advice, "payload.yaml", column="logs", value=told)]


def a_plan(summary: Mapping[str, Any]) -> list[Fault]:
    if summary.get("plan"):
        return []
    advice = "Add `plan` with joints, home, …"
    return [Fault("nothing says what may be planned", "no_plan", advice, "payload.yaml", column="plan")]


def a_body(summary: Mapping[str, Any]) -> list[Fault]:
    if summary.get("holds") in (None, "markers", "skeleton"):
        return []
    advice = "Hand in the markers or the skeleton."
    return [Fault("no body can be fitted to joint angles", "no_markers", advice, "motion.yaml", column="file")]


def a_plan_to(kind: str) -> Callable[[Mapping[str, Any]], Sequence[Fault]]:
    def lacking(summary: Mapping[str, Any]) -> list[Fault]:
        if summary.get("kind") == kind:
            return []
        asked = str(summary.get("kind"))
        return [Fault(f"the plan is to {asked}", "wrong_kind", f"Ask for {asked!r}.", "plan.yaml", None, "kind", kind)]

    return lacking


@final
class Nothing(BaseModel):
    """No settings: what is asked stands in the bundle."""

    model_config = ConfigDict(extra="forbid")


@final
class PlanSettings(BaseModel):
    """What is planned."""

    model_config = ConfigDict(extra="forbid")
    what: Literal["postures", "excitation"]


SIX_HOURS_S, EVALUATING = 6 * 3600.0, "exogauge.studies.evaluate"
EVALUATE = Recipe("evaluate", f"{EVALUATING}:evaluate", SIX_HOURS_S, SettingsEntry)
SUPPORT = Recipe("support", f"{EVALUATING}:evaluate_support", SIX_HOURS_S, SettingsEntry, a_worn_log)
STIFFNESS = Recipe("stiffness", f"{EVALUATING}:evaluate_stiffness", SIX_HOURS_S, SettingsEntry, a_worn_log)
WHAT_IF = Recipe(
    "whatif", "exogauge.studies.device_pages.what_if:compute", 3600.0, WhatIfSettings, result="what_if.json"
)
PAYLOAD = Recipe(
    "payload", "exogauge.payload.compute:identify", SIX_HOURS_S, PayloadSettings, a_log_that_identifies, of="payload"
)
PAYLOAD_PLAN = Recipe(
    "payload_plan", "exogauge.payload.compute:plan", SIX_HOURS_S, PlanSettings, a_plan, "plan.json", "payload"
)
MOVING = "exogauge.motion.compute"
HUMAN_FIT = Recipe("human_fit", f"{MOVING}:fit", 3600.0, Nothing, a_body, "fit.json", "motion")
RETARGET = Recipe("retarget", f"{MOVING}:retarget", SIX_HOURS_S, Nothing, a_plan_to("retarget"), "plan.json", "plan")
EXCITE = Recipe("excite", f"{MOVING}:excite", SIX_HOURS_S, Nothing, a_plan_to("excite"), "plan.json", "plan")
KINDS = (EVALUATE, SUPPORT, STIFFNESS, WHAT_IF, PAYLOAD, PAYLOAD_PLAN, HUMAN_FIT, RETARGET, EXCITE)
RECIPES: dict[str, Recipe] = {recipe.kind: recipe for recipe in KINDS}


def recipe_for(kind: str) -> Recipe:
    """The recipe of a kind, or BadInput that lists the kinds there are."""
    recipe = RECIPES.get(kind)
    if recipe is None:
        advice = f"Known: {', '.join(sorted(RECIPES))}."
        raise BadInput(Fault("there is no such kind of job", "unknown_kind", advice, column="kind", value=kind))
    return recipe
