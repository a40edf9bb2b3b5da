"""From a log to base parameters: ours against the usual ways on the same log, and against the machine's own dgemm."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import final

import numpy as np
import scipy.linalg as sl
from numpy.typing import NDArray
from tests.bench import ours, usual
from tests.bench.figaroh_rival import PYTHON, Figaroh
from tests.bench.problems import Problem
from tests.bench.timing import in_turns, seconds_of

Array = NDArray[np.float64]

AGREEMENT = 1e-6  # largest difference of any base parameter, relative to the largest


@final
@dataclass
class Speeds:
    """rate: samples per CPU second by way. difference: of the estimates from stack + lstsq, by way.

    gflops: `dgemm`, and the Gram stage (`gram`) of the compiled pass. gram_seconds: per sample.
    """

    name: str
    rate: dict[str, float]
    difference: dict[str, float]
    gflops: dict[str, float] = field(default_factory=dict)


def measure(problem: Problem, short: int, repeats: int, folder: Path) -> Speeds:
    """short: samples for the usual ways, whose time is in proportion to the samples; ours take the whole log."""
    brief = problem.first(short)
    rows = ours.rows_of(problem)
    rivals = {
        "pin regressor alone": seconds_of(lambda: usual.regressor_loop(brief)),
        "pin + stack + lstsq": seconds_of(lambda: usual.stack_and_lstsq(brief)),
        "pin + normal equations": seconds_of(lambda: usual.normal_equations(brief)),
        "ours, rows alone": seconds_of(lambda: ours.fill_only(problem, rows)),
        "ours": seconds_of(lambda: ours.identify(problem, rows)),
        "dgemm": seconds_of(_multiply),
        "gram": seconds_of(lambda: _gram(blocks)),
    }
    blocks = rows.fill(problem.motion.rows(slice(0, ours.chunk(rows))), 1)
    whole = {name for name in rivals if name.startswith("ours")}
    reference = usual.stack_and_lstsq(brief)
    answers = {
        "pin + normal equations": usual.normal_equations(brief),
        "ours": ours.identify(brief, rows),
    }
    difference = {name: _relative(answer, reference) for name, answer in answers.items()}
    if problem.tree.floating or not PYTHON.exists():
        seconds = in_turns(rivals, repeats)
    else:
        with Figaroh(brief, folder) as figaroh:
            modes = {"figaroh, every sample": "full", "figaroh, its decimation": "decimated"}
            seconds = in_turns(rivals | {name: figaroh.run(mode) for name, mode in modes.items()}, repeats)
            difference["figaroh, every sample"] = figaroh.difference("full", brief, reference)
    flops = {"dgemm": 2.0 * SIDE**3 * PRODUCTS, "gram": _flops(problem, blocks)}
    gflops = {name: 1e-9 * count / seconds.pop(name) for name, count in flops.items()}
    rate = {name: (problem.samples if name in whole else short) / spent for name, spent in seconds.items()}
    return Speeds(problem.name, rate, difference, gflops)


SIDE, PRODUCTS = 600, 20  # of the dgemm that shows what the machine can do
_SQUARE = np.asfortranarray(np.random.default_rng(0).normal(size=(SIDE, SIDE)))


def _multiply() -> None:
    for _ in range(PRODUCTS):
        sl.blas.dgemm(1.0, _SQUARE, _SQUARE)


GRAMS = 10  # times one chunk


def _gram(blocks: list[Array]) -> None:
    """The dsyrk of every row kind of one chunk, as `Statistics.add_rows` calls it."""
    for block in blocks:
        gram = np.zeros((block.shape[1], block.shape[1]), order="F")
        for _ in range(GRAMS):
            gram = sl.blas.dsyrk(1.0, block, beta=1.0, c=gram, trans=1, overwrite_c=1)


def _flops(problem: Problem, blocks: list[Array]) -> float:
    """Of `_gram`: half of a product, with its diagonal."""
    return float(sum(GRAMS * len(block) * block.shape[1] * (block.shape[1] + 1) for block in blocks))


def _relative(answer: Array, reference: Array) -> float:
    return float(np.abs(answer - reference).max() / np.abs(reference).max())
