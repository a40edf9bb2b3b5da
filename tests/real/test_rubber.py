"""Vulcanised rubber in tension (Treloar 1944), 24 points: the nearest real thing to a bench test of an elastic band.

The table gives stretch and stress; a band 0.1 m long with a section of 1 cm² makes lengths and forces of them.
"""

from __future__ import annotations

import csv
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from exogauge.devices.bench import BenchLine, bench_line
from exogauge.devices.device import BenchTest
from exogauge.studies.intake.bench_table import read_bench
from exogauge.studies.intake.bundle import Bundle

TABLE = "treloar1944_uniaxial.csv"
REST_LENGTH, SECTION = 0.1, 1e-4  # m, m²


@pytest.fixture(scope="module")
def bench(recording: Callable[..., Path]) -> BenchTest:
    folder = recording("elastomer_force_stretch", (TABLE,))
    with (folder / TABLE).open() as file:
        rows = list(csv.DictReader(file))
    lines = [
        f"{REST_LENGTH * float(row['stretch']):.9f},{SECTION * 1e6 * float(row['nominal_stress_MPa']):.9f}"
        for row in rows
    ]
    (folder / "bench.csv").write_text("\n".join(["length_m,force_n", *lines]))
    bundle = Bundle(folder, "device.yaml")
    return read_bench(bundle, "bench.csv", False, named_in="device.yaml", column="bench_test", row=None)


def line(bench: BenchTest, shortest: float, longest: float) -> BenchLine:
    """Of the part between two stretches."""
    chosen = [k for k, length in enumerate(bench.length) if shortest <= length / REST_LENGTH <= longest]
    length, force = ([values[k] for k in chosen] for values in (bench.length, bench.force))
    return bench_line(BenchTest(tuple(length), tuple(force), False))


def test_every_point_is_read(bench: BenchTest) -> None:
    assert len(bench.length) == 24
    assert bench.length[-1] == pytest.approx(0.763, abs=0.001)


def test_the_first_line_has_the_modulus_of_the_small_stretch(bench: BenchTest) -> None:
    """1.25 MPa by the recording's description: 1.25e6 · 1e-4 / 0.1 N/m."""
    assert line(bench, 1.0, 1.2).stiffness == pytest.approx(1250.0, rel=0.01)


def test_one_line_through_all_of_it_starts_to_pull_at_the_wrong_length(bench: BenchTest) -> None:
    whole = bench_line(bench)
    assert whole.natural_length > 1.4 * REST_LENGTH


def test_stiffness_depends_on_the_range_by_more_than_three_and_the_std_does_not_say_so(bench: BenchTest) -> None:
    soft, stiff = line(bench, 1.9, 3.2), line(bench, 7.0, 7.7)
    assert stiff.stiffness > 3.0 * soft.stiffness
    assert bench_line(bench).stiffness_std < 0.1 * bench_line(bench).stiffness


def test_up_to_three_times_its_length_a_line_misses_by_a_tenth_of_the_force(bench: BenchTest) -> None:
    part, length, force = line(bench, 1.0, 3.2), np.array(bench.length), np.array(bench.force)
    used = length <= 3.2 * REST_LENGTH
    missed = force[used] - part.stiffness * (length[used] - part.natural_length)
    assert 0.05 < np.sqrt(np.mean(missed**2)) / force[used].max() < 0.15
