"""An IMU in place of positions: its place, delay and gains are found, and what they leave open is in every interval."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from tests.payload import foreign
from tests.payload.told import broken, evaluated, off

EXACT = ("uncertainty: none",)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["plain", "beside", "noisy"])
def test_intervals_hold_with_an_imu(kind: str, tmp_path: Path) -> None:
    """An inertia was outside its interval up to a fifth of the time: the lag was that at which resampled wrenches were
    quietest, gains and place counted as none, and least squares took what the IMU read for exact."""
    imu = {
        "plain": foreign.Imu(np.zeros(3), np.ones(3)),
        "beside": foreign.Imu(np.array([0.03, -0.02, 0.01]), np.array([1.01, 0.995, 1.0]), late=0.009),
        "noisy": foreign.Imu(np.zeros(3), np.ones(3), noise=0.15),
    }[kind]
    errors = []
    for seed in range(3):
        folder = tmp_path / str(seed)
        folder.mkdir()
        truth = foreign.write(folder, seed, imu=imu, more=EXACT)
        found = evaluated(folder)
        errors.append(off(found, truth))
        assert found.imu is not None
        assert abs(found.imu.lag_s - imu.late) < 4.0 * found.imu.lag_std_s < 0.004
        assert np.all(np.abs(found.imu.place - imu.place) < 4.0 * found.imu.place_std)
        assert np.all(found.imu.place_std < 0.01)
    assert not broken(errors)


@pytest.mark.slow
def test_the_lag_of_an_imu_is_none_where_noise_alone_would_choose(tmp_path: Path) -> None:
    """A light payload: wrenches told halfway between two samples were quieter, and the lag was half a period."""
    foreign.write(tmp_path, 3, imu=foreign.Imu(np.zeros(3), np.ones(3)), mass=0.15, more=EXACT)
    found = evaluated(tmp_path).imu
    assert found is not None
    assert abs(found.lag_s) < 3.0 * found.lag_std_s
