"""Two suits worn in two motions, made by hand: smooth curves whose peaks, errors and gaps are known."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np
import pytest

from exogauge.devices.result import BandEstimate, Estimate, StiffnessResult
from exogauge.identification.result import Channels, Prediction
from exogauge.remarks import About, Remark
from exogauge.support.result import Best, Effort, JointEquality, JointSupport, PhaseEffort, SupportResult, Trial

JOINTS = ("torso_yaw", "torso_pitch", "r_elbow")
DEVICES = {"Normal suit": 197.8, "Modified suit": 395.6}
MOVED = {"bend": 1, "twist": 0}
PHASES = ("standing", "lowering", "holding", "raising")
ENDS = (2.0, 5.0, 7.0, 10.0, 12.0)  # [s] of standing, lowering, holding, raising, standing
ORDER = (0, 1, 2, 3, 0)
RATE = 200.0
OFFSETS = {"a": 0.1, "b": 0.3, "paired": 0.2, "prior": 2.0}  # [N·m] what is added to the truth


def bent(time: np.ndarray) -> np.ndarray:
    """From 0 to 1 and back, standing still before, between and after."""
    down = np.clip((time - ENDS[0]) / (ENDS[1] - ENDS[0]), 0.0, 1.0)
    up = np.clip((time - ENDS[2]) / (ENDS[3] - ENDS[2]), 0.0, 1.0)
    return 0.5 * (np.cos(np.pi * up) - np.cos(np.pi * down))


def make_trial(device: str, motion: str, number: int) -> Trial:
    rng = np.random.default_rng(number)
    time = np.arange(0.0, ENDS[-1], 1.0 / RATE)
    shape, size = bent(time), DEVICES[device] / 197.8
    shares = np.array([0.05, 0.05, 0.01])
    shares[MOVED[motion]] = 1.0
    model = -5.0 * size * shape[:, None] * shares
    phase = np.asarray(ORDER)[np.searchsorted(ENDS, time, side="right").clip(0, 4)]
    rest = np.repeat(np.isin(phase, (0, 2))[:, None], 3, axis=1)
    wave = 0.4 * np.sin(9.0 * time)[:, None] * shares
    a, b = model + OFFSETS["a"] + wave, model + OFFSETS["b"] - wave
    compared = np.ones_like(rest)
    compared[(time > 2.0) & (time < 2.2)] = False
    log = f"{motion}_{device.split()[0].lower()}_{number}"
    noise = rng.standard_normal(time.size)
    measured = {f"tau.{joint}": 12.0 * shape + noise + k for k, joint in enumerate(JOINTS)}
    channels = partial(
        Channels,
        measured,
        {channel: values - noise for channel, values in measured.items()},
        {channel: 0.8 * values for channel, values in measured.items()},
        {},
    )
    prediction = Prediction(log, True, time, dict.fromkeys(measured, "N·m"), channels)
    length = 0.62 + 0.05 * shape
    return Trial(
        log=log,
        device=device,
        motion=motion,
        reference=f"{motion}_plain_{number}",
        lag_s=0.012 * number,
        time=time,
        joints=JOINTS,
        q=1.2 * shape[:, None] * shares,
        support_a=a,
        support_a_std=np.full_like(model, 0.15),
        support_b=b,
        support_b_std=np.full_like(model, 0.25),
        support_paired=model + OFFSETS["paired"],
        support_paired_std=np.full_like(model, 0.12),
        low_paired=model + OFFSETS["paired"] - np.where(rest, 1.7, 0.0),
        high_paired=model + OFFSETS["paired"] + np.where(rest, 1.7, 0.0),
        support_prior=model + OFFSETS["prior"],
        band_model=model,
        low_a=model + OFFSETS["a"] + wave - np.where(rest, 0.9, 0.0),
        high_a=model + OFFSETS["a"] + wave + np.where(rest, 0.9, 0.0),
        low_b=model + OFFSETS["b"] - wave - np.where(rest, 1.7, 0.0),
        high_b=model + OFFSETS["b"] - wave + np.where(rest, 1.7, 0.0),
        compared=compared,
        steady=~rest & compared,
        rest=rest,
        equality=tuple(JointEquality(joint, 0.002 * number, 0.011, 0.031, "equal") for joint in JOINTS),
        phase=phase.astype(np.intp),
        phase_names=PHASES,
        length={"A_left": length, "A_right": length},
        tension={"A_left": 100.0 * size * (length - 0.6), "A_right": 100.0 * size * (length - 0.6)},
        prediction=prediction,
    )


def effort(time: np.ndarray, torque: np.ndarray, std: float) -> Effort:
    seconds = time.size / RATE
    peak = float(torque[np.argmax(np.abs(torque))])
    mean = float(torque.mean())
    return Effort(
        Estimate(peak, 2 * std, "N·m"), Estimate(mean, std, "N·m"), Estimate(mean * seconds, std * seconds, "N·m·s")
    )


def summed(trials: Sequence[Trial], k: int) -> JointSupport:
    """What the trials of one device and motion say of their joint k; numbers of the first trial."""
    first = trials[0]
    assert first.support_a is not None
    assert first.band_model is not None
    assert first.support_paired is not None
    curves = {
        "a": first.support_a, "b": first.support_b, "paired": first.support_paired, "prior": first.support_prior,
        "band_model": first.band_model,
    }  # fmt: skip
    stds = {"a": 0.11, "b": 0.21, "paired": 0.16, "prior": 0.31, "band_model": 0.0}
    rmse = {
        name: float(np.sqrt(np.mean((curves[name][:, k] - first.band_model[:, k]) ** 2)))
        for name in ("a", "b", "paired", "prior")
    }
    phases = tuple(
        PhaseEffort(
            name,
            float((first.phase == n).sum() / RATE),
            {key: effort(first.time[first.phase == n], c[first.phase == n, k], stds[key]) for key, c in curves.items()},
            Best("a", ("a",)),
        )
        for n, name in enumerate(PHASES)
    )
    return JointSupport(
        device=first.device,
        motion=first.motion,
        joint=JOINTS[k],
        logs=tuple(trial.log for trial in trials),
        references=tuple(str(trial.reference) for trial in trials),
        rmse=rmse,
        rmse_steady={name: 0.9 * value for name, value in rmse.items()},
        by={key: effort(first.time, c[:, k], stds[key]) for key, c in curves.items()},
        spread={"a": 0.07, "b": 0.08, "paired": 0.06, "prior": 0.08},
        phases=phases,
        null={"a": 0.123, "b": 0.321, "paired": 0.213},
        equality=tuple(trial.equality[k] for trial in trials),
        lag_s=tuple(trial.lag_s for trial in trials),
        masked_share=float(1.0 - first.compared[:, k].mean()),
        rest_share=float(first.rest[:, k].mean()),
        rest_half_width=1.7,
        best=Best("a", ("a", "b")),
    )


@pytest.fixture(scope="session")
def support() -> SupportResult:
    """Normal and modified suit, bend and twist, two trials each."""
    groups = [[make_trial(device, motion, number) for number in (1, 2)] for device in DEVICES for motion in MOVED]
    return SupportResult(
        trials=tuple(trial for group in groups for trial in group),
        joints=tuple(summed(group, k) for group in groups for k in range(3)),
        band_model=dict.fromkeys(DEVICES, Remark(About.BANDS_OF_FILE)),
        remarks=(Remark(About.TOUCHED, ("bend_normal_1",), numbers=(1.0, 2.0)),),
    )


def band(name: str, group: str, truth: float | None, value: float, std: float, told: bool = True) -> BandEstimate:
    return BandEstimate(
        band=name,
        group=group,
        stiffness=Estimate(value, std, "N/m"),
        natural_length=Estimate(0.6123, 0.0045, "m"),
        stiffness_interval=(value - 2 * std, value + 2 * std),
        natural_length_interval=(0.6035, 0.6211),
        true_stiffness=truth,
        error_percent=None if truth is None else 100 * (value - truth) / truth,
        identifiable=told,
        length_identifiable=told,
        note=None if told else Remark(About.PULLS_NOWHERE, (name,)),
    )


@pytest.fixture(scope="session")
def stiffness() -> tuple[StiffnessResult, ...]:
    """Both suits by all three approaches; group B is not identifiable."""
    parameters = ("stiffness[A]", "natural_length[A_left]", "natural_length[A_right]", "stiffness[B]")
    correlation = np.eye(4)
    correlation[0, 1] = correlation[1, 0] = 0.97
    made = []
    for device, truth in DEVICES.items():
        for approach, factor, std in (("A", 0.985, 2.9), ("B", 0.96, 4.4), ("prior", 0.6, 21.0)):
            bands = (
                band("A_left", "A", truth, factor * truth, std),
                band("A_right", "A", truth, factor * truth, std),
                band("B_left", "B", None, 90.0, np.inf, told=False),
            )
            made.append(
                StiffnessResult(
                    device,
                    approach,
                    bands,
                    parameters,
                    correlation,
                    {"torso_pitch": 0.4},
                    9000,
                    (Remark(About.LENGTHS_TIED, ("band_b_l", "band_b_r")),),
                )
            )
    return tuple(made)
