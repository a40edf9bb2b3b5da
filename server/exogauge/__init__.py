"""exogauge: say with numbers what an assistive wear does to a body.

`exogauge.Client` and `exogauge.ClientProblem` are imported when they are first asked for: `import exogauge` stays
light, and no inner layer comes to depend on the client. Their types are in `__init__.pyi`.
"""

from importlib import import_module
from typing import Any

__version__ = "0.1.0"


def __getattr__(name: str) -> Any:
    if name in ("Client", "ClientProblem"):
        return getattr(import_module("exogauge.client"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
