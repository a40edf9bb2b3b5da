"""`make bench`, or `python -m tests.bench [--quick]`. Every figure is CPU time of one run, one BLAS thread."""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before numpy is imported

import argparse
import sys
import tempfile
import time
from pathlib import Path

from tests.bench import band_fit, bands, candidates, excite, live, memory, motion, payload, product, speed
from tests.bench.figaroh_rival import PYTHON
from tests.bench.problems import RATE_HZ, make

ROBOTS = {"Talos": (40000, 5000), "Panda": (60000, 4000), "UR5": (60000, 4000)}  # samples for ours, for the usual ways
HOUR, CSV_SECONDS, CSV_COLUMNS = 3600.0, 300.0, 120


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.bench", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="small logs, one repeat: do the answers agree?")
    quick = parser.parse_args().quick
    began = time.perf_counter()
    if not PYTHON.exists():
        print("figaroh is not installed (`make bench` installs it into .venv-bench): its rows are left out")
    worst = 0.0
    with tempfile.TemporaryDirectory() as folder:
        for name, (samples, short) in ROBOTS.items():
            problem = make(name, samples // 20 if quick else samples)
            measured = speed.measure(problem, short // 4 if quick else short, 1 if quick else 5, Path(folder))
            report_speed(measured)
            worst = max(worst, *measured.difference.values())
        apart = report_bands(quick)
        fits_apart = report_band_fit(quick)
        if not quick:
            report_product(Path(folder))
            report_memory()
            report_candidates()
            report_live()
            payload.report()
            motion.report()
            excite.report()
    print(f"\n{time.perf_counter() - began:.0f} s in all; estimates differ by at most {worst:.0e} of the largest")
    if worst > speed.AGREEMENT:
        print(f"THE ANSWERS DISAGREE: more than {speed.AGREEMENT:g}", file=sys.stderr)
        return 1
    if apart > bands.AGREEMENT:
        print(f"THE BANDS DISAGREE: more than {bands.AGREEMENT:g} m or m/rad", file=sys.stderr)
        return 1
    if fits_apart > band_fit.AGREEMENT:
        print(f"THE BAND FITS DISAGREE: more than {band_fit.AGREEMENT:g} of a parameter", file=sys.stderr)
        return 1
    return 0


def report_speed(measured: speed.Speeds) -> None:
    against = [
        way for way in ("pin + stack + lstsq", "pin + normal equations", "figaroh, its decimation",
                        "figaroh, every sample") if way in measured.rate
    ]  # fmt: skip
    print(f"\n{measured.name}: from log to base parameters, samples per CPU second")
    for way, rate in measured.rate.items():
        answer = f"   differs by {measured.difference[way]:.0e}" if way in measured.difference else ""
        print(f"  {way:26s}{rate:12,.0f}{answer}")
    ratios = ", ".join(f"{measured.rate['ours'] / measured.rate[other]:.1f} x {other}" for other in against)
    print(f"  ours = {ratios}")
    g, d = measured.gflops["gram"], measured.gflops["dgemm"]
    print(f"  Gram stage {g:.1f} GFLOP/s = {g / d:.0%} of this machine's dgemm ({d:.1f})")


def report_bands(quick: bool) -> float:
    """The largest difference from pinocchio [m, m/rad]."""
    samples, short = (20_000, 100) if quick else (1_000_000, 2000)
    measured = bands.measure(samples, short, 1 if quick else 3)
    print(f"\nTalos, 4 bands of 8 via points: lengths and Jacobians, {samples:,} samples, per CPU second")
    for way, rate in measured.rate.items():
        answer = f"   differs by {measured.difference[way]:.0e}" if way in measured.difference else ""
        print(f"  {way:26s}{rate:12,.0f}   {rate / measured.rate['pin loop']:6.0f} x pin loop{answer}")
    if not quick:
        for samples in (10_000, 1_000_000):
            print(f"  {samples:9,d} samples{bands.memory(samples):8.1f} MB added")
    return max(measured.difference.values())


def report_band_fit(quick: bool) -> float:
    """The largest relative difference from scipy's solution."""
    samples = 2_000 if quick else 100_000
    measured = band_fit.measure(samples, 1 if quick else 3)
    theirs = measured.seconds["scipy least_squares"]
    print(f"\nTwo stiffnesses and four natural lengths from {samples:,} samples of the joints they act on, CPU seconds")
    for way, spent in measured.seconds.items():
        print(f"  {way:26s}{spent:12.3f}   {theirs / spent:6.1f} x faster than scipy")
    print(f"  parameters differ by {measured.difference:.0e}")
    return measured.difference


def report_product(folder: Path) -> None:
    measured = product.measure(make("Talos", 8000), 5)
    print(f"\nTalos with 5 effects per joint and 2 foot sensors, {measured.parameters} parameters")
    print(f"  pass{measured.rate:34,.0f} samples per CPU second")
    print(f"  one re-weighting iteration after the pass {measured.iteration_ms:.1f} ms, whatever the log's length")
    seconds = product.from_csv(make("Talos", int(CSV_SECONDS * RATE_HZ)), CSV_COLUMNS, folder)
    scale = HOUR / CSV_SECONDS
    print(
        f"  {CSV_COLUMNS} columns at {RATE_HZ:.0f} Hz from CSV, {CSV_SECONDS / 60:.0f} min measured, times {scale:.0f}"
    )
    for stage, spent in seconds.items():
        fixed = stage == "weights and solution"
        print(f"    {stage:26s}{spent * (1.0 if fixed else scale):8.2f} CPU s per hour of log")


def report_memory() -> None:
    print("\nTalos: memory that a pass adds")
    for samples in (10_000, 100_000, 1_000_000):
        print(f"  {samples:9,d} samples{memory.measure(samples):8.1f} MB")


def report_candidates() -> None:
    found = candidates.measure(4000)
    each = 100.0 * found.scored / found.candidates
    print(f"\nTalos, {found.joints} joints, {found.samples:,} samples: {found.candidates} candidate effects")
    print(f"  identified once{found.identified:23.2f} CPU s")
    print(f"  pass with all candidates' columns{found.passed:5.2f} CPU s")
    print(f"  100 candidates, baseline fitted again beside each{1e3 * each:8.1f} ms")
    print(f"  = {found.identified * 100.0 / each:,.0f} x quicker than identifying again with each")


def report_live() -> None:
    found = live.loops(1.0)
    print("\nA live stream of a payload: six joints at 250 Hz, CPU time per sample")
    print(f"  six filters and kinematics, with slopes{found.tracked:8.1f} µs")
    print(f"  six rows, their covariance, recursion{found.updated:10.1f} µs")
    print(f"  everything, 250 samples at once{found.all:16.1f} µs")
    print(f"  memory added over {found.hours:g} h{found.grown_mb:22.1f} MB")
    p50, p99 = live.echo(10.0)
    print(f"  a bare websocket that echoes, 10 s: {p50:.2f} ms, 99 % in {p99:.1f} ms")
    for streams in (1, 8):
        line = live.through(streams, 10.0)
        waited = f"from sample to wrench {line.p50:.2f} ms, 99 % in {line.p99:.1f} ms"
        used = f"{line.core:.0%} of a core each, {line.unanswered} unanswered"
        print(f"  {streams} through the service, 10 s: {waited}; {used}")


if __name__ == "__main__":
    sys.exit(main())
