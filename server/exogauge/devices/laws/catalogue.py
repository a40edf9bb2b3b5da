"""All force laws there are: every module of this package that offers a `LAW`."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Iterator, Mapping
from difflib import get_close_matches
from functools import cache
from types import MappingProxyType

import exogauge.devices.laws as package
from exogauge.devices.laws.law import ForceLaw
from exogauge.errors import BadInput, Fault


@cache
def all_laws() -> Mapping[str, ForceLaw]:
    """Identifier -> law, found by looking into the package: adding one file is all it takes."""
    modules = (importlib.import_module(f"{package.__name__}.{m.name}") for m in pkgutil.iter_modules(package.__path__))
    laws: list[ForceLaw] = [module.LAW for module in modules if hasattr(module, "LAW")]
    return MappingProxyType({law.name: law for law in laws})


def law_named(name: str) -> ForceLaw:
    """Raises BadInput."""
    known = all_laws()
    if name not in known:
        raise BadInput(list(law_faults(name, {})))
    return known[name]


def check_values(
    law: str, values: Mapping[str, float], law_key: str = "law", values_key: str = "law_values"
) -> ForceLaw:
    """The named law, if the values are its own. Raises BadInput, with the keys as the faults' columns."""
    faults = list(law_faults(law, values, law_key, values_key))
    if faults:
        raise BadInput(faults)
    return law_named(law)


def law_faults(
    law: str, values: Mapping[str, float], law_key: str = "law", values_key: str = "law_values"
) -> Iterator[Fault]:
    """An unknown law; values that it does not know, lacks, or cannot take."""
    known = all_laws()
    if law not in known:
        close = get_close_matches(law, list(known), n=1)
        advice = f"Did you mean {close[0]!r}?" if close else f"Known laws: {', '.join(sorted(known))}"
        yield Fault(f"there is no force law {law!r}", "unknown_law", advice, column=law_key, value=law[:80])
        return
    quantities = {quantity.name: quantity for quantity in known[law].values}
    for name in values:
        if name not in quantities:
            advice = f"It has {', '.join(quantities)}" if quantities else "Leave it out"
            detail = f"the law {law!r} has no parameter {name!r}"
            yield Fault(detail, "unknown_law_value", advice, column=f"{values_key}.{name}", value=name[:80])
    for name, quantity in quantities.items():
        column, advice = f"{values_key}.{name}", f"{quantity.sentence} Typical: {quantity.typical:g} {quantity.unit}"
        if name not in values:
            yield Fault(f"the law {law!r} needs {name!r}", "missing_law_value", advice, column=column)
        elif not quantity.low <= values[name] <= quantity.high or abs(values[name]) == float("inf"):
            detail = f"{name!r} must be between {quantity.low:g} and {quantity.high:g} {quantity.unit}"
            yield Fault(detail, "law_value_range", advice, column=column, value=f"{values[name]:g}")
