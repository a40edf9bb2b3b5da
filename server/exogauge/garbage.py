"""Garbage is not looked for while a process loads what it needs: all of that stays, and looking through it again and
again takes a sixth of the CPU of starting."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def left_while_loading() -> Iterator[None]:
    """What was loaded within is never looked through after it either. What lies about before is looked for first, where
    this is not the beginning: it would stay for good."""
    if not gc.isenabled():  # within itself
        yield
        return
    if gc.get_freeze_count() > 0:
        gc.collect()
    gc.disable()
    try:
        yield
    finally:
        gc.freeze()
        gc.enable()


def looked_for_seldom() -> None:
    """In a process of one answer, most of whose life is loading."""
    gc.set_threshold(100_000)
