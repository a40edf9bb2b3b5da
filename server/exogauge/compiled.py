"""Loops over samples, compiled where numba is there to do it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any


def compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    """njit, cached on disk, without the GIL; without numba as it is, some seventy times as slow."""
    try:
        from numba import njit
    except ImportError:
        return function
    faster: Callable[..., Any] = njit(cache=True, nogil=True)(function)
    return faster
