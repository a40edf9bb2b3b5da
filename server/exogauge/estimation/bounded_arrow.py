"""Least squares between bounds, of blocks that have nothing in common but a few unknowns."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Block:
    """Of the cost ½ uᵀ H u - gᵀ u what K own unknowns of one block add. own: (K, K), cross: (S, K), g: (K,)."""

    own: Array
    cross: Array
    g: Array


def solve_bounded(shared: Array, g: Array, blocks: Sequence[Block], most: float) -> tuple[Array, list[Array]]:
    """(S,) and (K,) of each block: the least cost with every unknown within ± most. shared: (S, S), g: (S,).

    H = I + what is no less than none. By active sets of both bounds at once (Hintermüller, Ito & Kunisch 2003): those
    unknowns stay at a bound that the gradient holds there. What is left of a curvature is at least 1; less is rounding.
    """
    rounds = 60  # of active sets; a handful settle them
    sizes = np.cumsum([len(g), *(len(block.g) for block in blocks)])[:-1]
    everything = np.concatenate([g, *(block.g for block in blocks)])
    diagonal = np.concatenate([np.diag(shared), *(np.diag(block.own) for block in blocks)])
    side, u = np.zeros(len(everything)), np.zeros(len(everything))
    for _ in range(rounds):
        at = np.split(side, sizes)
        u = np.concatenate(_solved(shared, g, blocks, at, most))
        pull = np.where(side == 0.0, 0.0, everything - _times(shared, blocks, np.split(u, sizes)))
        reach = u + pull / diagonal
        before, side = side, np.where(reach > most, 1.0, np.where(reach < -most, -1.0, 0.0))
        if np.array_equal(before, side):
            break
    parts = np.split(np.clip(u, -most, most), sizes)
    return parts[0], parts[1:]


def _times(shared: Array, blocks: Sequence[Block], u: Sequence[Array]) -> Array:
    """H u."""
    first = shared @ u[0]
    rest = []
    for block, own in zip(blocks, u[1:], strict=True):
        first = first + block.cross @ own
        rest.append(block.cross.T @ u[0] + block.own @ own)
    return np.concatenate([first, *rest])


def _solved(shared: Array, g: Array, blocks: Sequence[Block], side: Sequence[Array], most: float) -> list[Array]:
    """Least cost with those unknowns at a bound whose side is 1 or -1."""
    free = side[0] == 0.0
    fixed, H, rest = most * side[0], shared[np.ix_(free, free)], g - shared @ (most * side[0])
    inner = list[tuple[Callable[[Array], Array], Array, Array]]()
    for block, own in zip(blocks, side[1:], strict=True):
        loose = own == 0.0
        at_bound = most * own
        inverse = _inverse(block.own[np.ix_(loose, loose)])
        cross = block.cross[np.ix_(free, loose)]
        alone = (block.g - block.cross.T @ fixed - block.own @ at_bound)[loose]
        rest = rest - block.cross @ at_bound
        H = H - cross @ inverse(cross.T)
        inner.append((inverse, cross, alone))
    reduced = rest[free] - sum((cross @ inverse(alone) for inverse, cross, alone in inner), np.zeros(int(free.sum())))
    found = [fixed]
    found[0][free] = _inverse(H)(reduced)
    for (inverse, cross, alone), own in zip(inner, side[1:], strict=True):
        u = most * own
        u[own == 0.0] = inverse(alone - cross.T @ found[0][free])
        found.append(u)
    return found


def _inverse(H: Array) -> Callable[[Array], Array]:
    """Applies H⁻¹, of a curvature of at least 1 in every direction."""
    curvature, vectors = np.linalg.eigh(0.5 * (H + H.T))
    size = np.maximum(curvature, 1.0)

    def divided(right: Array) -> Array:
        return np.asarray((vectors / size) @ (vectors.T @ right))

    return divided
