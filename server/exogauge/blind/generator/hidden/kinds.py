"""All sorts of effects that can be hidden."""

from __future__ import annotations

from exogauge.blind.generator.hidden.backlash import Backlash, Elasticity
from exogauge.blind.generator.hidden.band import (
    BandHardening,
    BandHysteresis,
    BandLength,
    BandRelaxation,
    BandSlip,
    BandSoftening,
    BandStiffness,
    BandViaFriction,
    BandViscous,
    ExtraBand,
)
from exogauge.blind.generator.hidden.bodies import BaseTilt, Contact, LinkMass, Payload
from exogauge.blind.generator.hidden.effect import HiddenEffect, WholeEffect
from exogauge.blind.generator.hidden.friction import AsymViscous, LoadCoulomb, NonlinearViscous, Presliding, Stribeck
from exogauge.blind.generator.hidden.log_filter import BandLimitedLog
from exogauge.blind.generator.hidden.motor import Coupling, JointSpring, KtGain, KtSaturation, TorqueDelay, TorqueRipple
from exogauge.blind.generator.hidden.outside import CableWrap, EncoderEccentricity, FrictionWanders, StrapSlides
from exogauge.blind.generator.hidden.sensor import FtCrosstalk, FtDrift, FtGain
from exogauge.blind.generator.hidden.slow import FrictionShift, ThermalViscous, TorqueOffsetDrift

_ON_JOINTS: tuple[type[HiddenEffect], ...] = (
    Stribeck, LoadCoulomb, AsymViscous, NonlinearViscous, Presliding, Backlash, JointSpring, TorqueRipple,
    KtSaturation, ThermalViscous, TorqueOffsetDrift, TorqueDelay, KtGain, FrictionShift, Elasticity,
)  # fmt: skip
_ONE_JOINT: tuple[type[HiddenEffect], ...] = (*_ON_JOINTS, CableWrap, FrictionWanders)
ON_JOINTS = {kind.name: kind for kind in _ONE_JOINT}
_ELSEWHERE: tuple[type[WholeEffect], ...] = (Payload, LinkMass, Contact, BaseTilt, FtGain, FtCrosstalk, FtDrift)
_IN_BANDS: tuple[type[WholeEffect], ...] = (
    BandStiffness, BandLength, BandViscous, BandRelaxation, BandHardening, BandSlip, BandViaFriction, ExtraBand,
)  # fmt: skip
_BANDS_IF_ASKED: tuple[type[WholeEffect], ...] = (BandSoftening, BandHysteresis, StrapSlides)
_WHOLE: tuple[type[WholeEffect], ...] = (*_ELSEWHERE, *_IN_BANDS, Coupling, *_BANDS_IF_ASKED)
ELSEWHERE = {kind.name: kind for kind in _WHOLE}
IN_BANDS = frozenset(kind.name for kind in (*_IN_BANDS, *_BANDS_IF_ASKED))  # only where a device is worn
IN_LOGS = BandLimitedLog.name  # blurs all else, so it comes alone
ON_ENCODERS = EncoderEccentricity.name
OUTSIDE = (CableWrap.name, FrictionWanders.name, StrapSlides.name)  # of every catalogue: nobody may name them
# One more sort in turn would change what every seed hides.
ON_REQUEST = (Coupling.name, ON_ENCODERS, BandSoftening.name, BandHysteresis.name, *OUTSIDE)
KINDS = (*(name for name in (*ON_JOINTS, *ELSEWHERE) if name not in ON_REQUEST), IN_LOGS)  # that take turns
SMALLEST = {"kt_gain": 0.05}  # sizes of effects on joints below which they are none; 0 where not named
CLUTTER = ("stribeck", "load_coulomb", "asym_viscous", "nonlinear_viscous", "joint_spring", "torque_ripple")
