"""What of a fall of the error is noise that an effect smooths: a spring in front of a noisy acceleration does that.

The sensors' noise is drawn once more and added; what it changes in the rows, without and with the effect, is as large
as what the noise already in them did. An effect that takes no more off the error than off that explains nothing.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from exogauge.identification.model import RobotModel
from exogauge.identification.noise_bias import draw_noise, known_noise, with_noise
from exogauge.identification.preparation import Prepared
from exogauge.identification.settings import Recording
from exogauge.logs.model import Log
from exogauge.search.judge import Judgement
from exogauge.search.site_rows import SiteRows, collect_rows

Array = NDArray[np.float64]


def noise_taken(
    model: RobotModel, judged: Judgement, rows: Sequence[SiteRows], recordings: Sequence[Recording]
) -> float:
    """[(N·m)² or N²] mean square by which noise alone falls in the rows that are shown, over the logs that were judged.

    rows: of the candidate's site, in all logs; recordings: all.
    """
    known = known_noise(model.robot, [each.log for each in recordings], model.cutoff_hz)

    def noisier(log: Log) -> Prepared:
        prepared = model.prepare(log)  # a draw of its own: logs are prepared side by side, in no order
        noise = draw_noise(model.robot, prepared, np.random.default_rng(0), known)
        return with_noise(model.robot, prepared, noise, 1.0, model.at_rest)

    candidate, own = judged.score.candidate, model.equations.columns()
    some = [each for each in recordings if each.log.name in judged.logs]
    again = {each.log: each for each in collect_rows(model, some, [candidate.site], prepared=noisier)[candidate.site]}
    before, after = list[Array](), list[Array]()
    for each in rows:
        noisy = again.get(each.log)
        if noisy is None or judged.kind not in each.rows or judged.kind not in noisy.rows:
            continue
        clean, drawn = (
            (
                one.moved(judged.score.without, own)[judged.kind],
                one.after(columns, judged.score.coefficients, judged.score.step, own)[judged.kind],
            )
            for one, columns in ((one, one.columns(candidate.effect, candidate.shape)) for one in (each, noisy))
        )
        _, here, there = np.intersect1d(
            each.rows[judged.kind].samples, noisy.rows[judged.kind].samples, assume_unique=True, return_indices=True
        )
        before.append(drawn[0][there] - clean[0][here])
        after.append(drawn[1][there] - clean[1][here])
    if not before:
        return 0.0
    return float(np.mean(np.concatenate(before) ** 2) - np.mean(np.concatenate(after) ** 2))
