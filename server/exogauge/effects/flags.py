"""What only some effects say of themselves: yes where the file of the effect sets it to True, else no."""

from __future__ import annotations


def along_motion(effect: object) -> bool:
    """Evidence is shown along the motion, what opposes it being negative: friction over anything but velocity would
    cancel in a mean over both directions."""
    return bool(getattr(effect, "along_motion", False))


def at_turns(effect: object) -> bool:
    """It shows where a joint turns round, as a low-pass does that is not quite the model's: it is not looked for where
    every log was low-passed before it was stored."""
    return bool(getattr(effect, "at_turns", False))


def common_cause(effect: object) -> bool:
    """Places have it in common (one bus, one filter, one amplifier that warms up): on most of them it is told once."""
    return bool(getattr(effect, "common_cause", False))


def of_logged_torque(effect: object) -> bool:
    """It is a factor of the logged torque: where currents are logged, the model's own k_T is that factor."""
    return bool(getattr(effect, "of_logged_torque", False))
