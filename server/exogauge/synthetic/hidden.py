"""What can be hidden in the true robot: one `EFFECT@PLACE` per effect."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from exogauge.errors import BadInput, Fault
from exogauge.synthetic.robot_facts import JOINTS, LINKS, Joint

KNOWN = {"stribeck": "joint", "payload": "link"}
NOTHING = "none"  # asked for by name, where something is hidden by default
WITH_SUIT = ("stribeck@torso_pitch",)  # by default: it blurs the supporting torque where the suit supports
_LINK_NAMES = [link.name for link in LINKS if link.mass > 0.0]


@final
@dataclass(frozen=True)
class Hidden:
    """effect, place: as asked for; parameters: the drawn size, SI units."""

    effect: str
    place: str
    parameters: Mapping[str, float]

    @property
    def where(self) -> dict[str, str]:
        return {KNOWN[self.effect]: self.place}


def specs_to_hide(asked: Sequence[str] | None, suit: str) -> tuple[str, ...]:
    """What was asked for; `WITH_SUIT` where nothing was and there is a suit. BadInput for `none` beside an effect."""
    if asked is None:
        return () if suit == "none" else WITH_SUIT
    specs = tuple(asked)
    if NOTHING in specs and len(set(specs)) > 1:
        raise _refusal("either nothing is hidden or something is", "hidden_contradicts", ", ".join(specs))
    return tuple(spec for spec in specs if spec != NOTHING)


def parse_hidden(specs: Sequence[str], rng: np.random.Generator) -> list[Hidden]:
    """Effects with sizes drawn by rng; BadInput for an unknown effect or place, naming the known ones."""
    return [_parse(spec, rng) for spec in specs]


def _parse(spec: str, rng: np.random.Generator) -> Hidden:
    effect, at, place = spec.partition("@")
    if not at or effect not in KNOWN:
        known = ", ".join(f"{name}@<{kind}>" for name, kind in KNOWN.items())
        raise _refusal(f"no effect of that form can be hidden: it must be one of {known}", "unknown_effect", spec)
    if effect == "stribeck":
        joint = next((joint for joint in JOINTS if joint.name == place), None)
        if joint is None:
            raise _refusal(f"{place!r} is no joint of the robot", "unknown_joint", spec, [j.name for j in JOINTS])
        return Hidden(effect, place, _stribeck(joint, rng))
    if place not in _LINK_NAMES:
        raise _refusal(f"{place!r} is no link of the robot", "unknown_link", spec, _LINK_NAMES)
    return Hidden(effect, place, _payload(rng))


def _stribeck(joint: Joint, rng: np.random.Generator) -> dict[str, float]:
    """A peak tau_b above tau_c at rest, gone a few v_s later."""
    return {"tau_b": float(joint.drive.tau_c * rng.uniform(0.7, 1.2)), "v_s": float(rng.uniform(0.03, 0.06))}


def _payload(rng: np.random.Generator) -> dict[str, float]:
    """A ball fixed at the link frame's origin, a little beside it."""
    x, y, z = rng.uniform(-0.03, 0.03, 3)
    return {"mass": float(rng.uniform(0.6, 1.2)), "x": float(x), "y": float(y), "z": float(z), "radius": 0.05}


def _refusal(detail: str, rule: str, value: str, known: Sequence[str] = ()) -> BadInput:
    advice = f"Known: {', '.join(known)}" if known else ""
    return BadInput(Fault(detail, rule, advice, column="hidden", value=value))
