"""What the identifiers of effects and places mean, in a person's words."""

from __future__ import annotations

EFFECTS = {
    "motor_gain": "motor gain",
    "viscous": "viscous friction",
    "coulomb": "Coulomb friction",
    "static_friction": "static friction",
    "motor_offset": "motor offset",
    "stribeck": "Stribeck friction",
    "load_coulomb": "load-dependent friction",
    "asym_viscous": "direction-dependent viscous friction",
    "nonlinear_viscous": "nonlinear viscous friction",
    "presliding": "presliding friction",
    "backlash": "backlash",
    "elasticity": "elasticity of the drive",
    "joint_spring": "a spring on the joint",
    "torque_ripple": "torque ripple",
    "rotor_inertia": "rotor inertia",
    "kt_gain": "a wrong torque constant",
    "kt_saturation": "a torque constant that falls with current",
    "thermal_viscous": "temperature-dependent friction",
    "torque_offset_drift": "a drifting torque offset",
    "torque_delay": "a delay of the torque",
    "friction_shift": "friction that changed since the reference log",
    "coupling": "coupling of the motor axes",
    "payload": "a payload",
    "link_mass": "a wrong link mass",
    "contact": "an unannounced contact",
    "base_tilt": "a tilted base",
    "ft_gain": "a wrong gain of the force/torque sensor",
    "ft_crosstalk": "crosstalk of the force/torque sensor",
    "ft_drift": "a drifting zero of the force/torque sensor",
    "imu_delay": "a delay of the IMU",
    "band_stiffness": "a wrong stiffness",
    "band_length": "a wrong natural length",
    "band_viscous": "viscous damping",
    "band_relaxation": "relaxation",
    "band_hardening": "hardening",
    "band_slip": "an anchor that slipped",
    "band_via_friction": "friction at the via points",
    "extra_band": "an undescribed pull",
    "band_limited_log": "signals low-passed before they were stored",
}

ALL = "all"  # name of a place: each of its kind


def effect_words(effect: str) -> str:
    """`stribeck` -> `Stribeck friction`; an identifier that is not known here, with spaces."""
    return EFFECTS.get(effect, effect.replace("_", " "))


def place_words(kind: str, name: str, part: str = "") -> str:
    """`torso_pitch`, `wrist.fx`; with its kind where the name alone does not say what it is."""
    if part:
        return f"{name}.{part}"
    if name in ("", kind, "true"):
        return f"the {kind}"
    if name == ALL:
        return f"every {kind}"
    return name if kind in ("joint", "link") else f"{kind} {name}"


def at_place(effect: str, kind: str, name: str, part: str = "") -> str:
    """`Stribeck friction at torso_pitch`; of the base, of which there is one, the effect alone."""
    if kind == "base":
        return effect_words(effect)
    return f"{effect_words(effect)} {'in' if kind == 'log' else 'at'} {place_words(kind, name, part)}"


def opening(kind: str, name: str, part: str = "") -> str:
    """What a sentence on a place begins with: `torso_pitch: `; nothing of the base, whose sentences name it."""
    if kind == "base":
        return ""
    place = place_words(kind, name, part)
    return f"{place if name != ALL else place[:1].upper() + place[1:]}: "
