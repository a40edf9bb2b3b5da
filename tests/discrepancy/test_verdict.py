"""Whatever was found, all who tell of it say the same, and nobody more than the numbers beside it."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from exogauge.criteria.judging import Judging
from exogauge.devices.result import Estimate
from exogauge.effects.catalogue import shaped_effects
from exogauge.findings.basis import OfRobot
from exogauge.findings.result import (
    ChainStep,
    Discrepancy,
    Evidence,
    Excess,
    Finding,
    HeldOut,
    Link,
    Place,
    WithinDeclared,
)
from exogauge.findings.verdict import Caveat, Facts, Seen, decide
from exogauge.studies.report.discrepancy_section import discrepancy_view
from exogauge.studies.results.comparison import verdict
from exogauge.studies.results.discrepancy_results import discrepancy_entry
from exogauge.studies.results.plain_values import finite
from exogauge.studies.words.reason_sentences import reason_words

JUDGING = Judging()

NOTHING = (
    "No effect is missing",
    "No effect that matters is missing",
    "Nothing is left above the noise",
    "stand at their noise floors",
)
JOINTS = [f"tau.j{number}" for number in range(4)] + ["base.fz", "ft.wrist.fx", "support.j1"]

ratios = st.one_of(st.floats(0.5, 30.0), st.just(math.nan))
seconds = st.floats(0.0, 60.0)
seen = st.builds(Seen, st.sampled_from(JOINTS), ratios, seconds, seconds)


def finding(rank: int) -> Finding:
    return Finding(
        rank, "stribeck", Place("joint", f"j{rank}"), {"tau_b": Estimate(1.0, 0.1, "N·m")},
        HeldOut(f"tau.j{rank}", "N·m", 2.0, 1.0, 0.9), 0.9, OfRobot(shaped_effects()["stribeck"]), (), (),
        Evidence("", "", *([[]] * 5)),
    )  # fmt: skip


@st.composite
def discrepancies(draw: st.DrawFn) -> Discrepancy:
    """What a search may hand on: any number of findings, any channel anywhere."""
    channels = draw(st.lists(seen, max_size=5, unique_by=lambda each: each.channel))
    far = [each for each in channels if each.ratio >= JUDGING.above]
    sure = draw(st.lists(st.sampled_from(far), unique=True)) if far else []
    above = tuple(Excess(each.channel, "N·m", each.ratio, 1.0, 4.0) for each in sure)
    worst = draw(st.floats(0.5, 30.0))
    end = Link(ChainStep("robot"), worst, 1.0, "tau.j0", worst, 1.0)
    named = tuple(finding(rank) for rank in range(1, 1 + draw(st.integers(0, 2))))
    cannot = draw(st.sampled_from([(), (Caveat("no_steady_motion", "suit"),)]))
    others = tuple(Excess(each.channel, "N·m", each.ratio, 1.0, 4.0) for each in far if each not in sure)
    declared = draw(st.sampled_from([WithinDeclared(), WithinDeclared(others, ("ft_zero", "ft_gain"))]))
    links = (end,) if draw(st.booleans()) else ()
    rest = {"seen": tuple(channels), "cannot": cannot, "declared": declared}
    return Discrepancy(named, links, (), above, (), (), 100, (), (), **rest)


def told(found: Discrepancy) -> tuple[dict[str, Any], dict[str, str]]:
    """results.json's entry, and what each who shows it says."""
    entry: Any = finite(discrepancy_entry(found))
    fits = [{"channel": each.channel, "log": "v", "held_out": True} for each in found.seen]
    content = {"discrepancy": entry, "identification": {"validation": fits}}
    view = discrepancy_view(replace(found, chain=(), findings=()), content)
    assert view is not None
    says = {
        "report": f"{view.sentence} {view.left} {'All stand at their noise floors' if view.at_floor else ''}",
        "page": f"{entry['sentence']} {entry['left_sentence']}",
    }
    assert verdict(content)["verdict"] == view.verdict == entry["verdict"]
    return entry, says


@given(discrepancies())
def test_no_two_renderers_contradict_each_other_or_the_numbers(found: Discrepancy) -> None:
    entry, says = told(found)
    claims_nothing = {who: any(words in text for words in NOTHING) for who, text in says.items()}
    judged = [each for each in found.seen if math.isfinite(each.ratio)]
    ends = [link.worst_rmse / link.worst_floor for link in found.chain]
    if max([each.ratio for each in judged] + ends, default=0.0) >= JUDGING.above or found.unexplained or found.cannot:
        assert not any(claims_nothing.values()), says
    if any(each.moved_s >= JUDGING.needed_s > each.steady_s for each in found.seen) or not found.seen:
        assert not any(claims_nothing.values()), says
    if entry["verdict"] == "none":
        assert all(claims_nothing.values())
    for who in says:
        assert (" undecided" in says[who]) is (entry["left"] == "open"), says[who]
        assert ("does not know of" in says[who]) is bool(found.findings)
        assert entry["reason"].partition(": ")[2] in says[who]


@given(discrepancies())
def test_effects_are_named_if_and_only_if_there_are_findings(found: Discrepancy) -> None:
    assert (found.verdict == "effects") is bool(found.findings)
    assert (found.verdict == "unexplained") is (bool(found.unexplained) and not found.findings)
    assert bool(found.decision.reason) is (found.decision.left == "open")


def test_a_channel_far_above_its_floor_is_never_nothing_however_little_was_seen_of_it() -> None:
    """A gap of 21 noise floors in four samples was called nothing above the noise."""
    for steady_s in (0.02, 4.0, 400.0):
        found = decide(Facts(0, (), (Seen("tau.j1", 21.0, steady_s, 400.0), Seen("tau.j2", 1.0, 40.0, 400.0))))
        assert found.verdict == "undecided"
    found = decide(Facts(0, (), (Seen("tau.j2", 1.0, 40.0, 400.0),), told=(21.0,)))
    assert found.verdict == "undecided"


def test_what_is_asked_for_and_what_there_was_is_told_in_seconds() -> None:
    found = decide(Facts(0, (), (Seen("tau.j1", 1.0, 1.2, 30.0), Seen("tau.j2", 1.0, 40.0, 60.0))))
    assert found.verdict == "undecided"
    assert "1.2 of 5 s of steady held-out motion at j1" in reason_words(found.reason)


def test_a_joint_that_never_moves_is_not_asked_for_motion() -> None:
    """A humanoid that stands and moves its arms says nothing of its legs, and what is said is about its arms."""
    still, moves = Seen("tau.leg", math.nan, 0.0, 0.0), Seen("tau.arm", 1.0, 12.0, 60.0)
    assert decide(Facts(0, (), (still, moves))).verdict == "none"
    assert decide(Facts(0, (), (still,))).verdict == "undecided"
