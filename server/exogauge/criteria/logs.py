"""How logs are read and filtered, and what their signals show. No run may have other numbers: logs are read, and
kept in one form, before any run asks for them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from exogauge.criteria.criterion import criterion, derived, judgement

READING = "server/exogauge/logs, docs/mapping.md"
NOISE = "server/exogauge/logs/noise.py"
STORED = "docs/decisions/0011-rules-of-single-effects.md, stored low-passes"


@final
@dataclass(frozen=True)
class Logs:
    """Of files, clocks, noise, bandwidth, and the band in which a log was stored."""

    most_bytes: int = criterion(2_000_000_000, "bytes", "of one file of a log", judgement(READING))
    most_cells: int = criterion(
        250_000_000,
        "values",
        "of one log: an hour at 1 kHz with 69 channels",
        derived("2 GB as float64: 250e6 x 8 bytes"),
    )
    most_columns: int = criterion(4096, "columns", "of one table: no robot has so many channels", judgement(READING))
    fewest_samples: int = criterion(
        10, "samples", "of a log: a difference of 6th order takes seven", judgement(READING)
    )
    largest: float = criterion(
        1e30,
        "1",
        "that a value may be, in the file's own unit: beyond any reading, and its square is still a number",
        judgement(READING),
    )
    most_faults: int = criterion(20, "faults", "of one file that are told: nobody reads on", judgement(READING))
    rotation: float = criterion(
        1e-4, "1", "by which R R' may differ from one: a matrix that was printed with four digits", judgement(READING)
    )
    tiny: float = criterion(
        0.25, "periods", "no timer fires again so soon, so such messages had waited", judgement(READING)
    )
    tiny_share: float = criterion(0.1, "1", "of all steps: so many tiny ones are no single hiccup", judgement(READING))
    envelope: float = criterion(
        1.5, "periods", "by which the clock may move: more is a gap, or rows that are there twice", judgement(READING)
    )
    even: float = criterion(
        0.02, "periods", "stamps closer than that to an even clock are even: printed decimals", judgement(READING)
    )
    in_motion: float = criterion(
        0.1, "of the rate", "below it is the motion whose velocity tells a sample's time", judgement(READING)
    )
    above_motion: float = criterion(
        0.25, "of the rate", "above it is no motion, so jitter and noise alone are seen there", judgement(READING)
    )
    nearly: float = criterion(
        0.25,
        "1",
        "of the stamps' jitter by which what positions follow may miss all of it, or nothing: else both may jitter",
        judgement(READING),
    )
    surely: float = criterion(
        5.0,
        "std",
        "from the other reading, for it to be said whether samples jitter or their stamps",
        judgement(READING),
    )
    longest_gap: float = criterion(5.0, "periods", "that interpolation may bridge", judgement(READING))
    anti_alias: float = criterion(
        0.4, "1", "of the new rate, when going down: a tenth below half of it", judgement(READING)
    )
    late: float = criterion(
        1.5, "periods", "from here on a sample is missing between two", derived("half way from one step to two")
    )
    shortest_part_s: float = criterion(
        2.0,
        "s",
        "of a recording: a low-pass of 2 Hz, the lowest that is chosen, leans on half a second at either end",
        judgement(READING),
    )
    joined: float = criterion(
        0.5, "periods", "by which the clock may be off from one part to the next", derived("half a step")
    )
    slowest_hz: float = criterion(
        1.0, "Hz", "that a cut-off is suggested at", judgement("server/exogauge/logs/bandwidth.py")
    )
    fastest: float = criterion(
        0.2,
        "of the sampling rate",
        "the highest cut-off: the second derivative is still better than 1 % there",
        derived("response of the differences: 1 % at 0.223"),
    )
    floor_band: tuple[float, float] = criterion(
        (0.3, 0.45),
        "of the sampling rate",
        "where a position holds nothing but noise",
        judgement("server/exogauge/logs/bandwidth.py"),
    )
    fast_joints: float = criterion(
        0.75, "quantile", "of the joints decides the bandwidth", judgement("server/exogauge/logs/bandwidth.py")
    )
    round_off: float = criterion(
        1e-9, "relative", "what varies less does not vary", judgement("server/exogauge/logs/bandwidth.py")
    )
    false_alarm: float = criterion(
        1e-3,
        "probability",
        "that noise alone is taken for motion, per joint",
        judgement("server/exogauge/logs/bandwidth.py"),
    )
    rounded: float = criterion(
        3.0, "1", "times what rounding leaves of itself, from which noise behind a low-pass is seen", judgement(NOISE)
    )
    fallen: tuple[float, float, float] = criterion(
        (0.1, 0.03, 0.01),
        "of an amplitude",
        "left by a stored low-pass: beyond, noise is sought",
        judgement(NOISE),
    )
    least_s: float = criterion(4.0, "s", "of a log in which nothing jumps, to judge noise by", judgement(NOISE))
    few_levels: int = criterion(
        20, "values", "with fewer distinct ones a lattice could be chance: then values must repeat", judgement(NOISE)
    )
    undone: tuple[float, float, float] = criterion(
        (0.03, 0.1, 0.3),
        "of an amplitude",
        "where a low-pass has left less, it is not undone",
        judgement("server/exogauge/logs/undoing.py"),
    )
    rounding_above: float = criterion(
        0.25,
        "of the sampling rate",
        "there a stored position holds nothing but rounding",
        judgement("server/exogauge/logs/undoing.py"),
    )
    quiet: float = criterion(
        3e-4,
        "of the top speed",
        "the most noise that undoing may make of rounding",
        judgement("server/exogauge/logs/undoing.py"),
    )
    shortest_spectrum: int = criterion(512, "samples", "below, a spectrum shows no edge", judgement(STORED))
    resolved: float = criterion(
        5.0, "bins", "of a spectrum: what lies below is the window's own width", judgement(STORED)
    )
    octaves: float = criterion(1.5, "octaves", "over which the fall of a spectrum is seen", judgement(STORED))
    fall_db: float = criterion(
        50.0,
        "dB",
        "in those; friction that turns round falls by 9, as it builds up over a short way by 27 at most",
        judgement(STORED),
    )
    like_others_db: float = criterion(40.0, "dB", "the same of a log whose fellows end", judgement(STORED))
    level: float = criterion(
        1.15, "1", "half width, as a factor, of what one level is the median of", judgement(STORED)
    )
    highest_edge: float = criterion(
        0.1,
        "of the sampling rate",
        "an edge above is the anti-aliasing that every log should have",
        judgement(STORED),
    )
    alike_share: float = criterion(0.5, "1", "of a log's varying efforts that must end alike", judgement(STORED))
    alike_edges: float = criterion(2.0, "1", "ratio of their edges", judgement(STORED))
    noise_low: tuple[float, float] = criterion(
        (0.1, 0.15), "of the sampling rate", "far above any motion: noise is all there is", judgement(STORED)
    )
    noise_high: tuple[float, float] = criterion(
        (0.3, 0.45), "of the sampling rate", "the same, higher up: noise that is white falls by 0", judgement(STORED)
    )
    noise_fall_db: float = criterion(
        10.0,
        "dB",
        "from the one to the other; a pass of first order makes it fall by 15, white noise by 0",
        judgement(STORED),
    )


LOGS = Logs()
