"""How loops are compiled: at first use (seconds), then cached on disk, without the GIL."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import numba

F = TypeVar("F", bound=Callable[..., object])


def compiled(function: F) -> F:
    """Rounds as it is written."""
    faster: F = numba.njit(cache=True, nogil=True)(function)
    return faster


def fused(function: F) -> F:
    """Multiply and add may be one instruction."""
    faster: F = numba.njit(cache=True, nogil=True, fastmath={"contract"})(function)
    return faster
