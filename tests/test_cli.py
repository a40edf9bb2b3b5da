"""The commands, as others call them."""

from __future__ import annotations

import errno
import io
import os
import re
import subprocess
import sys

import numpy as np
import pytest

from exogauge import __version__
from exogauge.cli import main
from exogauge.client import Client
from exogauge.errors import BadInput, BadLog
from exogauge.logs.mapping import read_mapped
from exogauge.settings import Settings
from exogauge.storage import migrate
from exogauge.studies.intake.mapping_file import parse_mapping
from exogauge.terminal import text_table


def exogauge(*arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "exogauge.cli", *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def test_version_is_answered_without_loading_the_numerics():
    code = (
        "import sys\nfrom exogauge.cli import main\n"
        "try: main(['--version'])\nexcept SystemExit: pass\n"
        "assert not {'numpy', 'pinocchio', 'fastapi', 'sqlalchemy'} & set(sys.modules)"
    )
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert answer.stdout == f"exogauge {__version__}\n"


def test_run_says_what_is_wrong_with_the_input_and_ends_with_2(tmp_path, capsys):
    (tmp_path / "study.yaml").write_text("version: 1\nname: x\nrobot: robot.yaml\nlogs: []\n")
    assert main(["run", str(tmp_path / "study.yaml"), "--out", str(tmp_path / "out")]) == 2
    said = capsys.readouterr().err
    assert "study.yaml" in said
    assert "logs" in said
    assert not (tmp_path / "out" / "results.json").exists()
    assert main(["run", str(tmp_path / "nowhere"), "--out", str(tmp_path / "out")]) == 2
    assert main(["doctor", str(tmp_path / "study.yaml")]) == 2


def test_a_fault_is_told_by_the_command_whatever_else_is_called_name(tmp_path, capsys):
    (tmp_path / "a.bvh").write_text("HIERARCHY")
    assert main(["motion", "import", str(tmp_path / "a.bvh"), "--name", "Brust=Spine2"]) == 2
    assert capsys.readouterr().err.startswith("exogauge motion: a.bvh")


def test_an_unknown_command_ends_with_2_and_lists_those_there_are():
    answer = exogauge("cook")
    assert answer.returncode == 2
    assert {"run", "serve", "work", "sample", "migrate", "doctor", "demo"} <= set(re.findall(r"\w+", answer.stderr))


def test_a_mapping_is_drafted_and_reads_the_files_once_what_is_open_is_said(tmp_path, capsys):
    rows = [(k, 57.3 * np.sin(k / 50), np.cos(k / 50)) for k in range(400)]
    table = "time_ms,elbow_pos [deg],elbow_trq [Nm],status,mode\n"
    (tmp_path / "run.csv").write_text(table + "".join(f"{10 * k},{q},{tau},7,1\n" for k, q, tau in rows))
    assert main(["mapping", str(tmp_path / "run.csv"), "--out", str(tmp_path / "mapping.yaml")]) == 0
    assert "mapping.yaml" in capsys.readouterr().out
    text = (tmp_path / "mapping.yaml").read_text()
    assert "# ! run.csv: status, mode: " in text  # of which the same is said

    (tmp_path / "run.csv").rename(tmp_path / "another.csv")  # the robot's next log is called otherwise

    def read():
        mapping = parse_mapping((tmp_path / "mapping.yaml").read_bytes(), "mapping.yaml")
        paths = {"another.csv": tmp_path / "another.csv"}
        return read_mapped(paths, mapping, joints=["elbow"], motor_from_joint=None, name="run")

    with pytest.raises(BadLog, match="status"):
        read()
    (tmp_path / "mapping.yaml").write_text(text + "  ignore: [status, mode]\n")
    log = read()
    assert log.rate_hz == pytest.approx(100.0)
    np.testing.assert_allclose(log.channels["q.elbow"], np.radians(57.3) * np.sin(log.time * 2), atol=1e-9)


@pytest.mark.slow
def test_migrate_makes_our_tables_and_the_queues_and_may_be_repeated(empty_database_url, tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("EXOGAUGE_DATABASE_URL", empty_database_url)
    monkeypatch.setenv("EXOGAUGE_DATA_DIR", str(tmp_path))
    for _ in range(2):
        assert main(["migrate"]) == 0
        assert migrate.newest() in capsys.readouterr().out
    migrate.check(Settings().database_url)


def test_a_worker_without_a_schema_says_what_to_run(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("EXOGAUGE_DATA_DIR", str(tmp_path))
    assert main(["work"]) == 2
    assert "exogauge migrate" in capsys.readouterr().err


@pytest.mark.slow
def test_a_port_that_is_taken_is_said_and_not_traced(tmp_path, monkeypatch, capsys):
    import socket

    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = str(taken.getsockname()[1])
        monkeypatch.setenv("EXOGAUGE_DATA_DIR", str(tmp_path))
        assert main(["serve", "--port", port]) == 2
    assert f"cannot listen on 127.0.0.1:{port}" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("value", "shown"), [(1234.5678, "1235"), (None, ""), ("a\nb", "a b"), ("x" * 50, "x" * 39 + "…")]
)
def test_tables_show_four_digits_and_cut_long_text(value, shown):
    assert text_table(["c"], [[value]]).split("\n")[-1] == shown


@pytest.mark.parametrize(
    "command",
    [
        ["sample", "OUT", "--seed", "1"],
        ["sample", "OUT", "--seed", "1", "--payload"],
        ["payload", "run", "nowhere", "--out", "OUT"],
        ["payload", "postures", "nowhere", "--out", "OUT"],
        ["payload", "excite", "nowhere", "--out", "OUT", "--server", "http://127.0.0.1:9"],
    ],
)
def test_a_folder_that_holds_something_is_not_written_over_unasked(command, tmp_path, capsys):
    kept = tmp_path / "mine.txt"
    kept.write_text("mine")
    assert main([str(tmp_path) if word == "OUT" else word for word in command]) == 2
    assert "--force" in capsys.readouterr().err
    assert [each.name for each in tmp_path.iterdir()] == ["mine.txt"]


def test_force_writes_into_a_folder_that_holds_something(tmp_path):
    pytest.importorskip("mujoco")
    (tmp_path / "mine.txt").write_text("mine")
    assert main(["sample", str(tmp_path), "--seed", "1", "--payload", "--force"]) == 0
    assert (tmp_path / "payload.yaml").is_file()
    assert (tmp_path / "mine.txt").read_text() == "mine"


def test_where_nothing_can_be_written_is_told_before_the_work(tmp_path, capsys):
    """A study of minutes had been evaluated by then."""
    (file := tmp_path / "file").write_text("")
    for out in (file, file / "below"):
        for asked in (["run", "nowhere"], ["results", "some-id"], ["payload", "run", "nowhere", "--force"]):
            assert main([*asked, "--out", str(out)]) == 2
            said = capsys.readouterr().err
            assert str(out) in said
            assert "nowhere" not in said
    assert main(["run", "nowhere", "--out", str(tmp_path / "new" / "below")]) == 2
    assert "nowhere" in capsys.readouterr().err
    assert not (tmp_path / "new").exists(), "a refusal leaves no folder behind"


def test_a_disk_that_fills_is_told_without_a_traceback(tmp_path, capsys, monkeypatch):
    def fill(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device", str(tmp_path / "out" / "results.json"))

    monkeypatch.setattr("exogauge.studies.evaluate.evaluate", fill)
    assert main(["run", "study", "--out", str(tmp_path / "out")]) == 2
    assert capsys.readouterr().err.endswith("out/results.json: No space left on device\n")


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no /dev/full here")
def test_output_that_nobody_can_take_is_told(tmp_path):
    code = (
        "import sys\nfrom exogauge.cli import at_service, main\n"
        "at_service.list_studies = lambda options: print('a study') or 0\nsys.exit(main(['studies']))"
    )
    with open("/dev/full", "w") as full:
        ended = subprocess.run(
            [sys.executable, "-c", code], stdout=full, stderr=subprocess.PIPE, text=True, check=False
        )
    assert (ended.returncode, ended.stderr) == (2, "exogauge studies: No space left on device\n")


def test_input_that_ends_where_something_is_asked_is_told(capsys, monkeypatch):
    monkeypatch.setattr("sys.stdin", io.StringIO(""))
    assert main(["login", "http://127.0.0.1:9"]) == 2
    assert "the input had ended" in capsys.readouterr().err


@pytest.mark.parametrize("url", ["nonsense", "ftp://x", "", "http://[::1", "http://a b/", "http://a:port", "http://"])
def test_what_is_no_address_is_not_tried_again(url, capsys):
    assert main(["wait", "some-id", "--server", url or " "]) == 2
    assert "no address of a service" in capsys.readouterr().err
    with pytest.raises(BadInput, match="no address"):
        Client(url)


@pytest.mark.parametrize(
    ("token", "code", "said"),
    [("exg_ü", 4, "no token has"), ("exg_a\nb", 4, "no token has"), ("exg_a\n", 3, "no answer")],
)
def test_a_token_with_foreign_letters_is_told_and_one_from_a_file_is_sent(token, code, said, capsys, monkeypatch):
    monkeypatch.setattr("exogauge.client.transport.ATTEMPTS", 1)
    monkeypatch.setenv("EXOGAUGE_TOKEN", token)
    assert main(["studies", "--server", "http://127.0.0.1:9"]) == code
    assert said in capsys.readouterr().err
