"""Loops are compiled at first use, or ahead by `python -m exogauge.loops`; cached on disk, without the GIL."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import numba

F = TypeVar("F", bound=Callable[..., object])

ahead: list[tuple[Any, str]] = []
"""Every loop that others call, with the types of its arguments, as numba writes them."""


def compiled(*types: str) -> Callable[[F], F]:
    """Rounds as it is written. `types`: those of the arguments with which it is called."""
    return _compiling(types)


def fused(*types: str) -> Callable[[F], F]:
    """Multiply and add may be one instruction."""
    return _compiling(types, fastmath={"contract"})


def _compiling(types: tuple[str, ...], **options: object) -> Callable[[F], F]:
    def decorate(function: F) -> F:
        try:
            loop: F = numba.njit(cache=True, nogil=True, **options)(function)
        except RuntimeError:  # no place where what is compiled may be kept: every process compiles for itself
            loop = numba.njit(nogil=True, **options)(function)
        ahead.extend((loop, f"({given})") for given in types)
        return loop

    return decorate
