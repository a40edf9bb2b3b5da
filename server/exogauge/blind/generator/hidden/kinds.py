"""All sorts of effects that can be hidden."""

from __future__ import annotations

from exogauge.blind.generator.hidden.backlash import Backlash
from exogauge.blind.generator.hidden.effect import HiddenEffect
from exogauge.blind.generator.hidden.load import LoadCoulomb
from exogauge.blind.generator.hidden.motor import KtSaturation, TorqueDelay
from exogauge.blind.generator.hidden.position import JointSpring, TorqueRipple
from exogauge.blind.generator.hidden.presliding import Presliding
from exogauge.blind.generator.hidden.slow import ThermalViscous, TorqueOffsetDrift
from exogauge.blind.generator.hidden.velocity import AsymViscous, NonlinearViscous, Stribeck

KINDS: dict[str, type[HiddenEffect]] = {
    kind.name: kind
    for kind in (
        Stribeck, LoadCoulomb, AsymViscous, NonlinearViscous, Presliding, Backlash, JointSpring, TorqueRipple,
        KtSaturation, ThermalViscous, TorqueOffsetDrift, TorqueDelay,
    )
}  # fmt: skip
CLUTTER = ("stribeck", "load_coulomb", "asym_viscous", "nonlinear_viscous", "joint_spring", "torque_ripple")
