"""Bands from supporting torque: what comes back, what cannot be told, and how far to believe the rest."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.draws import drawn

from exogauge.devices.device import Band, BenchTest, Device, ViaPoint
from exogauge.effects.catalogue import band_effects
from exogauge.remarks import About, Remark
from exogauge.studies.results.support_results import stiffness_entries
from exogauge.support.band_model import SHORTEST, SOFTEST, Added, Layout, Wear, at_bounds, shared
from exogauge.support.stiffness import fit_springs, identify_bands, true_stiffness, undecided

SIGMA = np.array([0.3, 0.3])
NAMES = ["torso_pitch", "torso_yaw"]


def belly(name="belly", natural_length=0.39):
    """Over the front: a bend makes it shorter, a twist longer."""
    points = (("chest", 0.1, 0.1, 0.1), ("waist", 0.12, 0.0, 0.0), ("pelvis", 0.1, -0.1, 0.0))
    return Band(name, "belly", tuple(ViaPoint(link, (x, y, z)) for link, x, y, z in points), 800.0, natural_length)


def told_nothing(device: Device) -> Device:
    return replace(device, bands=tuple(replace(b, stiffness=None, natural_length=None) for b in device.bands))


@pytest.fixture(scope="module")
def identified(biped, suit, stoop, make_evidence):
    """The result for a device worn in courses, from torques that it gives, with coloured noise on top."""
    model = biped.known()

    def identify(device=suit, courses=None, noise=0.0, approach="A", gain=1.0, seed=0, known=None):
        evidences = [
            make_evidence(device, course, noise=noise, gain=gain, seed=seed + 100 * k)
            for k, course in enumerate([stoop(1)] if courses is None else courses)
        ]
        known = told_nothing(device) if known is None else known
        return identify_bands(model, known, approach, evidences, SIGMA, [], NAMES)

    return identify


@pytest.mark.slow
@drawn(30, 120)
def test_where_via_points_are_not_quite_there_the_stiffness_is_off_by_no_more_than_is_said(
    biped, suit, stoop, make_evidence, draws
):
    """Drawn as declared, hardly any noise: a fit that weighs joints by what it leaves on them bends to one of them."""
    rng, z, model, course = np.random.default_rng(0), [], biped.known(), stoop(1)
    for seed in range(draws):
        moved = tuple(
            replace(band, point_std=0.005, stiffness=None, natural_length=None, via_points=tuple(
                replace(point, xyz=tuple(np.array(point.xyz) + 0.005 * rng.normal(size=3))) for point in band.via_points
            ))
            for band in suit.bands
        )  # fmt: skip
        evidence = make_evidence(suit, course, noise=0.02, seed=1000 * seed)
        found, _ = fit_springs(model, replace(suit, bands=moved), "A", [evidence], SIGMA, [], NAMES).of(0)
        z.append((found.value - suit.bands[0].stiffness) / found.std)
    assert np.sqrt(np.mean(np.square(z))) == pytest.approx(1.0, abs=3.0 / np.sqrt(2.0 * draws))


def test_stiffness_and_lengths_come_back_with_what_is_left(identified, suit):
    found = identified()
    assert found.parameters == ("stiffness[back]", "natural_length[left]", "natural_length[right]")
    for estimate, band in zip(found.bands, suit.bands, strict=True):
        assert (estimate.band, estimate.group) == (band.name, "back")
        assert estimate.stiffness.value == pytest.approx(band.stiffness, rel=1e-5)
        assert estimate.natural_length.value == pytest.approx(band.natural_length, rel=1e-6)
        assert estimate.identifiable
        assert estimate.length_identifiable
        assert not estimate.note
    assert max(found.rms.values()) < 1e-3
    assert not found.notes


@pytest.mark.slow
def test_several_logs_count_together(identified, stoop, wander):
    doubts = []
    for seed in range(5):
        one, both = (
            identified(noise=0.5, courses=courses, seed=seed)
            for courses in ([stoop(1)], [stoop(1), wander(3), stoop(2)])
        )
        assert both.samples > 2.0 * one.samples
        doubts.append((one.bands[0].stiffness.std, both.bands[0].stiffness.std))
    alone, together = np.mean(doubts, axis=0)
    assert together < alone / np.sqrt(2.0)


def test_where_the_truth_is_known_the_error_is_given(identified, suit):
    bench = BenchTest((0.6, 0.7, 0.8), (0.0, 48.0, 208.0), is_truth=True)  # 1600 N/m, natural length 0.67
    known = replace(
        suit, bands=(replace(suit.bands[0], stiffness=1400.0, ground_truth=True), replace(suit.bands[1], bench=bench))
    )
    left, right = identified(known=known).bands
    assert (left.true_stiffness, right.true_stiffness) == (1400.0, pytest.approx(1600.0))
    assert left.error_percent == pytest.approx(100.0 * 100.0 / 1400.0, abs=1e-3)
    assert right.error_percent == pytest.approx(-100.0 * 100.0 / 1600.0, abs=1e-3)
    assert true_stiffness(suit.bands[0]) is None  # a nominal value is no truth
    assert identified().bands[0].error_percent is None


@pytest.mark.parametrize(
    ("stated", "about"),
    [
        ({"stiffness": 1800.0}, About.STIFFNESS_NOT_AS_STATED),
        ({"natural_length": 0.66}, About.LENGTH_NOT_AS_STATED),
        ({"stiffness": 1520.0}, None),  # of which a maker need not be surer
    ],
)
def test_a_value_that_the_logs_contradict_is_told_although_it_is_within_a_makers_doubt(identified, suit, stated, about):
    known = replace(suit, bands=(replace(suit.bands[0], **stated), suit.bands[1]))
    notes = [each for each in identified(known=known, noise=0.1).notes if each.about == about or about is None]
    if about is None:
        assert not notes
        return
    (note,) = notes
    assert note.names == ("left",)
    ((found, said),) = note.each
    assert said in stated.values()
    assert abs(found - said) > 0.05 * said or abs(found - said) > 0.009
    truly_told = replace(known, bands=tuple(replace(band, ground_truth=True) for band in known.bands))
    assert not [each for each in identified(known=truly_told, noise=0.1).notes if each.about == about]


def test_a_torque_gain_goes_into_stiffness_alone(identified):
    right, less = identified(noise=0.3), identified(noise=0.3, gain=0.95)
    assert less.bands[0].stiffness.value == pytest.approx(0.95 * right.bands[0].stiffness.value, rel=1e-4)
    for k in range(2):
        assert less.bands[k].natural_length.value == pytest.approx(right.bands[k].natural_length.value, rel=1e-5)


def bent_only(stoop):
    """A bend without any twist."""
    course = stoop(1, turn=0.0)
    assert not course.q[:, 3].any()
    return course


def test_a_bend_seen_by_the_bends_torque_alone_ties_left_and_right_and_says_so(
    identified, suit, stoop, make_evidence, biped
):
    alike = replace(suit, bands=tuple(replace(band, natural_length=0.675) for band in suit.bands))
    evidence = make_evidence(alike, bent_only(stoop), noise=0.1, unused=["torso_yaw"])
    found = identify_bands(biped.known(), told_nothing(alike), "A", [evidence], SIGMA, [], NAMES)
    assert found.parameters == ("stiffness[back]", "natural_length[back]")
    (note,) = found.notes
    assert note == Remark(About.LENGTHS_TIED, ("left", "right"))
    for estimate in found.bands:
        assert estimate.stiffness.value == pytest.approx(1500.0, rel=0.05)
        assert estimate.natural_length.value == pytest.approx(0.675, abs=2e-3)
        assert estimate.length_identifiable


def test_a_twist_unties_them(identified, suit):
    assert not identified(noise=0.1).notes
    assert identified(known=replace(told_nothing(suit), tied=frozenset({"back"}))).parameters[1:] == (
        "natural_length[back]",
    )


def test_what_ends_at_a_bound_is_never_identifiable_and_said_so(identified, suit):
    """Torques of bands longer than they are: only a natural length below zero explains them."""
    pulls_too_much = replace(suit, bands=tuple(replace(band, natural_length=-0.4) for band in suit.bands))
    found = identified(device=pulls_too_much, noise=0.1)
    lengths = [f"natural_length[{band.name}]" for band in suit.bands]
    for estimate in found.bands:
        assert estimate.stiffness.std < 0.3 * estimate.stiffness.value, "the doubt alone would not show it"
        assert not estimate.identifiable
        assert not estimate.length_identifiable
        assert estimate.note.about == About.BOUND_REACHED
        assert lengths[0] in estimate.note.names


def test_an_added_laws_bound_and_a_stiffness_at_its_softest_are_seen(suit):
    hardening = next(each for each in band_effects().values() if each.coefficients[0].low == 0.0)
    C, none = len(hardening.coefficients), np.zeros
    wear = Wear(shared(suit.bands), np.array([SOFTEST, 0.6, 0.7]), added=(Added(hardening, 0, (), none(C)),))
    assert at_bounds(wear).tolist()[:4] == [True, False, False, True]
    free = replace(wear, springs=np.array([100.0, 0.6, SHORTEST]), added=())
    assert at_bounds(free).tolist() == [False, False, True]


def test_a_band_that_is_slack_throughout_is_not_decided_and_said_so(identified, suit):
    worn = replace(suit, bands=(*suit.bands, belly(natural_length=2.0)))
    found = identified(device=worn)
    estimate = found.bands[2]
    assert not estimate.identifiable
    assert not estimate.length_identifiable
    assert np.isinf(estimate.stiffness.std)
    assert np.isinf(estimate.natural_length.std)
    assert estimate.stiffness_interval == (0.0, np.inf)
    assert estimate.note.about == About.PULLS_NOWHERE
    assert np.isnan(estimate.stiffness.value), "no number where any would do"
    assert np.isnan(estimate.natural_length.value)
    assert found.bands[0].stiffness.value == pytest.approx(1500.0, rel=1e-5)
    assert found.bands[0].identifiable


@pytest.mark.parametrize("seed", range(12))
def test_noise_does_not_decide_a_band_that_is_slack_throughout(identified, suit, seed):
    """Whatever noise makes of it: no upper end, or an interval that holds almost no pull; and words for it."""
    worn = replace(suit, bands=(*suit.bands, belly(natural_length=2.0)))
    found = identified(device=worn, noise=0.3, seed=seed)
    estimate = found.bands[2]
    assert not estimate.identifiable
    assert estimate.note
    if not np.isfinite(estimate.stiffness.std):
        assert estimate.stiffness_interval == (0.0, np.inf)
    assert found.bands[0].stiffness.value == pytest.approx(1500.0, rel=0.2)


@pytest.mark.parametrize("approach", ["A", "B", "prior"])
def test_what_only_pushes_is_no_band_and_leaves_nothing_to_doubt(identified, approach):
    """Nothing pulls anywhere: no source has a part, and the step ended in an error."""
    found = identified(approach=approach, gain=-1.0, noise=0.1)
    for estimate in found.bands:
        assert not estimate.identifiable
        assert not estimate.length_identifiable
        assert estimate.note


def test_a_slack_band_beside_a_taut_one_of_its_group_decides_nothing_of_either(identified, suit):
    """Its number is the group's; but a band that is described elsewhere than it runs pulls through its twin."""
    loose = replace(suit, bands=(suit.bands[0], replace(suit.bands[1], natural_length=2.0)))
    found = identified(device=loose)
    left, right = found.bands
    assert right.stiffness.value == left.stiffness.value == pytest.approx(1500.0, rel=1e-4)
    assert (left.identifiable, right.identifiable) == (False, False)
    assert np.isinf(right.natural_length.std)
    assert np.isnan(right.natural_length.value)
    low, high = right.natural_length_interval
    assert right.longest - 0.03 < low < right.longest, "as stiff as its twin, it would be seen if it began to pull"
    assert np.isinf(high)
    assert not right.length_identifiable
    assert left.note == right.note == Remark(About.ALONE_IN_GROUP, ("right",), beside=("back",))
    assert left.length_identifiable
    apart = replace(loose, bands=(loose.bands[0], replace(loose.bands[1], group="other")))
    left, right = identified(device=apart).bands
    assert left.identifiable
    assert right.note == Remark(About.PULLS_NOWHERE, ("right",))
    known, open_ = (entry["budget"] for entry in stiffness_entries([found]))
    assert known
    assert all(part["natural_length_std"] >= 0.0 for part in known)
    assert [part["stiffness_std"] for part in open_] == pytest.approx([part["stiffness_std"] for part in known])
    assert {part["natural_length_std"] for part in open_} == {None}


def test_two_bands_on_one_path_cannot_be_told_apart(identified, suit):
    twins = replace(suit, bands=(suit.bands[0], replace(suit.bands[0], name="twin", group="twin")))
    found = identified(device=twins)
    for estimate in found.bands:
        assert not estimate.identifiable
        assert estimate.note.about == About.NOT_TOLD_APART
        assert {"stiffness[back]", "stiffness[twin]"} <= {*estimate.note.names, *estimate.note.beside}


def benched(device, k=1520.0, l_0=0.6755):
    """Measured on a bench, without scatter; that counts for 1 %, which is 15 N/m, and 2 mm."""
    length = np.array([0.60, 0.65, 0.70, 0.75, 0.80])
    bench = BenchTest(tuple(length), tuple(k * np.maximum(length - l_0, 0.0)))
    return replace(device, bands=tuple(replace(band, bench=bench) for band in told_nothing(device).bands))


@pytest.mark.slow
@pytest.mark.parametrize("noise", [0.3, 1.0, 6.0])
def test_a_bench_test_weighs_what_it_is_worth_against_what_the_data_are_worth(identified, suit, noise):
    """Errors last 0.2 s, so there are far fewer of them than samples. Both together are known at least as well as
    either, and lie where their doubts say."""
    alike = tuple(replace(band, natural_length=0.675) for band in suit.bands)
    worn = replace(suit, bands=alike, tied=frozenset({"back"}))
    for seed in range(4):
        alone, both = (
            identified(device=worn, noise=noise, seed=seed, known=known).bands[0].stiffness
            for known in (told_nothing(worn), benched(worn))
        )
        bench = 0.01 * 1520.0
        assert both.std < 1.1 * min(alone.std, bench)
        assert abs(both.value - 1500.0) < 3.0 * both.std
        if alone.std > 10.0 * bench:
            assert abs(both.value - 1520.0) < bench


def test_a_bench_test_leaves_good_data_alone(identified, suit):
    estimate = identified(noise=0.01, known=benched(suit)).bands[0]
    assert estimate.stiffness.value == pytest.approx(1500.0, rel=0.01)


def test_joints_that_the_bands_do_not_explain_count_for_less(identified, biped, suit, stoop, make_evidence):
    """The yaw joint shows torque that no band could give; weighed by what is left, it hardly bends the estimate."""
    evidence = make_evidence(suit, stoop(1))
    strange = evidence.a.copy()
    strange[:, 1] += 5.0 * np.sin(3.0 * evidence.time)
    found = identify_bands(biped.known(), told_nothing(suit), "A", [replace(evidence, a=strange)], SIGMA, [], NAMES)
    assert found.bands[0].stiffness.value == pytest.approx(1500.0, rel=0.01)
    assert found.rms["torso_yaw"] == pytest.approx(5.0 / np.sqrt(2), rel=0.1)
    assert found.rms["torso_pitch"] < 0.2


def test_doubt_grows_with_the_noise(identified):
    stds = [identified(noise=noise).bands[0].stiffness.std for noise in (0.1, 0.4)]
    assert stds[1] == pytest.approx(4.0 * stds[0], rel=0.1)


def test_correlation_is_that_of_the_doubt(identified):
    found = identified(noise=0.3)
    np.testing.assert_allclose(np.diag(found.correlation), 1.0)
    np.testing.assert_allclose(found.correlation, found.correlation.T, atol=1e-12)
    assert found.correlation[0, 1] > 0.3  # stiffer and longer explain a bend alike


def test_a_doubt_of_any_size_that_rounding_leaves_is_no_number_but_undecided():
    plan = Layout(("stiffness[a]", "natural_length[left]", "natural_length[right]"), np.array([0, 0]), np.array([1, 2]))
    shares = {"scatter": np.diag([1e2, 1e-4, 1e274]), "via_points": np.diag([1e3, 1e-6, 0.0])}
    assert undecided(plan, shares) == {"natural_length[right]"}
    assert undecided(plan, {"scatter": np.diag([np.inf, np.nan, 1.0])}) == {"stiffness[a]", "natural_length[left]"}


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(6))
def test_bands_that_never_pull_have_no_stiffness_whatever_noise_looks_like(identified, suit, seed):
    """A soft spring that is always taut suits any slow error; the true ones are as stiff as others, and slack."""
    loose = replace(suit, bands=tuple(replace(band, natural_length=2.0) for band in suit.bands))
    for band in identified(device=loose, noise=0.3, seed=1000 * seed).bands:
        assert band.stiffness_interval == (0.0, np.inf)
        assert np.isnan(band.stiffness.value)
        assert band.note.about == About.PULLS_NOWHERE
        assert (band.identifiable, band.length_identifiable) == (False, False)


@pytest.mark.parametrize("noise", [1.0, 3.0])
def test_one_band_that_pulls_for_two_is_no_stiffness(identified, suit, stoop, noise):
    """Two that run 1 cm beside each other: that one is slack and the other twice as stiff fits as well, and however
    sharply, it is not decided."""
    one = replace(suit.bands[0], natural_length=0.63)
    beside = tuple(replace(point, xyz=(point.xyz[0] - 0.01, *point.xyz[1:])) for point in one.via_points)
    twins = replace(suit, bands=(one, replace(one, name="beside", via_points=beside)))
    found = identified(device=twins, courses=[stoop(1)], noise=noise)
    for each in found.bands:
        near = abs(each.stiffness.value - one.stiffness) < 0.2 * one.stiffness
        assert near or not (each.identifiable or each.length_identifiable)
        assert near or each.note.about == About.ANOTHER_FIT
    assert not near  # or nothing was asked
