"""Logs of the biped as they are, what is declared of them, and how they are identified."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from exogauge.identification.identify import identify
from exogauge.identification.settings import Recording, Settings
from exogauge.logs.model import Log
from exogauge.robots.description import Declared

SETTINGS = Settings(cutoff_hz=20.0, prior_strength=1.0, consistency="free")
DECLARED = Declared(
    ft_gain=0.01, ft_gain_common=0.01, ft_tilt=0.005, ft_zero_force=2.0, ft_zero_moment=0.2, kt_drift=0.01,
    viscous_drift=0.1, coulomb_drift=0.05, imu_tilt=0.009, ft_place=0.001, encoder_zero=0.002, clock=0.001,
)  # fmt: skip
EVERY = np.arange(6)
FORCES = [f"f{axis}" for axis in "xyz"] + [f"m{axis}" for axis in "xyz"]
STARTED = {"log1": 100.0, "log2": 900.0, "later": 1800.0}


def identified(robot, logs, started=None):
    settings = replace(SETTINGS, started=started or {})
    return identify(robot, [Recording(log, held_out=False) for log in logs], settings).model


@pytest.fixture(scope="session")
def robot(biped):
    return replace(biped.robot, declared=DECLARED)


@pytest.fixture(scope="session")
def logs(biped, wander):
    return [biped.record(wander(seed), f"log{seed}", noise=1.0, seed=seed).log for seed in (1, 2)]


@pytest.fixture(scope="session")
def model(robot, logs):
    return identified(robot, logs)


def changed(log: Log, channels: dict) -> Log:
    return replace(log, channels={**log.channels, **channels})


def astray(model, found, expected):
    """How far off the worst is, as a share of the largest, each against its own doubt from the logs alone."""
    size = np.sqrt(np.diag(model.covariance))
    live = size > 0.0
    return np.max(np.abs((found - expected)[live] / size[live])) / np.max(np.abs(expected[live] / size[live]))
