"""The cases as files: the same for the same seed, labelled, silent about what they hide."""

from __future__ import annotations

import gzip
import hashlib
import json
import re
from collections import Counter
from pathlib import Path

import pyarrow.parquet as pq
import pytest
import yaml

from exogauge.blind.answers import ANSWERS, SEAL, read_answers
from exogauge.blind.generator.hidden.kinds import IN_BANDS, KINDS, ON_REQUEST
from exogauge.blind.generator.make import make
from exogauge.blind.generator.plan import BLOCK, CLEAN, PAIRS, can_be_asked_for, plan_case, possible
from exogauge.errors import BadInput

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def two(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("blind") / "two"
    make(out, 5, 2)
    return out


def digests(folder: Path) -> dict[str, str]:
    files = (path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


def test_a_seed_makes_the_same_bytes_and_a_case_is_the_same_among_fewer(two: Path, tmp_path: Path) -> None:
    make(tmp_path / "one", 5, 1)
    first, again = digests(two / "case_0001"), digests(tmp_path / "one" / "case_0001")
    assert first == again
    assert first != digests(two / "case_0002")
    assert read_answers(tmp_path / "one")["cases"] == read_answers(two)["cases"][:1]


@pytest.mark.slow
def test_processes_change_nothing(two: Path, tmp_path: Path) -> None:
    make(tmp_path / "again", 5, 2, processes=2)
    assert digests(tmp_path / "again") == digests(two)


def test_a_folder_that_holds_something_is_refused(two: Path) -> None:
    with pytest.raises(BadInput, match="empty folder"):
        make(two, 5, 2)


def test_cases_say_that_they_are_synthetic(two: Path) -> None:
    for case in ("case_0001", "case_0002"):
        study = yaml.safe_load((two / case / "study.yaml").read_text(encoding="utf-8"))
        assert "SYNTHETIC" in study["name"]
        for entry in study["logs"]:
            assert b"SYNTHETIC" in pq.read_schema(two / case / entry["file"]).metadata[b"exogauge"]


def test_a_case_folder_says_nothing_of_what_it_hides(two: Path) -> None:
    for answer in read_answers(two)["cases"]:
        for path in (two / answer["case"]).rglob("*"):
            if path.is_file():
                content = path.read_bytes().replace(b"payload_on_sensor", b"")  # the contract's word for a sign
                assert not [name for name in KINDS if name.encode() in content], path


def test_answers_under_a_broken_seal_are_refused(two: Path, tmp_path: Path) -> None:
    (tmp_path / SEAL).write_bytes((two / SEAL).read_bytes())
    record = json.loads(gzip.decompress((two / ANSWERS).read_bytes()))
    record["cases"][0]["effects"] = []
    record["cases"][0]["joints"] = {}
    (tmp_path / ANSWERS).write_bytes(gzip.compress(json.dumps(record).encode()))
    with pytest.raises(BadInput, match="seal is broken"):
        read_answers(tmp_path)
    (tmp_path / ANSWERS).write_bytes(b"no answers at all")
    with pytest.raises(BadInput, match="seal is broken"):
        read_answers(tmp_path)
    (tmp_path / ANSWERS).unlink()
    with pytest.raises(BadInput, match="missing"):
        read_answers(tmp_path)


def test_the_seal_is_what_sha256sum_says_of_the_answers(two: Path) -> None:
    text = gzip.decompress((two / ANSWERS).read_bytes())
    assert (two / SEAL).read_text(encoding="utf-8").split() == [hashlib.sha256(text).hexdigest(), "answers.json"]


def test_all_sorts_are_hidden_about_equally_often() -> None:
    plans = [plan_case(3, number) for number in range(1, 3 * BLOCK + 1)]
    assert all(plan.robot.wires for plan in plans if IN_BANDS & set(plan.kinds)), "bands are on robots that wear some"
    sizes = Counter(len(plan.kinds) for plan in plans)
    assert sizes == {0: 3 * CLEAN, 1: 3 * (BLOCK - CLEAN - PAIRS), 2: 3 * PAIRS}
    single = Counter(plan.kinds[0] for plan in plans if len(plan.kinds) == 1)
    assert set(single) == set(KINDS)
    assert max(single.values()) - min(single.values()) <= 1
    assert 0.2 < sum(plan.clutter for plan in plans) / len(plans) < 0.46


def test_effects_and_robots_that_are_asked_for_are_all_there_is(tmp_path: Path) -> None:
    asked = ("ft_gain", "payload")
    plans = [plan_case(3, number, "arm6", asked) for number in range(1, 11)]
    assert Counter(plan.kinds for plan in plans) == {("ft_gain",): 5, ("payload",): 5}
    assert {plan.robot.name for plan in plans} == {"arm6"}
    assert not set(possible("arm6")) & IN_BANDS
    with pytest.raises(BadInput, match="not hidden in cases of these robots"):
        make(tmp_path / "none", 5, 1, robots="arm6", effects=["band_slip"])
    with pytest.raises(BadInput, match="Known: stribeck"):
        make(tmp_path / "none", 5, 1, effects=["stribek"])


def test_what_is_made_only_when_asked_for_is_made_then_and_changes_no_seed() -> None:
    assert not set(ON_REQUEST) & {kind for number in range(1, 2 * BLOCK + 1) for kind in plan_case(3, number).kinds}
    asked = [plan_case(3, number, "both", ON_REQUEST) for number in range(1, 2 * len(ON_REQUEST))]
    assert {kind for plan in asked for kind in plan.kinds} == set(ON_REQUEST)


def test_a_case_that_hides_nothing_can_be_asked_for_and_has_no_clutter() -> None:
    for robots in ("arm6", "torso8", "both"):
        plans = [plan_case(3, number, robots, ("nothing",)) for number in range(1, BLOCK + 1)]
        assert not any(plan.kinds or plan.clutter for plan in plans)
        assert "nothing" in can_be_asked_for(robots)


def test_a_block_is_made_up_as_the_document_says() -> None:
    text = (Path(__file__).parents[2] / "docs" / "blind.md").read_text(encoding="utf-8")
    said = re.search(r"Of (\d+) cases (\d+) hide nothing, (\d+) one effect, (\d+) two", text)
    assert said is not None
    of, *shares = map(int, said.groups())
    assert sum(shares) == of
    for seed in (3, 4):
        drawn = Counter(len(plan_case(seed, number).kinds) for number in range(1, of + 1))
        assert [drawn[hidden] for hidden in (0, 1, 2)] == shares


def test_every_sort_is_described() -> None:
    text = (Path(__file__).parents[2] / "docs" / "blind.md").read_text(encoding="utf-8")
    assert not [kind for kind in (*KINDS, *ON_REQUEST) if f"`{kind}`" not in text]
