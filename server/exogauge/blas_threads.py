"""Processes that stand beside each other: one thread of linear algebra each, or they wait for each other."""

from __future__ import annotations

import os
from collections.abc import Mapping

LIMITS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


def one_thread(environment: Mapping[str, str]) -> dict[str, str]:
    """The same, where it does not say otherwise."""
    return {**dict.fromkeys(LIMITS, "1"), **environment}


def limit_children() -> None:
    """Whatever this process starts from now on."""
    os.environ.update(one_thread(os.environ))
