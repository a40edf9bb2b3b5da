"""What one child process may use, set by the child itself before it opens anything."""

from __future__ import annotations

import resource
from dataclasses import dataclass
from typing import final

GIGABYTE = 1 << 30


@final
@dataclass(frozen=True)
class Limits:
    """memory: bytes of address space. cpu_s: CPU seconds. file: bytes of any file written. wall_s: seconds in all."""

    memory: int = 4 * GIGABYTE
    cpu_s: int = 60
    file: int = 4 * GIGABYTE
    wall_s: float = 180.0

    @staticmethod
    def for_bytes(size: int) -> Limits:
        """More time for larger input: 60 to 120 CPU seconds, three times that on the wall clock."""
        cpu_s = min(120, 60 + 60 * size // GIGABYTE)
        return Limits(cpu_s=cpu_s, wall_s=3.0 * cpu_s)

    def apply(self) -> None:
        """Bind this process; the hard CPU limit comes a little later than the soft one, which can be told apart."""
        _lower(resource.RLIMIT_AS, self.memory, self.memory)
        _lower(resource.RLIMIT_CPU, self.cpu_s, self.cpu_s + 5)
        _lower(resource.RLIMIT_FSIZE, self.file, self.file)
        _lower(resource.RLIMIT_CORE, 0, 0)


def _lower(kind: int, soft: int, hard: int) -> None:
    """A limit that is already lower stays."""
    _, present = resource.getrlimit(kind)
    if present != resource.RLIM_INFINITY:
        soft, hard = min(soft, present), min(hard, present)
    resource.setrlimit(kind, (soft, hard))
