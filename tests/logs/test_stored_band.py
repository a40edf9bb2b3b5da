"""Where spectra end: every effort of a log at once, as one after the other by hand."""

import numpy as np
import pytest
import scipy

from exogauge.logs import stored_band
from exogauge.logs.model import Log
from exogauge.logs.stored_band import _steepest, stored_edges


def efforts(count: int, samples: int = 6000, rate_hz: float = 200.0) -> Log:
    """Noise through a slow pass of first order, each channel through one of its own."""
    rng, time = np.random.default_rng(5), np.arange(samples) / rate_hz
    channels = {}
    for k in range(count):
        values = rng.normal(size=samples)
        for n in range(1, samples):
            values[n] += (0.5 + 0.4 * k / count) * values[n - 1]
        channels[f"i.j{k}"] = values
        channels[f"q.j{k}"] = np.sin(time + k) + 1e-6 * rng.normal(size=samples)
    return Log("one", time, channels)


def by_hand(values: np.ndarray, rate_hz: float) -> tuple[float, float]:
    """(hz, dB) of the steepest fall: medians of all bins within a factor of 1.15, over an octave and a half."""
    frequency, power = scipy.signal.welch(np.diff(values), rate_hz, "blackmanharris", nperseg=1600, detrend="constant")
    level = 10.0 * np.log10(power[1:] / (2.0 * np.sin(np.pi * frequency[1:] / rate_hz)) ** 2)

    def around(hz: float) -> float:
        inside = [y for f, y in zip(frequency[1:], level, strict=True) if hz / 1.15 < f < hz * 1.15]
        near = sorted(zip(np.abs(frequency[1:] - hz), level, strict=True))[:5]
        return float(np.median(inside if len(inside) >= 5 else [y for _, y in near]))

    falls = [(around(hz) - around(hz * 2.0**1.5), hz) for hz in np.geomspace(5.0 * rate_hz / 1600, 0.1 * rate_hz, 60)]
    return max(falls)[1], max(falls)[0]


def test_all_efforts_at_once_fall_as_each_by_itself() -> None:
    log = efforts(5)
    found = _steepest(np.array([log.channels[f"i.j{k}"] for k in range(5)]), log.rate_hz)
    for k, edge in enumerate(found):
        hz, fall = by_hand(log.channels[f"i.j{k}"], log.rate_hz)
        assert edge.hz == pytest.approx(hz, rel=1e-12)
        assert edge.fall_db == pytest.approx(fall, rel=1e-9)


def test_the_spectra_of_a_log_are_made_together_and_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """However many joints: one call for the efforts' edge, one each for the noise of positions and efforts."""
    calls, welch = [], scipy.signal.welch

    def counted(*args: object, **options: object) -> object:
        calls.append(args)
        return welch(*args, **options)

    monkeypatch.setattr(scipy.signal, "welch", counted)
    logs = [efforts(4), efforts(12)]
    stored_edges(logs[:1])
    of_four = len(calls)
    stored_edges(logs[1:])
    assert len(calls) == 2 * of_four <= 6


def test_channels_are_taken_in_parts_where_a_log_is_long(monkeypatch: pytest.MonkeyPatch) -> None:
    log = efforts(7)
    values = np.array([log.channels[f"i.j{k}"] for k in range(7)])
    together = _steepest(values, log.rate_hz)
    monkeypatch.setattr(stored_band, "HELD", 2 * log.samples)
    assert _steepest(values, log.rate_hz) == together
