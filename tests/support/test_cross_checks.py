"""Parts of the same evidence that ought to agree: they do where nothing is wrong, and else it is told."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from exogauge.criteria.supporting import Supporting
from exogauge.devices.device import Device
from exogauge.devices.routing import Routing
from exogauge.remarks import About
from exogauge.support.cross_checks import HARD, LENGTHENING, SOFT, WITHOUT, judged
from exogauge.support.stiffness import identify_bands

SIGMA = np.array([0.3, 0.3])
NAMES = ["torso_pitch", "torso_yaw"]


def stiffer(device: Device, *factors: float) -> Device:
    bands = zip(device.bands, factors, strict=True)
    return replace(device, bands=tuple(replace(band, stiffness=band.stiffness * by) for band, by in bands))


@pytest.fixture(scope="module")
def checked(biped, suit, stoop, wander, make_evidence):
    """The judged result, from logs of devices, with coloured noise; change: of the evidence of each log."""
    blank = replace(suit, bands=tuple(replace(b, stiffness=None, natural_length=None) for b in suit.bands))

    def check(devices, noise=0.3, seed=0, change=lambda number, evidence: evidence, sigma=SIGMA):
        evidences = []
        for number, device in enumerate(devices):
            made = make_evidence(device, stoop(number), noise=noise, seed=seed + 100 * number)
            made = replace(made, worn=replace(made.worn, log=replace(made.worn.log, name=f"log_{number}")))
            evidences.append(change(number, made))
        found = identify_bands(biped.known(), blank, "A", evidences, sigma, [], NAMES)
        return judged([found], Supporting())[0]

    return check


def failed(found):
    return {each.check for each in found.cross_checks if not each.agrees}


@pytest.mark.slow
def test_where_nothing_is_wrong_no_check_fails_and_z_is_of_unit_size(checked, suit):
    z = []
    for seed in range(20):
        found = checked([suit, suit, suit], seed=1000 * seed)
        assert {each.check for each in found.cross_checks} == {
            "repetitions",
            "halves",
            "strokes",
            "pulls",
            "relaxation",
            "sides",
            "misfit",
        }
        assert not failed(found)
        assert all(band.identifiable for band in found.bands)
        z += [each.z for each in found.cross_checks if each.check != "misfit"]
    assert 0.5 < np.sqrt(np.mean(np.square(z))) < 1.4


def test_a_log_in_which_the_bands_are_stiffer_contradicts_the_others(checked, suit):
    found = checked([suit, suit, stiffer(suit, 1.5, 1.5)])
    assert "repetitions" in failed(found)
    worst = max(found.cross_checks, key=lambda each: abs(each.z))
    assert worst.between == ("log_2", "others")
    assert worst.difference == pytest.approx(0.5 * 1500.0, rel=0.3)
    for band in found.bands:
        assert not band.identifiable
        assert band.note.about == About.REPETITIONS_DISAGREE


@pytest.mark.slow
def test_a_band_that_slips_within_a_log_is_told_with_log_and_size(checked, suit, biped):
    """The first band by 15 mm, half-way through one of two logs. The size is that of one step from the common fit."""
    routing, band = Routing(biped.robot.tree, suit.bands), suit.bands[0]

    def slipped(number, evidence):
        jacobian = routing.geometry(evidence.posture).jacobian[:, 0]
        stretch = np.maximum(evidence.length[:, 0] - band.natural_length, 0.0)
        less = stretch - np.maximum(evidence.length[:, 0] - band.natural_length - 0.015, 0.0)
        late = evidence.time - evidence.time[0] > 0.5 * np.ptp(evidence.time)
        more = np.where(late & (number == 1), band.stiffness * less, 0.0)
        return replace(evidence, a=evidence.a + jacobian * more[:, None])

    found = checked([suit, suit], noise=0.1, change=slipped)
    worst = max(found.cross_checks, key=lambda each: abs(each.z))
    assert (worst.check, worst.unit, worst.agrees) == ("halves", "m", False)
    assert worst.between == (f"{band.name}, first half of log_1", "second half")
    assert worst.difference == pytest.approx(-0.015, rel=0.6)
    for each in found.bands:
        assert (each.identifiable, each.length_identifiable) == (each.group != band.group, each.group != band.group)
        if each.group == band.group:
            assert each.note.about == About.HALVES_DISAGREE


def test_one_side_stiffer_than_the_other_is_told(checked, suit):
    found = checked([stiffer(suit, 1.4, 1.0)] * 2, noise=0.1)
    (sides,) = (each for each in found.cross_checks if each.check == "sides")
    assert not sides.agrees
    assert sides.between == ("left", "right")
    assert sides.difference == pytest.approx(0.4 * 1500.0, rel=0.3)
    assert not found.bands[0].identifiable


def test_a_pull_that_rubs_contradicts_itself_between_strokes(checked, suit):
    """A quarter more where the bands lengthen, a quarter less where they shorten."""

    def rubbed(number, evidence):
        rate = np.gradient(evidence.length.sum(axis=1), evidence.time)
        return replace(evidence, a=evidence.a * (1.0 + 0.25 * np.sign(rate))[:, None])

    found = checked([suit, suit], noise=0.1, change=rubbed)
    (strokes,) = (each for each in found.cross_checks if (each.check, each.unit) == ("strokes", "N/m"))
    assert not strokes.agrees
    assert strokes.between[0] == LENGTHENING
    assert strokes.difference > 0.0
    assert not found.bands[0].identifiable


def test_a_band_that_is_taut_all_along_and_rubs_is_told_by_its_lengths(checked, suit):
    """An eighth more where it lengthens, an eighth less where it shortens: that it is stiffer there hardly shows."""
    taut = replace(suit, bands=tuple(replace(band, natural_length=band.natural_length - 0.15) for band in suit.bands))

    def rubbed(number, evidence):
        rate = np.gradient(evidence.length.sum(axis=1), evidence.time)
        return replace(evidence, a=evidence.a * (1.0 + 0.125 * np.sign(rate))[:, None])

    assert not failed(checked([taut, taut], noise=0.5))
    found = checked([taut, taut], noise=0.5, change=rubbed)
    lengths = [each for each in found.cross_checks if (each.check, each.unit) == ("strokes", "m")]
    assert lengths
    assert not any(each.agrees for each in lengths)
    assert all(each.difference < 0.0 for each in lengths)  # shorter, as it pulls more
    for band in found.bands:
        assert (band.identifiable, band.length_identifiable) == (False, False)


def test_a_strap_that_slides_and_comes_back_leaves_more_than_its_springs_doubt_holds(checked, suit, biped):
    """Straps of both bands give way at half of their largest pull, and creep back where they pull next to nothing."""
    routing = Routing(biped.robot.tree, suit.bands)

    def slid(number, evidence):
        jacobian, a = routing.geometry(evidence.posture).jacobian, evidence.a.copy()
        for k, band in enumerate(suit.bands):
            stretch, out = np.maximum(evidence.length[:, k] - band.natural_length, 0.0), 0.0
            pull = np.empty_like(stretch)
            for at, taut in enumerate(stretch):
                out = max(out, taut - 0.5 * stretch.max()) if taut - out > 0.0 else 0.99 * out
                pull[at] = band.stiffness * max(taut - out, 0.0)
            a -= jacobian[:, k] * (pull - band.stiffness * stretch)[:, None]
        return replace(evidence, a=a)

    found = checked([suit, suit], noise=0.1, change=slid)
    (misfit,) = (each for each in found.cross_checks if each.check == "misfit")
    assert not misfit.agrees
    assert misfit.between == ("torso_pitch", WITHOUT)
    assert misfit.difference > 1.96 * misfit.std
    for band in found.bands:
        assert not band.identifiable
        assert band.note.about in {About.SPRINGS_MISFIT, About.RELAXATION}


@pytest.mark.slow
def test_straps_that_slide_below_the_noise_are_told_by_the_lengths_of_both_bands_together(checked, suit, biped):
    """A bend stretches both: which of them is longer on the way back the logs hardly tell, and well that both are."""
    routing = Routing(biped.robot.tree, suit.bands)

    def slid(number, evidence):
        jacobian, a = routing.geometry(evidence.posture).jacobian, evidence.a.copy()
        for k, band in enumerate(suit.bands):
            stretch, out = np.maximum(evidence.length[:, k] - band.natural_length, 0.0), 0.0
            less = np.empty_like(stretch)
            for at, taut in enumerate(stretch):
                out = 0.997 * max(out, taut - 0.6 * stretch.max())
                less[at] = band.stiffness * min(taut, out)
            a += jacobian[:, k] * less[:, None]
        return replace(evidence, a=a)

    found = checked([suit] * 6, noise=1.0, change=slid, sigma=np.ones(2))
    lengths = [each for each in found.cross_checks if (each.check, each.unit) == ("strokes", "m")]
    assert [each.agrees for each in lengths] == [True, True, False]
    assert failed(found) <= {"strokes", "relaxation"}
    for band in found.bands:
        assert band.note.about in {About.LENGTHS_DISAGREE, About.RELAXATION}
        assert not band.identifiable


def test_springs_that_are_right_to_a_per_cent_need_not_explain_the_last_of_it(checked, suit):
    """Where nothing else disturbs them, their doubt is far smaller than what a hundredth of the torque may do."""

    def nearly(number, evidence):
        return replace(evidence, a=evidence.a * (1.0 + 0.01 * np.sin(3.0 * evidence.time))[:, None])

    found = checked([suit, suit], noise=0.003, change=nearly, sigma=0.01 * SIGMA)
    for misfit in (each for each in found.cross_checks if each.check == "misfit"):
        assert misfit.difference > 1.96 * found.bands[0].stiffness.std
        assert misfit.agrees
    assert all(band.identifiable for band in found.bands)


@pytest.fixture
def hardened(suit, biped):
    """What bands that harden make of a log."""
    routing = Routing(biped.robot.tree, suit.bands)

    def change(number, evidence):
        stretch = np.maximum(evidence.length - np.array([band.natural_length for band in suit.bands]), 0.0)
        more = 1500.0 * stretch**2 / stretch.max()
        return replace(
            evidence, a=evidence.a - np.einsum("twd,tw->td", routing.geometry(evidence.posture).jacobian, more)
        )

    return change


def test_bands_that_harden_contradict_themselves_between_hard_and_soft_pulls(checked, suit, hardened):
    found = checked([suit, suit], noise=0.1, change=hardened)
    (pulls,) = (each for each in found.cross_checks if each.check == "pulls")
    assert not pulls.agrees
    assert pulls.between == (HARD, SOFT)
    assert pulls.difference > 0.0
    for band, true in zip(found.bands, suit.bands, strict=True):
        assert band.natural_length.value > true.natural_length + 5.0 * band.natural_length.std  # a line's, and sure
        assert (band.identifiable, band.length_identifiable) == (False, False)


@pytest.mark.slow
@pytest.mark.parametrize(("share", "time", "noise"), [(0.4, 6.0, 1.2), (0.4, 20.0, 0.4), (0.3, 20.0, 0.3)])
def test_straps_that_creep_are_told_by_what_they_pull_at_once_and_later(checked, suit, biped, share, time, noise):
    """A spring and a dashpot side by side in series with each band: stroke by stroke it hardly shows."""
    routing = Routing(biped.robot.tree, suit.bands)

    def crept(number, evidence):
        jacobian, a = routing.geometry(evidence.posture).jacobian, evidence.a.copy()
        step = np.diff(evidence.time, prepend=evidence.time[0]) / time
        for k, band in enumerate(suit.bands):
            stretch, out = np.maximum(evidence.length[:, k] - band.natural_length, 0.0), 0.0
            less = np.empty_like(stretch)
            for at, taut in enumerate(stretch):
                out += step[at] * (share * max(taut - out, 0.0) - out)
                less[at] = band.stiffness * min(out, taut)
            a += jacobian[:, k] * less[:, None]
        return replace(evidence, a=a)

    found = checked([suit] * 4, noise=noise, change=crept, sigma=noise * np.ones(2))
    assert "relaxation" in failed(found)
    worst = max((each for each in found.cross_checks if each.check != "misfit"), key=lambda each: abs(each.z))
    assert worst.check == "relaxation"
    assert worst.difference > 0.0
    for band in found.bands:
        assert band.note.about == About.RELAXATION
        assert (band.identifiable, band.length_identifiable) == (False, False)


def test_what_is_small_beside_the_stated_doubt_fails_nothing_however_sure_it_is(checked, suit):
    """One log pulls a hundredth more, and noise is next to nothing: the via points are not known to a hundredth."""
    found = checked([suit, suit, stiffer(suit, 1.01, 1.01)], noise=0.003, sigma=0.01 * SIGMA)
    sure = [each for each in found.cross_checks if each.check == "repetitions" and abs(each.z) > each.limit]
    assert sure
    wide = tuple(
        replace(
            band,
            stiffness=replace(band.stiffness, std=0.05 * band.stiffness.value),
            natural_length=replace(band.natural_length, std=0.008),
        )
        for band in found.bands
    )
    assert failed(found)
    (told,) = judged([replace(found, bands=wide)], Supporting())
    assert not failed(told)


@pytest.mark.parametrize("approach", ["B", "paired"])
def test_approaches_that_contradict_each_other_are_both_no_longer_identifiable(checked, suit, approach):
    one = checked([suit, suit])
    other = replace(checked([stiffer(suit, 1.5, 1.5)] * 2), approach=approach)
    for each in judged([one, other], Supporting()):
        assert failed(each) == {"approaches"}
        assert {band.note.about for band in each.bands} == {About.APPROACHES_DISAGREE}
    alike = judged([one, replace(one, approach=approach)], Supporting())
    assert all(band.identifiable for each in alike for band in each.bands)


def test_b_does_not_stand_by_its_doubt_where_both_that_compare_runs_refute_the_bands(checked, suit, hardened):
    """Where A alone does, its runs may differ."""
    refuted, plain = checked([suit, suit], noise=0.1, change=hardened), checked([suit, suit])
    wide = tuple(replace(each, stiffness=replace(each.stiffness, std=1000.0)) for each in plain.bands)
    b, paired = replace(plain, approach="B", bands=wide), replace(refuted, approach="paired")
    assert not any(band.identifiable for band in judged([refuted, b, paired], Supporting())[1].bands)
    alone = judged([refuted, b, replace(plain, approach="paired")], Supporting())
    assert all(band.identifiable for band in alone[1].bands)


@pytest.mark.parametrize("one", ["A", "paired"])
def test_what_fails_by_one_approach_counts_for_another_that_cannot_say_it_is_not_so(checked, suit, hardened, one):
    """Bands that rub or harden do so whoever looks: an approach that is too unsure for a check of its own knows no
    better, and one whose own check would have seen it does."""
    refuted, plain = replace(checked([suit, suit], noise=0.1, change=hardened), approach="B"), checked([suit, suit])
    plain = replace(plain, approach=one)
    sees, unsure = (judged([each, refuted], Supporting())[0] for each in (plain, replace(plain, cross_checks=())))
    assert all(band.identifiable for band in sees.bands)
    assert not any(band.identifiable or band.length_identifiable for band in unsure.bands)
    for band in unsure.bands:
        assert band.note.names[-1].endswith("by B") or band.note.names[0].endswith("by B")


def test_a_length_is_not_decided_by_what_fails_where_the_stiffness_is_not_either(checked, suit, hardened):
    refuted = checked([suit, suit], noise=0.1, change=hardened)
    bands = tuple(replace(band, identifiable=False, length_identifiable=True, note=None) for band in refuted.bands)
    (found,) = judged([replace(refuted, bands=bands)], Supporting())
    for band in found.bands:
        assert not band.length_identifiable
        assert band.note is not None
