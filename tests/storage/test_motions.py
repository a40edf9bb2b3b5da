"""What the store promises of motions, of contacts and maps that were said by hand, and of plans."""

from __future__ import annotations

import json
from datetime import timedelta
from pathlib import Path

import pytest
import sqlalchemy as sa

from exogauge.errors import Conflict, NotFound
from exogauge.jobs.plans_beside import lay_plans
from exogauge.storage.bundles import PLANNED
from exogauge.storage.checking import check
from exogauge.storage.files import PinnedFile
from exogauge.storage.store import Installation, Storage, Store
from exogauge.storage.sweeping import sweep_installation
from exogauge.storage.tables import Artifact, AuditEntry, Job, MotionContacts, MotionFile, PlanFile, Result


def pinned(store: Store, path: str, content: bytes) -> PinnedFile:
    return PinnedFile(path, store.blobs.put(content), len(content))


def world(store: Store) -> dict[str, str]:
    robot, _ = store.robots.add("walker", [pinned(store, "robot.yaml", b"r")], {})
    motion, _ = store.motions.add("bow", [pinned(store, "motion.yaml", b"m"), pinned(store, "a/b.trc", b"t")], {})
    study, _ = store.studies.add("before", [pinned(store, "study.yaml", b"s")], {})
    plan, _ = store.plans.add(
        "bow on walker", [pinned(store, "plan.yaml", b"p")], {"kind": "retarget"},
        robot_id=robot.id, motion_id=motion.id, study_id=study.id,
    )  # fmt: skip
    return {"robot": robot.id, "motion": motion.id, "study": study.id, "plan": plan.id}


def planned(store: Store, plan_id: str, table: bytes = b"t,q.a\n") -> str:
    job = Job(kind="retarget", request_hash="h", state="succeeded", plan_id=plan_id)
    store.session.add(job)
    store.session.flush()
    for file, content in (("plan.json", b"{}"), (PLANNED, table)):
        made = pinned(store, file, content)
        store.session.add(Artifact(job_id=job.id, name=file, sha256=made.sha256, size=made.size, media_type="text/csv"))
    made = pinned(store, "plan.json", b"{}")
    store.session.add(Result(job_id=job.id, plan_id=plan_id, sha256=made.sha256, size=made.size))
    store.session.flush()
    return job.id


def test_a_plan_is_laid_out_with_all_that_it_names(storage: Storage, tmp_path: Path) -> None:
    with storage.transaction() as store:
        made = world(store)
        store.plans.write_with_all(made["plan"], out := tmp_path / "out")
    found = {path.relative_to(out).as_posix(): path.read_bytes() for path in out.rglob("*") if path.is_file()}
    assert found == {
        "plan.yaml": b"p", "robot/robot.yaml": b"r", "motion/motion.yaml": b"m", "motion/a/b.trc": b"t",
        "study/study.yaml": b"s",
    }  # fmt: skip


def test_an_equal_request_is_the_same_plan_and_names_only_what_there_is(storage: Storage) -> None:
    with storage.transaction() as store:
        made = world(store)
        files = store.plans.files(made["plan"])
        again, new = store.plans.add("other name", files, {}, robot_id=made["robot"])
        assert (again.id, new) == (made["plan"], False)
        with pytest.raises(NotFound):
            store.plans.add("x", [pinned(store, "plan.yaml", b"q")], {}, robot_id=made["motion"])


@pytest.mark.parametrize(("noun", "said"), [("robot", "'bow on walker'"), ("motion", "plans"), ("study", "plans")])
def test_what_a_plan_names_stays_as_long_as_the_plan(storage: Storage, noun: str, said: str) -> None:
    with storage.transaction() as store:
        made = world(store)
        planned(store, made["plan"])
    bundles = {"robot": "robots", "motion": "motions", "study": "studies"}[noun]
    with pytest.raises(Conflict, match=said), storage.transaction() as store:
        getattr(store, bundles).delete(made[noun])
    with storage.transaction() as store:
        store.plans.delete(made["plan"])
        getattr(store, bundles).delete(made[noun])


def test_all_of_it_goes_with_its_bytes_and_nothing_is_missing_before(storage: Storage) -> None:
    installation = Installation(storage.engine, storage.blobs)
    with storage.transaction() as store:
        made = world(store)
        store.contacts.keep(made["motion"], {"left": [], "right": []}, "h")
        planned(store, made["plan"])
    assert check(installation, None).sound
    assert sweep_installation(installation, timedelta(0)).blobs == 0
    with storage.transaction() as store:
        for bundles, noun in ((store.plans, "plan"), (store.motions, "motion"), (store.robots, "robot")):
            bundles.delete(made[noun])  # type: ignore[attr-defined]
        for table in (MotionContacts, MotionFile, PlanFile, Job, Result, Artifact):
            assert store.session.scalars(sa.select(table)).all() == [], table
    assert sweep_installation(installation, timedelta(0)).blobs == 6  # all but the study's
    assert check(installation, None).sound


def test_studies_that_hold_a_plans_motion_are_found_by_it(storage: Storage) -> None:
    with storage.transaction() as store:
        made = world(store)
        planned(store, made["plan"], b"t,q.a\n0,1\n")
        files = [pinned(store, "study.yaml", b"x"), pinned(store, "played/motion.csv", b"t,q.a\n0,1\n")]
        played, _ = store.studies.add("played", files, {})
        found = store.studies.page(None, 9, plan_id=made["plan"]).items
    assert [study.id for study in found] == [played.id]


def test_studies_whose_results_hold_a_plans_motion_are_found_by_it(storage: Storage) -> None:
    """A log was found to follow it: the evaluation leaves the plan's table, under any name."""
    with storage.transaction() as store:
        made = world(store)
        planned(store, made["plan"], b"t,q.a\n0,1\n")
        for name, table in (("follows", b"t,q.a\n0,1\n"), ("another", b"t,q.a\n0,2\n")):
            study, _ = store.studies.add(name, [pinned(store, "study.yaml", name.encode())], {})
            job = Job(kind="evaluate", request_hash=name, state="succeeded", study_id=study.id)
            store.session.add(job)
            store.session.flush()
            kept = pinned(store, "x", table)
            told = {"sha256": kept.sha256, "size": kept.size, "media_type": "text/csv"}
            store.session.add(Artifact(job_id=job.id, name="followed_plan_1.csv", **told))
        store.session.flush()
        found = store.studies.page(None, 9, plan_id=made["plan"]).items
    assert [study.name for study in found] == ["follows"]


def test_a_labs_plans_are_laid_beside_a_study(storage: Storage, tmp_path: Path) -> None:
    with storage.transaction() as store:
        lay_plans(store, tmp_path / "none")
        made = world(store)
        lay_plans(store, tmp_path / "none")  # it has no motion yet
        planned(store, made["plan"], b"t,q.a\n0,1\n")
        lay_plans(store, tmp_path)
    assert not (tmp_path / "none").exists()
    (listed,) = json.loads((tmp_path / ".plans/plans.json").read_text()).items()
    assert listed[1] == [made["plan"], "bow on walker"]
    assert (tmp_path / ".plans" / listed[0]).read_bytes() == b"t,q.a\n0,1\n"


def test_contacts_and_maps_are_kept_changed_and_forgotten_with_a_word_in_the_audit(storage: Storage) -> None:
    with storage.transaction() as store:
        motion = world(store)["motion"]
        first, new = store.contacts.keep(motion, {"left": [[0, 1]], "right": []}, "h1")
        again, new_again = store.contacts.keep(motion, {"left": [], "right": []}, "h2")
        assert (new, new_again, first.id) == (True, False, again.id)
        names, _ = store.maps.keep("ours", {"A": "LASI"}, "h1")
        assert store.maps.by_id(names.id).content == {"A": "LASI"}
        assert [each.name for each in store.maps.all()] == ["ours"]
        store.contacts.forget(motion)
        store.maps.forget("ours")
        for lost in (lambda: store.contacts.get(motion), lambda: store.maps.get("ours")):
            with pytest.raises(NotFound):
                lost()
        said = sa.select(AuditEntry.action).where(
            AuditEntry.subject_id == motion, AuditEntry.subject_kind == "contacts"
        )
        assert store.session.scalars(said.order_by(AuditEntry.created_at)).all() == ["keep", "keep", "delete"]


@pytest.mark.parametrize("database_url", ["postgresql"], indirect=True)  # of SQLite, the other would wait
def test_what_another_changes_between_a_look_and_a_change_is_not_written_over(storage: Storage) -> None:
    with storage.transaction() as store:
        motion = world(store)["motion"]
        store.contacts.keep(motion, {"left": [], "right": []}, "h1")

    def meanwhile(seen: str) -> None:
        assert seen == "h1"
        with storage.transaction() as other:
            other.contacts.keep(motion, {"left": [], "right": [[0, 1]]}, "h2")

    with pytest.raises(Conflict), storage.transaction() as store:
        store.contacts.keep(motion, {"left": [[0, 1]], "right": []}, "h3", meanwhile)
    with storage.reading() as store:
        assert store.contacts.get(motion).content_hash == "h2"


def test_a_job_is_of_one_thing_and_its_newest_is_found(storage: Storage) -> None:
    with storage.transaction() as store:
        made = world(store)
        job = planned(store, made["plan"])
        assert store.jobs.latest("plan", [made["plan"]])[made["plan"]].id == job
        assert store.jobs.latest("motion", [made["motion"]]) == {}
        assert store.results.newest("plan", made["plan"]).job_id == job
        with pytest.raises(NotFound):
            store.results.newest("motion", made["motion"])
        assert [each.id for each in store.plans.page(None, 9, state="succeeded").items] == [made["plan"]]
        assert store.plans.page(None, 9, state="none").items == ()
