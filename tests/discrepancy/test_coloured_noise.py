"""What noise leaves that is seen to grow towards low frequencies is not unexplained; what no sample tells of is."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.signal import lfilter
from tests.discrepancy.conftest import Motion

from exogauge.progress import unwatched
from exogauge.search.baseline import lay_ground
from exogauge.search.declared import within_declared
from exogauge.search.locate import located


def fed_back(share: float, newton_metres: float) -> Callable[[Motion], np.ndarray]:
    """Noise that every sample hands on."""

    def torque(motion: Motion) -> np.ndarray:
        white = np.random.default_rng(int(1e6 * abs(motion.q[0, 0]))).standard_normal(motion.q.shape)
        return np.asarray(lfilter([newton_metres], [1.0, -share], white, axis=0))

    return torque


def waves(motion: Motion) -> np.ndarray:
    """What no sample above the cut-off tells of."""
    return np.outer(0.1 * np.sin(1.7 * np.arange(len(motion.q)) / 200.0), [1.0, 0.0, 0.0])


@pytest.mark.parametrize(("hidden", "within"), [(fed_back(0.7, 0.05), True), (waves, False)])
def test_noise_that_is_seen_to_grow_towards_low_frequencies_is_not_unexplained(study, identified, hidden, within):
    recordings = study(hidden, noise=0.005)
    found = identified(recordings)
    excesses = located(found.model.equations, found, lay_ground(found.model, recordings, (), unwatched).residuals)
    assert excesses
    declared = within_declared(found.model, recordings, excesses)
    assert declared.channels == (excesses if within else ())
    assert declared.sources == (("noise_colour",) if within else ())
