"""Random numbers of their own for each purpose: leaving out a log or hiding an effect changes nothing else."""

from __future__ import annotations

import zlib

import numpy as np


def stream(seed: int, purpose: str) -> np.random.Generator:
    """The same numbers for the same seed and purpose, in whatever order and process they are asked for."""
    return np.random.default_rng([seed, zlib.crc32(purpose.encode())])
