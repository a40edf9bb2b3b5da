"""What is asked of a candidate on logs that were not fitted. Residuals are made so that every block's gain is known:
with e = -f c, c the candidate's torque, a block's square error falls by (2 f - 1) Σ c²."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import rankdata, wilcoxon

from exogauge.effects.catalogue import shaped_effects
from exogauge.findings.verdict import Why
from exogauge.identification.sites import AxisSite
from exogauge.search.candidates import Candidate
from exogauge.search.judge import apart, judge
from exogauge.search.score import Score
from exogauge.search.site_rows import collect_rows
from exogauge.search.sums import ranks

AXIS = 1
SITE = AxisSite(AXIS)
LOSING, WINNING = 0.49, 5.0  # shares: below one half the square error grows


@pytest.fixture(scope="module")
def case(study, identified):
    """(model, rows of one axis, a score whose coefficient is one and which leaves the baseline alone)."""
    recordings = study()
    model = identified(recordings).model
    candidate = Candidate(shaped_effects()["asym_viscous"], SITE, ())
    score = Score(candidate, 1.0, 100.0, np.ones(1), *np.zeros((2, model.equations.size)), 1.0)
    return model, collect_rows(model, recordings, [SITE])[SITE], score


def torque(score, rows):
    (columns,) = rows.columns(score.candidate.effect, score.candidate.shape).values()
    return columns[:, 0]


def own(rows):
    """The one kind of rows that an axis has."""
    (found,) = rows.rows.values()
    return found


def with_own(rows, **changed):
    (kind,) = rows.rows
    return replace(rows, rows={kind: replace(own(rows), **changed)})


def blocks(rows):
    """(n,) number of the second that each row lies in."""
    return np.unique(np.floor(rows.time[own(rows).samples]), return_inverse=True)[1]


def weight(case):
    model, rows, _ = case
    (kind,) = rows[0].rows
    return model.solution.weights[kind]


def test_a_site_that_is_named_twice_has_its_rows_once(study, case):
    """Or what was gained there would count twice: evidence is a sum over rows."""
    model, once, _ = case
    (twice,) = collect_rows(model, study(), [SITE, SITE]).values()
    assert [each.log for each in twice] == [each.log for each in once]
    assert [len(own(each).e) for each in twice] == [len(own(each).e) for each in once]


def with_share(case, share, fitted=1.0):
    """The rows with residuals of which the candidate explains `share` (n,) of its own torque on the held-out log."""
    _, rows, score = case
    return [
        with_own(each, e=-torque(score, each) * (share(each) if each.held_out else fitted * np.ones(len(own(each).e))))
        for each in rows
    ]


def with_gains(case, gains):
    """Held-out rows whose blocks gain what `gains` (count) -> (count,) says."""
    _, rows, score = case
    (out,) = [each for each in rows if each.held_out]
    energy = np.bincount(blocks(out), torque(score, out) ** 2)
    wanted = gains(len(energy))
    return with_share(case, lambda each: 0.5 * (wanted / energy + 1.0)[blocks(each)]), wanted


def test_sureness_is_that_of_the_mean_where_the_mean_says_more(case):
    model, _, score = case
    rows, gains = with_gains(case, lambda n: 1.0 + 0.02 * np.sin(np.arange(n)))
    found = judge(model, score, rows)
    np.testing.assert_allclose(list(found.blocks.values()), weight(case) * gains, rtol=1e-9)
    assert found.z == pytest.approx(gains.mean() / (gains.std(ddof=1) / np.sqrt(len(gains))), rel=1e-6)
    assert found.z > abs(wilcoxon(gains, method="approx", correction=False).zstatistic)
    assert found.objection is None


def test_sureness_is_that_of_the_ranks_where_a_few_blocks_gain_much_more(case):
    model, _, score = case
    rows, gains = with_gains(case, lambda n: np.where(np.arange(n) < 2, 300.0, 1.0) * (1.0 + 0.001 * np.arange(n)))
    found = judge(model, score, rows)
    ranks = abs(wilcoxon(gains, method="approx", correction=False).zstatistic)  # all blocks gain
    assert abs(gains.mean() / (gains.std(ddof=1) / np.sqrt(len(gains)))) < 2.5
    assert found.z == pytest.approx(ranks, rel=1e-6)
    assert found.objection is None


def test_gains_that_come_and_go_are_not_sure(case):
    model, _, score = case
    rows, _ = with_gains(case, lambda n: 0.3 + np.where(np.arange(n) % 2, 1.2, -1.0))
    found = judge(model, score, rows)
    assert 0.0 < found.z < 3.0
    assert found.explained > 0.0
    assert found.objection.why in (Why.NOT_SURE, Why.LITTLE)


def test_what_explains_next_to_nothing_is_not_worth_a_name(case):
    model, _, score = case
    found = judge(model, score, with_share(case, lambda each: np.full(len(own(each).e), 50.0)))
    assert found.explained == pytest.approx(1.0 - (49.0 / 50.0) ** 2)
    assert found.objection.why is Why.LITTLE


def test_one_block_of_the_fitted_logs_is_not_enough(case):
    model, _, score = case
    fitted = with_share(case, lambda each: np.ones(len(own(each).e)))
    once = [
        each if each.held_out else with_own(each, e=np.where(blocks(each) == 4, 9.0, 0.5) * own(each).e)
        for each in fitted
    ]
    found = judge(model, score, once)
    assert found.z > 3.0
    assert found.z_fitted < 2.5
    assert found.objection.why is Why.FEW_MOMENTS


REGIMES = [
    ("negative_motion", lambda v, scale: v < 0.0),
    ("positive_motion", lambda v, scale: v > 0.0),
    ("high_speed", lambda v, scale: np.abs(v) > 1.2 * scale),
]


@pytest.mark.parametrize(("name", "inside"), REGIMES)
def test_a_regime_that_gets_worse_is_an_objection(case, name, inside):
    model, _, score = case

    def share(rows):
        signals = rows.seen.signals
        worse = inside(signals.velocity[own(rows).samples], signals.speed_scale)
        return np.where(worse, LOSING, WINNING)

    found = judge(model, score, with_share(case, share))
    assert found.z > 3.0
    assert (found.objection.why, found.objection.of) == (Why.WORSE, (name,))


def test_a_few_seconds_are_too_little_to_judge(case):
    model, _, score = case
    made = with_share(case, lambda each: np.ones(len(own(each).e)))
    few = []
    for each in made:
        rows = own(each)
        part = blocks(each) < 4 if each.held_out else np.ones(len(rows.e), dtype=bool)
        few.append(with_own(each, samples=rows.samples[part], A=rows.A[part], e=rows.e[part]))
    objection = judge(model, score, few).objection
    assert objection.why is Why.TOO_SHORT
    assert 0.0 <= objection.value < objection.beside == 5.0


def test_without_held_out_rows_there_is_no_number_and_an_objection(case):
    model, _, score = case
    found = judge(model, score, [each for each in with_share(case, lambda each: 1.0) if not each.held_out])
    assert np.isnan(found.before)
    assert found.objection.why is Why.TOO_SHORT


def test_rms_errors_are_those_of_the_rows(case):
    model, _, score = case
    rows = with_share(case, lambda each: np.full(len(own(each).e), 3.0))
    (out,) = [each for each in rows if each.held_out]
    size = np.sqrt(np.mean(torque(score, out) ** 2))
    found = judge(model, score, rows)
    assert (found.before, found.after) == (pytest.approx(3.0 * size), pytest.approx(2.0 * size))


def test_two_candidates_are_apart_by_what_their_blocks_differ(case):
    model, _, score = case
    first, second = (
        judge(model, score, with_gains(case, lambda n, level=level: level + 0.1 * np.sin(np.arange(n)))[0])
        for level in (2.0, 1.0)
    )
    noisy = judge(model, score, with_gains(case, lambda n: 2.0 + np.where(np.arange(n) % 2, 1.0, -1.0))[0])
    assert apart(first, second) > 3.0
    assert apart(second, first) == pytest.approx(-apart(first, second))
    assert abs(apart(first, noisy)) < 2.0


def test_a_run_s_own_criteria_are_asked(case):
    model, _, score = case
    rows, _ = with_gains(case, lambda n: 1.0 + 0.02 * np.sin(np.arange(n)))
    found = judge(model, score, rows)
    assert found.objection is None
    judging = replace(model.criteria.judging, sure=1.01 * found.z)
    strict = replace(model, criteria=replace(model.criteria, judging=judging))
    assert judge(strict, replace(score, evidence=1.0), rows).objection.why is Why.NOT_SURE


@pytest.mark.parametrize("decimals", [0, 1, 8])
def test_ranks_are_scipys_where_values_are_equal_too(decimals):
    values = np.abs(np.random.default_rng(decimals).normal(size=40)).round(decimals)
    np.testing.assert_array_equal(ranks(values), rankdata(values))
