"""What kinds of jobs there are: what is computed, and for how long at most.

The worker lays the study's pinned files out in a folder, the compute child calls
`compute(folder, out, progress, settings)`, and the worker keeps every file that appeared below `out`.
The computation knows neither database nor blob store.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from exogauge.errors import BadInput, Fault


@final
@dataclass(frozen=True)
class Recipe:
    """compute: `package.module:function`."""

    kind: str
    compute: str
    timeout_s: float


RECIPES: dict[str, Recipe] = {
    "evaluate": Recipe("evaluate", compute="exogauge.studies.evaluate:evaluate", timeout_s=6 * 3600.0)
}


def recipe_for(kind: str) -> Recipe:
    """The recipe of a kind, or BadInput that lists the kinds there are."""
    recipe = RECIPES.get(kind)
    if recipe is None:
        known = ", ".join(sorted(RECIPES))
        raise BadInput(
            Fault("there is no such kind of job", "unknown_kind", f"Known: {known}.", None, None, "kind", kind)
        )
    return recipe
