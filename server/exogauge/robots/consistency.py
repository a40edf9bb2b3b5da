"""Which inertial parameters a body can have, said in words for the links of a robot.

phi: (..., 10) as `RigidTree.phi`. A link without any mass or inertia is no body: it breaks no rule.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from exogauge.estimation.log_cholesky import (
    central_moments,
    from_log_cholesky,
    inertial_parameters,
    log_cholesky_jacobian,
    log_det_distance,
    nearest_possible,
    pseudo_inertia,
    to_log_cholesky,
)

Array = NDArray[np.float64]

__all__ = [
    "from_log_cholesky",
    "inertial_parameters",
    "is_physical",
    "log_cholesky_jacobian",
    "log_det_distance",
    "nearest_possible",
    "pseudo_inertia",
    "to_log_cholesky",
    "violations",
]


def is_physical(phi: Array, tolerance: float = 0.0) -> bool:
    """Whether one body, phi (10,), can exist: positive mass, and the pseudo-inertia positive definite.

    tolerance: smallest allowed principal ∫ r² dm about the centre of mass, relative to the largest one; negative to let
    infinitely thin bodies pass in spite of rounding.
    """
    if not np.any(phi):
        return True
    if not (np.all(np.isfinite(phi)) and phi[0] > 0):
        return False
    moments = np.linalg.eigvalsh(central_moments(phi))
    return bool(moments[2] > 0 and moments[0] > tolerance * moments[2])


def violations(phi: Array, names: Sequence[str], tolerance: float = 0.0) -> tuple[str, ...]:
    """One sentence for every rule that a link of phi (N, 10) breaks, empty when all can exist."""
    found: list[str] = []
    for body, name in zip(phi, names, strict=True):
        if is_physical(body, tolerance):
            continue
        if not np.all(np.isfinite(body)):
            found.append(f"{name}: a parameter is not a finite number")
            continue
        if body[0] <= 0:
            found.append(f"{name}: mass is {body[0]:.4g} kg, must be positive")
            continue
        moments = np.linalg.eigvalsh(central_moments(body))
        principal = np.sort(moments.sum() - moments)
        if principal[0] <= 0:
            found.append(
                f"{name}: smallest principal moment of inertia about the centre of mass is {principal[0]:.4g} kg·m², "
                "must be positive"
            )
        if moments[0] <= tolerance * moments[2]:
            least, middle, largest = principal
            found.append(
                f"{name}: principal moments {least:.4g} + {middle:.4g} kg·m² do not exceed {largest:.4g} kg·m² "
                f"(short by {largest - least - middle:.3g}), the triangle inequality of a body with extent"
            )
    return tuple(found)
