"""No path leaves the study's folder, zipped or not, and no zip unpacks to more than it may."""

from __future__ import annotations

import hashlib
import zipfile
from pathlib import Path

import pytest

from exogauge.errors import BadStudy, TooLarge
from exogauge.studies.intake import bundle as module
from exogauge.studies.intake.bundle import Bundle, open_bundle


def zipped(folder: Path, path: Path, prefix: str = "") -> Path:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for each in sorted(folder.rglob("*")):
            if each.is_file():
                archive.write(each, prefix + each.relative_to(folder).as_posix())
    return path


def test_a_zip_is_the_folder(folder: Path, tmp_path: Path) -> None:
    for prefix in ("", "my study/"):
        with_zip = open_bundle(zipped(folder, tmp_path / "study.zip", prefix))
        assert with_zip.read("robot.yaml", limit=10_000) == (folder / "robot.yaml").read_bytes()
        root = with_zip.root
        with_zip.close()
        assert not root.exists()


def test_what_was_read_is_remembered_by_hash(folder: Path) -> None:
    bundle = open_bundle(folder)
    bundle.path("robot.yaml")
    bundle.path("robot.yaml")
    (read,) = bundle.inputs
    data = (folder / "robot.yaml").read_bytes()
    assert (read.file, read.sha256, read.bytes) == ("robot.yaml", hashlib.sha256(data).hexdigest(), len(data))


@pytest.mark.parametrize("name", ["../study.yaml", "/etc/hosts", "logs/../../x", "logs\\x"])
def test_a_path_stays_inside(folder: Path, name: str) -> None:
    with pytest.raises(BadStudy, match="leaves"):
        open_bundle(folder).path(name)


def test_a_link_out_of_the_folder_is_refused(folder: Path, tmp_path: Path) -> None:
    (tmp_path / "secret").write_text("x")
    (folder / "logs" / "link.csv").symlink_to(tmp_path / "secret")
    with pytest.raises(BadStudy, match="link leads out"):
        open_bundle(folder).path("logs/link.csv")
    (folder / "linked").symlink_to(tmp_path)
    with pytest.raises(BadStudy, match="link leads out"):
        open_bundle(folder).path("linked/secret")


def test_a_missing_file_is_named_with_a_neighbour(folder: Path) -> None:
    with pytest.raises(BadStudy, match=r"Did you mean 'logs/id_1\.parquet'"):
        open_bundle(folder).path("logs/id_l.parquet", named_in="study.yaml", row=5)


def test_a_folder_is_called_one_and_what_is_in_it_is_named(folder: Path) -> None:
    with pytest.raises(BadStudy, match=r"is a folder.*logs/id_1\.parquet"):
        open_bundle(folder).path("logs", named_in="study.yaml", row=5)


def test_of_a_folder_of_meshes_what_may_be_meant_is_named_first(tmp_path: Path) -> None:
    """«Did you mean README.md» for the folder of a URDF."""
    (tmp_path / "arm").mkdir()
    for name in ("README.md", *(f"link{n}.stl" for n in range(20)), "robot.yaml"):
        (tmp_path / "arm" / name).touch()
    with pytest.raises(BadStudy, match=r"Name a file in it\. Known here: arm/robot\.yaml, "):
        Bundle(tmp_path, "study.yaml").path("arm")


@pytest.mark.parametrize("name", ["../evil", "/evil", "a/../../evil", "a\\evil"])
def test_a_zip_member_stays_inside(tmp_path: Path, name: str) -> None:
    with zipfile.ZipFile(tmp_path / "evil.zip", "w") as archive:
        archive.writestr("study.yaml", "version: 1")
        archive.writestr(name, "x")
    with pytest.raises(BadStudy, match="leaves the zip"):
        open_bundle(tmp_path / "evil.zip")


def test_a_link_in_a_zip_is_refused(tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "evil.zip", "w") as archive:
        link = zipfile.ZipInfo("study.yaml")
        link.external_attr = 0o120777 << 16
        archive.writestr(link, "/etc/hosts")
    with pytest.raises(BadStudy, match="symbolic link"):
        open_bundle(tmp_path / "evil.zip")


def test_a_zip_bomb_stops_early(tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "bomb.zip", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("study.yaml", "version: 1")
        archive.writestr("zeros.csv", bytes(60_000_000))
    with pytest.raises(TooLarge, match="too many bytes"):
        open_bundle(tmp_path / "bomb.zip")


def test_too_many_members_are_refused(tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "many.zip", "w") as archive:
        for k in range(module.MAX_MEMBERS + 1):
            archive.writestr(f"f{k}", "")
    with pytest.raises(TooLarge, match="at most"):
        open_bundle(tmp_path / "many.zip")


def test_a_broken_zip_says_so(tmp_path: Path) -> None:
    (tmp_path / "broken.zip").write_bytes(b"PK\x03\x04 and no more")
    with pytest.raises(BadStudy, match="not readable as a zip"):
        open_bundle(tmp_path / "broken.zip")


def test_two_studies_in_one_zip_are_ambiguous(folder: Path, tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "two.zip", "w") as archive:
        archive.writestr("a/study.yaml", "x")
        archive.writestr("b/study.yaml", "x")
    with pytest.raises(BadStudy, match="several studies"):
        open_bundle(tmp_path / "two.zip")
