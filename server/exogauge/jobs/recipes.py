"""What kinds of jobs there are: what is computed, and for how long at most.

The worker lays the study's pinned files out in a folder, the compute child calls
`compute(folder, out, progress, settings)`, and the worker keeps every file that appeared below `out`.
The computation knows neither database nor blob store.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, final

from pydantic import BaseModel, ValidationError

from exogauge.errors import BadInput, Fault
from exogauge.studies.contract import SettingsEntry


@final
@dataclass(frozen=True)
class Recipe:
    """compute: `package.module:function`. settings: what a request may set; None takes anything."""

    kind: str
    compute: str
    timeout_s: float
    settings: type[BaseModel] | None = None

    def checked(self, settings: Mapping[str, Any]) -> dict[str, Any]:
        """The settings as they are kept, or BadInput that names each wrong one."""
        if self.settings is None:
            return dict(settings)
        try:
            return self.settings.model_validate(settings).model_dump(mode="json", exclude_none=True)
        except ValidationError as error:
            raise BadInput([as_fault(entry["loc"], entry["msg"], entry["type"]) for entry in error.errors()]) from error


def as_fault(place: tuple[int | str, ...], text: str, rule: str) -> Fault:
    return Fault(text, rule, column=".".join(["settings", *map(str, place)]))


EVALUATE = Recipe("evaluate", "exogauge.studies.evaluate:evaluate", timeout_s=6 * 3600.0, settings=SettingsEntry)
RECIPES: dict[str, Recipe] = {EVALUATE.kind: EVALUATE}


def recipe_for(kind: str) -> Recipe:
    """The recipe of a kind, or BadInput that lists the kinds there are."""
    recipe = RECIPES.get(kind)
    if recipe is None:
        advice = f"Known: {', '.join(sorted(RECIPES))}."
        raise BadInput(Fault("there is no such kind of job", "unknown_kind", advice, column="kind", value=kind))
    return recipe
