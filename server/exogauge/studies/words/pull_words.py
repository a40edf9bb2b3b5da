"""Which way a joint moves what it carries, in words: a sign that a person can check by looking at the robot."""

from __future__ import annotations

from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.robots.kinematics import forward, joint_motions
from exogauge.robots.motion import Motion
from exogauge.robots.tree import RigidTree

Array = NDArray[np.float64]

WAYS = (("forward", "back"), ("left", "right"), ("up", "down"))  # along +x, -x; +y, -y; +z, -z of the base link
TURNS = (
    ("tilts", "to the right", "to the left"),
    ("tips", "forward", "back"),
    ("turns", "to the left", "to the right"),
)
UPRIGHT = 0.8  # cosine to the vertical: above, a joint turns rather than moves what it carries
SHORT_M = 0.03  # centre of mass nearer to the axis than this hardly moves


@final
class Ways:
    """The joints of a tree with all angles at zero. The base link's x points forward, its y left, its z up."""

    def __init__(self, tree: RigidTree) -> None:
        self.tree = tree
        zero, none = np.zeros((1, len(tree.joints))), np.zeros((1, 3))
        self._motions = joint_motions(tree, zero)[0]
        states = forward(tree, Motion(zero, zero, zero, none, none, none))
        self._centres = _centres(tree, states.rotation[0], states.position[0])
        self._body = {tree.joints[dof]: n for n, dof in enumerate(tree.dof) if dof >= 0}

    def words(self, joint: str, sign: float) -> str:
        """`moves chest back` for what the joint does when it moves in the direction of the sign."""
        n = self._body[joint]
        linear, turn = sign * self._motions[n, :3], sign * self._motions[n, 3:]
        link, way = self.tree.bodies[n], linear + np.cross(turn, self._centres[n])
        if self.tree.prismatic[n]:
            return f"slides {link} {_of_largest(way, WAYS)}"
        if abs(turn[2]) > UPRIGHT or np.linalg.norm(way) < SHORT_M:
            verb, plus, minus = TURNS[int(np.argmax(np.abs(turn)))]
            return f"{verb} {link} {plus if turn[np.argmax(np.abs(turn))] > 0 else minus}"
        return f"moves {link} {_of_largest(way, WAYS)}"


def _of_largest(vector: Array, words: tuple[tuple[str, str], ...]) -> str:
    largest = int(np.argmax(np.abs(vector)))
    return words[largest][0 if vector[largest] > 0 else 1]


def _centres(tree: RigidTree, rotation: Array, position: Array) -> Array:
    """(N, 3) [m] centre of mass of all that each body carries, base frame; of the bodies' origins where no mass is."""
    mass = tree.phi[:, 0]
    moment = np.einsum("nij,nj->ni", rotation, tree.phi[:, 1:4]) + mass[:, None] * position
    carried = tree.subtree.astype(np.float64)
    whole = carried @ mass
    places = carried @ position / carried.sum(axis=1)[:, None]
    weighed = whole > 0.0
    places[weighed] = (carried @ moment)[weighed] / whole[weighed, None]
    return np.asarray(places)
