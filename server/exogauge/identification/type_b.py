"""What declared uncertainties of the measurement do to an identified robot, through the equations that identified it.

A disturbance θ of unit size takes c off the rows, A x - c θ = y; nothing in the fit knows of it, so x errs by V θ with
V = -H⁻¹ Aᵀ W c. It is one error in all that is computed from x, and acts once more where x is applied to a log that it
spoils as well: consider parameters, of GUM 5.2's correlated inputs.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

ROBOT = "robot"
UNEXPLAINED = "unexplained"  # what is left without a name, beside the kinds of declared inputs


@final
@dataclass(frozen=True)
class TypeB:
    """P parameters x, I inputs that are the same in all logs.

    names: (I,) `ft_gain.left_foot`; std: (I,) of each; moved: (P, I) error of x per unit of each.
    by_log: name -> (P, P) covariance of x that inputs leave which are others in each log. moved_by_zeros: (P, Z) error
    of x per unit of each contact sensor's zero, were it the same in all logs.
    """

    names: tuple[str, ...] = ()
    std: Array = field(default_factory=lambda: np.zeros(0))
    moved: Array = field(default_factory=lambda: np.zeros((0, 0)))
    by_log: Mapping[str, Array] = field(default_factory=dict)
    moved_by_zeros: Array = field(default_factory=lambda: np.zeros((0, 0)))

    @property
    def alike(self) -> Array:
        """(P, P) of x from the inputs that are the same in all logs."""
        return np.asarray(self.moved * self.std**2 @ self.moved.T)


def by_source(covariance: Array, inputs: TypeB) -> dict[str, Array]:
    """Source -> its part (P + I, P + I) of `of_covariance`.

    `robot`: what the logs leave open of its parameters; then each declared uncertainty, of all sensors and axes.
    """
    P, total = len(covariance), len(covariance) + len(inputs.names)
    both, of_logs = of_covariance(covariance, inputs), dict[str, Array]()
    for name, own in inputs.by_log.items():
        of_logs[name] = np.zeros((total, total))
        of_logs[name][:P, :P] = own
    kinds = np.array([name.partition(".")[0] for name in inputs.names])
    alike = dict[str, Array]()
    for kind in dict.fromkeys(kinds.tolist()):
        of_kind = np.where(kinds == kind, inputs.std**2, 0.0)
        alike[kind] = np.diag(np.concatenate([np.zeros(P), of_kind]))
    rest = both - sum([*of_logs.values(), *alike.values()], np.zeros_like(both))
    return {ROBOT: rest, **of_logs, **alike}


def lifted_by_source(inputs: TypeB, lifted: Callable[[Array], Array]) -> dict[str, Array]:
    """Declared uncertainty -> (S,) variance that it makes of each standard parameter. lifted: `Prior.lifted`."""
    kinds, moved = np.array([name.partition(".")[0] for name in inputs.names]), lifted(inputs.moved * inputs.std)
    found = {kind: np.sum(moved[:, kinds == kind] ** 2, axis=1) for kind in dict.fromkeys(kinds.tolist())}
    for name, C in inputs.by_log.items():
        found[name] = np.einsum("ii->i", lifted(lifted(C).T))
    return found


def of_covariance(covariance: Array, inputs: TypeB) -> Array:
    """(P + I, P + I) of what is left of x without the common inputs, and of these. covariance: (P, P) of x."""
    P, total = len(covariance), len(covariance) + len(inputs.names)
    both = np.zeros((total, total))
    both[:P, :P] = covariance - inputs.alike if inputs.names else covariance
    both[range(P, total), range(P, total)] = inputs.std**2
    return both
