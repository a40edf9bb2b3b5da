"""What the search for missing effects costs on Talos: one pass over the logs, then a small solve for each candidate."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import final

from tests.bench.problems import make
from tests.bench.study import CUTOFF_HZ, log_of, robot_of

from exogauge.effects.catalogue import missing_effects
from exogauge.identification.identify import identify
from exogauge.identification.settings import Recording, Settings
from exogauge.progress import unwatched
from exogauge.search.baseline import candidates_at, lay_ground, pass_over, ranked


@final
@dataclass(frozen=True)
class Searched:
    """CPU seconds. joints, samples: of the log. candidates: with every shape of the grid. identified: the robot once;
    passed: columns of all candidates and their sums; scored: all of them, the baseline fitted again beside each."""

    joints: int
    samples: int
    candidates: int
    identified: float
    passed: float
    scored: float


def measure(samples: int) -> Searched:
    problem = make("Talos", samples)
    recordings = [Recording(log_of(problem), held_out=False)]
    start = time.process_time()
    model = identify(robot_of(problem), recordings, Settings(cutoff_hz=CUTOFF_HZ)).model
    identified = time.process_time() - start
    model.solution.unbounded  # noqa: B018 (made once, and kept)
    baseline = lay_ground(model, recordings, missing_effects(), unwatched).baseline  # and its caches are warm
    start = time.process_time()
    tried = candidates_at(model, recordings, missing_effects(), None, None)
    _, sums, _ = pass_over(model, recordings[0], tried)
    passing = time.process_time() - start
    start = time.process_time()
    ranked(baseline, tried, sums)
    scored = time.process_time() - start
    count = sum(map(len, tried.values()))
    return Searched(len(model.robot.joints), samples, count, identified, passing, scored)
