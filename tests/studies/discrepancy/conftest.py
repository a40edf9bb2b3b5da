"""Searches for missing effects made by hand: two effects named and something left; one; none; none that explains."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from exogauge.devices.result import Estimate
from exogauge.effects.catalogue import shaped_effects
from exogauge.findings.basis import BesideStated, OfRobot
from exogauge.findings.result import (
    Alternative,
    ChainStep,
    Concentration,
    Consequence,
    Discrepancy,
    Evidence,
    Excess,
    Finding,
    HeldOut,
    Lineage,
    Link,
    Place,
)
from exogauge.findings.verdict import Caveat, Objection, Seen, Why

PITCH, HAND = Place("joint", "torso_pitch"), Place("link", "r_arm")
TAU_B, V_S = 3.0, 0.04  # [N·m], [rad/s] of the friction that was missing


def stribeck_evidence() -> Evidence:
    """Residual over velocity: what the model lacks near rest, with a ripple; nothing beyond 0.3 rad/s."""
    rng = np.random.default_rng(5)
    at = np.concatenate([-np.geomspace(0.9, 0.006, 18), np.geomspace(0.006, 0.9, 18)])
    model = -TAU_B * np.exp(-((at / V_S) ** 2)) * np.sign(at)
    spread = 0.08 + 0.1 * np.abs(at)
    rest = spread * rng.standard_normal(at.size)
    before = model + rest
    before[3] = np.nan  # a bin that holds nothing
    return Evidence("velocity", "rad/s", at, before, rest, spread, model)


def stribeck() -> Finding:
    return Finding(
        rank=1,
        effect="stribeck",
        place=PITCH,
        parameters={"tau_b": Estimate(3.04, 0.21, "N·m"), "v_s": Estimate(0.0413, 0.0062, "rad/s")},
        held_out=HeldOut("tau.torso_pitch", "N·m", 2.251, 1.083, 1.021),
        score=0.924,
        basis=OfRobot(shaped_effects()["stribeck"]),
        alternatives=(
            Alternative("joint_spring", PITCH, 0.031, Objection(Why.WORSE, 4.2, of=("high_speed",))),
            Alternative("presliding", PITCH, 0.402, Objection(Why.NOT_SURE, 2.1, 3.0)),
            Alternative("nonlinear_viscous", PITCH, 0.213, Objection(Why.NOT_NEEDED, of=("stribeck",))),
            Alternative("elasticity", PITCH, -0.04, Objection(Why.LITTLE, 0.0)),
        ),
        also_possible=(Alternative("presliding", PITCH, 0.402, Objection(Why.ALIKE)),),
        evidence=stribeck_evidence(),
    )


def payload() -> Finding:
    at = np.linspace(-0.9, 0.9, 21)
    model = 1.4 * np.sin(at)
    rest = 0.12 * np.random.default_rng(2).standard_normal(at.size)
    return Finding(
        rank=2,
        effect="payload",
        place=HAND,
        parameters={"mass": Estimate(0.612, 0.031, "kg")},
        held_out=HeldOut("tau.r_elbow", "N·m", 1.312, 0.644, 0.601),
        score=0.97,
        basis=BesideStated(0.05),
        alternatives=(Alternative("joint_spring", Place("joint", "r_elbow"), 0.71, Objection(Why.LESS_LIKELY)),),
        also_possible=(),
        evidence=Evidence("position", "rad", at, model + rest, rest, np.full(21, 0.1), model),
    )


@pytest.fixture(scope="session")
def discrepancy() -> Discrepancy:
    """Two effects named."""
    return Discrepancy(
        findings=(stribeck(), payload()),
        chain=(
            Link(ChainStep("bands"), 7.71, 0.62, "tau.torso_pitch", 9.33, 1.02),
            Link(ChainStep("robot"), 1.48, 0.62, "tau.torso_pitch", 2.25, 1.02),
            Link(ChainStep("effect", "stribeck", PITCH), 0.93, 0.62, "tau.r_elbow", 1.31, 0.60),
            Link(ChainStep("effect", "payload", HAND), 0.67, 0.62, "tau.torso_yaw", 0.81, 0.62),
        ),
        located=(
            Excess("tau.r_elbow", "N·m", 1.312, 0.601, 18.2, Concentration((), "position", True, 0.4, "rad")),
            Excess("tau.torso_pitch", "N·m", 2.251, 1.021, 31.7, Concentration((), "speed", False, 0.05, "rad/s")),
        ),
        unexplained=(Excess("tau.torso_yaw", "N·m", 0.811, 0.622, 4.1, Concentration((("val_1", 12.0),))),),
        rejected=(
            Alternative("backlash", PITCH, 0.012, Objection(Why.LESS)),
            Alternative("torque_ripple", Place("joint", "all"), 0.055, Objection(Why.TOO_SMALL, 0.012, 0.04)),
            Alternative("base_tilt", Place("base", "base"), float("nan"), Objection(Why.TOO_SHORT, 0.0, 5.0)),
        ),
        lineage=(
            Lineage("m0-3f2a", None, None),
            Lineage("m1-77c1", "m0-3f2a", ChainStep("effect", "stribeck", PITCH)),
            Lineage("m2-0b9e", "m1-77c1", ChainStep("remainder", "stribeck", PITCH)),
        ),
        candidates=214,
        notes=(Caveat("joined", "val_2"),),
        before_after=(
            Consequence(
                "rmse", ("suit", "bend", "torso_pitch"), Estimate(1.83, 0.12, "N·m"), Estimate(0.171, 0.02, "N·m")
            ),
            Consequence(
                "group_stiffness", ("A", "B", "suit"), Estimate(241.0, 6.0, "N/m"), Estimate(199.5, 4.0, "N/m")
            ),
        ),
        seen=(Seen("tau.torso_yaw", 1.3, 30.0, 90.0), Seen("tau.torso_pitch", 1.06, 30.0, 90.0)),
    )


@pytest.fixture(scope="session")
def one(discrepancy: Discrepancy) -> Discrepancy:
    """One effect named, nothing left."""
    end = dataclasses.replace(discrepancy.chain[-1], worst_rmse=0.66)
    return dataclasses.replace(
        discrepancy,
        findings=discrepancy.findings[:1],
        chain=(*discrepancy.chain[:-1], end),
        unexplained=(),
        seen=(Seen("tau.torso_yaw", 1.06, 30.0, 90.0),),
    )


@pytest.fixture(scope="session")
def clean(discrepancy: Discrepancy) -> Discrepancy:
    """Nothing is missing."""
    return dataclasses.replace(
        discrepancy,
        findings=(),
        chain=(
            Link(ChainStep("bands"), 2.31, 0.62, "tau.torso_pitch", 4.12, 0.66),
            Link(ChainStep("robot"), 0.64, 0.62, "tau.torso_yaw", 0.66, 0.62),
        ),
        located=(),
        unexplained=(),
        lineage=discrepancy.lineage[:1],
        before_after=(),
        seen=(Seen("tau.torso_yaw", 1.06, 30.0, 90.0), Seen("tau.torso_pitch", 1.0, 30.0, 90.0)),
    )


@pytest.fixture(scope="session")
def unexplained(clean: Discrepancy, discrepancy: Discrepancy) -> Discrepancy:
    """Something is there, and nothing explains it."""
    return dataclasses.replace(clean, located=discrepancy.located, unexplained=discrepancy.located)


@pytest.fixture(scope="session")
def short(clean: Discrepancy) -> Discrepancy:
    """Nothing stands above the noise, in logs that hold hardly any motion."""
    return dataclasses.replace(clean, seen=(Seen("tau.torso_yaw", 1.06, 1.2, 9.0),))
