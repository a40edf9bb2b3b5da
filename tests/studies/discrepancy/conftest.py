"""Searches for missing effects made by hand: two effects named and something left; one; none; none that explains."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from exogauge.devices.result import Estimate
from exogauge.findings.result import (
    Alternative,
    ChainStep,
    Discrepancy,
    Evidence,
    Excess,
    Finding,
    HeldOut,
    Lineage,
    Link,
    Place,
)
from exogauge.findings.verdict import Seen

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
        sentence=(
            "torso_pitch: within 0.05 rad/s of rest the measured torque exceeds the model by up to 3.1 N·m at the "
            "start of motion and not elsewhere. Stribeck friction (tau_b 3.0 ± 0.2 N·m, v_s 0.04 rad/s) "
            "explains 92 % of the excess on held-out logs (RMSE 2.25 -> 1.08, floor 1.02)."
        ),
        alternatives=(
            Alternative("joint_spring", PITCH, 0.031, "the residual does not depend on the angle"),
            Alternative("presliding", PITCH, 0.402, "explains the starts, not the slow motion between them"),
            Alternative("nonlinear_viscous", PITCH, 0.213, "adds nothing once tau_b is in the model"),
            Alternative("elasticity", PITCH, -0.04, "worse than without it on held-out logs"),
        ),
        also_possible=(
            Alternative("presliding", PITCH, 0.402, "differs only below 0.01 rad/s, where these logs have no samples"),
        ),
        motion="three slow reversals of torso_pitch at ± 0.1 rad/s, two seconds each.",
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
        sentence="r_elbow: the residual follows the angle like a weight. 0.61 ± 0.03 kg at r_arm explain 97 % of it.",
        alternatives=(Alternative("joint_spring", Place("joint", "r_elbow"), 0.71, "does not follow gravity"),),
        also_possible=(),
        motion="",
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
            Excess("tau.r_elbow", "N·m", 1.312, 0.601, 18.2, "away from the upright posture"),
            Excess("tau.torso_pitch", "N·m", 2.251, 1.021, 31.7, "within 0.05 rad/s of rest"),
        ),
        unexplained=(Excess("tau.torso_yaw", "N·m", 0.811, 0.622, 4.1, "above 1.2 rad/s, in val_1 only"),),
        rejected=(
            Alternative("backlash", PITCH, 0.012, "below what chance gives"),
            Alternative("torque_ripple", Place("joint", "all"), 0.055, "absorbed by the offset to 94 %"),
            Alternative("base_tilt", Place("base", "base"), float("nan"), "no held-out log moves the base"),
        ),
        lineage=(
            Lineage("m0-3f2a", None, "identified model"),
            Lineage("m1-77c1", "m0-3f2a", "stribeck at torso_pitch"),
            Lineage("m2-0b9e", "m1-77c1", "payload at r_arm"),
        ),
        candidates=214,
        notes=("Static friction is judged from rest alone.",),
        before_after={
            "RMSE of support B at torso_pitch, bend": (Estimate(1.83, 0.12, "N·m"), Estimate(0.171, 0.02, "N·m")),
            "stiffness of A by B": (Estimate(241.0, 6.0, "N/m"), Estimate(199.5, 4.0, "N/m")),
        },
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
        before_after={},
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
