"""All effects there are: every module of this package that offers an `EFFECT`."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Mapping, Sequence
from functools import cache
from types import MappingProxyType

import exogauge.effects as package
from exogauge.effects.effect import JointEffect
from exogauge.errors import BadInput, Fault


@cache
def all_effects() -> Mapping[str, JointEffect]:
    """Identifier -> effect, found by looking into the package: adding one file is all it takes."""
    modules = (importlib.import_module(f"{package.__name__}.{m.name}") for m in pkgutil.iter_modules(package.__path__))
    effects: list[JointEffect] = [module.EFFECT for module in modules if hasattr(module, "EFFECT")]
    return MappingProxyType({effect.name: effect for effect in effects})


def choose(names: Sequence[str]) -> tuple[JointEffect, ...]:
    """The named effects, in the order asked for."""
    known = all_effects()
    unknown = [name for name in names if name not in known]
    if unknown:
        advice = f"Known effects: {', '.join(sorted(known))}."
        raise BadInput([Fault(f"there is no effect {name!r}", "unknown_effect", advice) for name in unknown])
    return tuple(known[name] for name in names)
