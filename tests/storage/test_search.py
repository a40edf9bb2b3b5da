"""What is found by words, alike on both databases."""

from __future__ import annotations

import pytest
import sqlalchemy as sa

from exogauge.storage import migrate
from exogauge.storage.bundles import folded
from exogauge.storage.database import make_engine
from exogauge.storage.files import PinnedFile
from exogauge.storage.store import Storage
from exogauge.storage.tables import Job

pytestmark = pytest.mark.usefixtures("without_bytes")

SUMMARY = {"robot": {"name": "HRP-4"}, "devices": [{"name": "Smart Suit"}, {"name": "Rückenband"}]}
LETTERS = {  # a name, and how another hand writes a part of it
    "STRASSE": "straße",
    "ΟΔΟΣ": "οδος",
    "Подъём": "ПОДЪЁМ",
    "持ち上げ": "上げ",
    "ﾊﾟﾜｰ": "パワー",
    "café": "CAFE\u0301",
}


def add(storage: Storage, *names: str, summary: object = None) -> list[str]:
    with storage.transaction() as store:
        made = [
            store.studies.add(name, [PinnedFile("study.yaml", f"{abs(hash(name)):064}", 1)], summary or {})[0]  # type: ignore[arg-type]
            for name in names
        ]
    return [study.id for study in made]


def found(storage: Storage, search: str) -> set[str]:
    with storage.reading() as store:
        return {study.name for study in store.studies.page(None, 50, search=search).items}


def test_every_word_may_be_in_the_name_the_robots_or_a_devices(storage: Storage) -> None:
    add(storage, "Back lift", summary=SUMMARY)
    add(storage, "Something else")
    for search in ("lift", "LIFT BACK", "hrp-4", "suit", "back\tsmart", "RÜCKEN", "ＨＲＰ", " hrp-4\u3000lift  "):
        assert found(storage, search) == {"Back lift"}, search
    assert found(storage, "lift else") == set()
    assert found(storage, " ") == {"Back lift", "Something else"}


def test_case_width_and_composition_of_letters_do_not_matter(storage: Storage) -> None:
    add(storage, *LETTERS)
    for name, search in LETTERS.items():
        assert found(storage, search) == {name}


def test_a_sign_is_itself_and_no_pattern(storage: Storage) -> None:
    signs = ("%", "_", "/", "\\", "'", '"', "*", "?", "[", ";--")
    add(storage, "half-full", "halffull", *(f"half{sign}full" for sign in signs))
    for sign in signs:
        assert found(storage, sign) == found(storage, f"half{sign}f") == {f"half{sign}full"}


def test_folding_twice_changes_nothing() -> None:
    text = "".join(map(chr, (*range(1, 0x3000), *range(0xF900, 0x10000))))
    assert folded(folded(text)) == folded(text)


def test_a_study_is_found_by_the_beginning_of_its_id_or_hash_and_not_by_chance_of_it(storage: Storage) -> None:
    key = add(storage, "zz")[0]
    with storage.reading() as store:
        pinned = store.studies.get(key).content_hash
    assert found(storage, key) == found(storage, key[:8].upper()) == found(storage, pinned[:6]) == {"zz"}
    assert found(storage, key[:5]) == found(storage, pinned[8:20]) == found(storage, key[9:23]) == set()


def test_pages_of_what_was_sought_hold_everything_once_newest_first(storage: Storage) -> None:
    wanted = [key for k in range(7) for key in add(storage, f"arm {k}", f"leg {k}")[:1]]
    seen, after = list[str](), None
    while True:
        with storage.reading() as store:
            page = store.studies.page(after, 3, search="ARM")
        seen += [study.id for study in page.items]
        after = page.after
        if after is None:
            break
    assert seen == wanted[::-1]


def test_robots_and_devices_are_found_by_their_names_and_a_device_by_its_robots(storage: Storage) -> None:
    with storage.transaction() as store:
        arm, leg = (store.robots.add(name, [], {"name": f"{name} of steel"})[0] for name in ("Arm", "Leg"))
        strap = store.devices.add("Strap", [], {"name": "Strap", "robot": "Arm"}, robot_id=arm.id)[0]
        store.devices.add("Strap", [], {"name": "Strap", "robot": "Leg"}, robot_id=leg.id)
        assert [robot.id for robot in store.robots.page(None, 9, search="steel arm").items] == [arm.id]
        assert [device.id for device in store.devices.page(None, 9, search="strap arm").items] == [strap.id]
        assert store.devices.page(None, 9, search="strap arm", robot_id=leg.id).items == ()


def test_studies_are_chosen_by_the_state_of_their_latest_evaluation(storage: Storage) -> None:
    again, fresh, asked = add(storage, "again", "fresh", "asked")
    with storage.transaction() as store:
        for k, (study, kind, state) in enumerate(
            [(again, "evaluate", "succeeded"), (again, "evaluate", "failed"), (asked, "whatif", "succeeded")]
        ):
            store.session.add(Job(kind=kind, study_id=study, request_hash=str(k), state=state))
            store.session.flush()
    with storage.reading() as store:
        page = store.studies.page
        assert [study.id for study in page(None, 9, state="failed").items] == [again]
        assert page(None, 9, state="succeeded").items == ()
        assert [study.id for study in page(None, 9, state="none").items] == [asked, fresh]
        assert [study.id for study in page(None, 9, state="none", search="FRESH").items] == [fresh]


@pytest.mark.slow
def test_what_was_there_before_words_were_kept_is_found_after_the_migration(empty_database_url: str) -> None:
    migrate.upgrade(empty_database_url, "0003")
    values = {"id": "s", "lab": "local", "at": "2026-01-01", "name": "Old Lift", "sum": '{"robot": {"name": "HRP-4"}}'}
    insert = (
        "INSERT INTO studies (id, lab_id, created_at, name, content_hash, summary) "
        "VALUES (:id, :lab, :at, :name, 'c', :sum)"
    )
    engine = make_engine(empty_database_url, migrating=True)
    with engine.begin() as connection:
        connection.execute(sa.text(insert), values)
    migrate.upgrade(empty_database_url)
    with engine.begin() as connection:
        words = connection.execute(sa.text("SELECT words FROM studies")).scalar_one()
    engine.dispose()
    assert set(words.split("\n")) == {"old lift", "hrp-4"}
