"""Studies at a real service, by command: what goes to which stream, how a command ends, and that it may be repeated."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path

import pytest

from exogauge.cli import main
from exogauge.client import Client, ClientProblem, transport, uploading

pytestmark = pytest.mark.slow
SCRIPT = Path(__file__).parents[2] / "docs" / "examples" / "nightly.sh"
NOBODY = "http://127.0.0.1:9"


@pytest.fixture
def told(capsys: pytest.CaptureFixture[str]) -> Callable[..., tuple[int, str, str]]:
    """told(arguments): how the command ended, what it wrote to stdout and to stderr."""

    def run(*arguments: object) -> tuple[int, str, str]:
        capsys.readouterr()
        code = main([str(each) for each in arguments])
        said = capsys.readouterr()
        assert "Traceback" not in said.err
        return code, said.out, said.err

    return run


def test_a_study_goes_from_its_folder_to_tables_by_commands(told, service, worn_study, tmp_path, monkeypatch):
    monkeypatch.setenv("EXOGAUGE_URL", service.url)
    folder = worn_study(True)
    ended, study, said = told("upload", folder)
    assert (ended, study.count("\n"), "Worn arm" in said) == (0, 1, True)
    assert told("upload", folder / "study.yaml") == (0, study, said)
    assert json.loads(told("upload", folder, "--json")[1])["id"] == study.strip()
    assert told("results", study.strip())[0] == 2  # nothing was evaluated yet

    asked = ("run", folder, "--server", service.url)
    refused = told(*asked, "--set", "cutof_hz=9")
    assert (refused[0], "settings.cutof_hz" in refused[2]) == (2, True)
    ended, job, said = told(*asked, "--no-wait")
    job = job.strip()
    assert (ended, f"study {study}job {job}\n" in said) == (0, True)
    ended, written, said = told(*asked, "--out", tmp_path / "out")
    assert (ended, f"job {job}" in said, "succeeded" in said) == (0, True, True)
    assert [Path(line).name for line in written.split()] == ["report.html", "results.json"]
    results = json.loads((tmp_path / "out" / "results.json").read_text())
    assert json.loads(told(*asked, "--json")[1])["id"] == job
    assert told("wait", job)[:2] == (0, f"{job} succeeded\n")

    for key in (job, study.strip()):
        assert json.loads(told("results", key, "--json")[1]) == results
        assert "Worn arm" in told("results", key)[1]
    before = {path: path.stat().st_mtime_ns for path in (tmp_path / "out").rglob("*") if path.is_file()}
    (tmp_path / "out" / "stiffness.csv").write_text("damaged")
    assert told("results", job, "--out", tmp_path / "out")[0] == 0
    assert (tmp_path / "out" / "stiffness.csv").read_text().startswith("device,approach")
    after = {path: path.stat().st_mtime_ns for path in before}
    changed = {path.name for path in before if before[path] != after[path]}
    assert changed == {"stiffness.csv", "results.json"}  # the rest was there

    assert told("compare", job, study.strip(), "--table", "stiffness")[1].startswith("job,study,")
    assert told("compare", job, "--latex")[1].startswith(r"\begin{tabular}")
    assert [each["id"] for each in json.loads(told("compare", job, "--json")[1])["jobs"]] == [job]
    assert "worn" in told("export", job)[1]
    window = (
        "export",
        job,
        "worn",
        "--out",
        tmp_path / "w.csv",
        "--from",
        1,
        "--to",
        2,
        "--channel",
        "support_a.elbow",
    )
    assert told(*window)[:2] == (0, f"{tmp_path / 'w.csv'}\n")
    assert (tmp_path / "w.csv").read_text().startswith('"t","support_a.elbow"\n1,')
    assert (job, "Worn arm" in told("studies", "--search", "worn")[1]) == (job, True)
    assert study.strip() in [each["id"] for each in json.loads(told("studies", "--json")[1])]

    asked = ("publish", study.strip(), "--title", "An arm", "--creator", "Noether, Emmy; Göttingen")
    first, again = told(*asked), told(*asked)
    assert (first[0], again) == (0, first)  # one snapshot, however often it is said
    assert told(*asked, "--inputs")[1] != first[1]


def test_how_a_command_ends_says_whether_another_try_may_help(told, service, study, tmp_path, monkeypatch):
    monkeypatch.setenv("EXOGAUGE_URL", service.url)
    with Client(service.url) as opened:

        def asked(**settings):
            return opened.submit(study, "burn", {"ledger": str(tmp_path / "ledger"), **settings}).id

        bad, defect = asked(mode="bad", seconds=0.1), asked(mode="defect", seconds=0.1)
        ended, out, said = told("wait", bad)
        assert (ended, out) == (2, f"{bad} failed\n")
        assert "logs/a.csv, column 't': the log has no column. Add it." in said
        assert told("wait", defect, bad)[0] == 2
        assert told("wait", defect)[0] == 1
        long = asked(seconds=60)
        ended, out, said = told("wait", long, "--timeout", 0.5)
        assert (ended, out, "is still" in said) == (3, "", True)
        assert told("cancel", long)[0] == 0
        assert told("wait", long)[:2] == (1, f"{long} cancelled\n")
    assert told("wait", "0" * 8 + "-0000-0000-0000-" + "0" * 12)[0] == 2
    assert told("wait", "../../../etc/passwd")[0] == 2
    assert told("results", tmp_path)[0] == 2

    monkeypatch.setattr(transport, "ATTEMPTS", 1)
    ended, _, said = told("upload", tmp_path, "--server", NOBODY)
    assert (ended, "study.yaml" in said) == (2, True)  # looked at before anybody is asked
    assert told("studies", "--server", NOBODY)[0] == 3
    assert told("studies", "--server", "no address")[0] in (2, 3)


@pytest.mark.parametrize(
    ("option", "said"),
    [(("--no-wait",), "--no-wait"), (("--kind", "support"), "--kind"), (("--set", "a=1"), "--set"), ((), "--out")],
)
def test_what_needs_a_service_is_not_done_without_one(told, study_folder, option, said):
    ended, out, err = told("run", study_folder, *option)
    assert (ended, out, said in err) == (2, "", True)


def test_an_automatic_lab_runs_the_example(service, worn_study, study_folder, tmp_path):
    """The script of the documents, twice; and what it says of a study that is none."""
    recordings, found = tmp_path / "recordings", tmp_path / "found"
    shutil.copytree(worn_study(True), recordings / "arm")
    (recordings / "empty").mkdir()
    environment = {**os.environ, "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"}

    def run(url: str) -> subprocess.CompletedProcess[str]:
        command = ["sh", str(SCRIPT), str(recordings), str(found)]
        return subprocess.run(
            command, env={**environment, "EXOGAUGE_URL": url}, capture_output=True, text=True, timeout=300
        )

    first = run(service.url)
    assert (first.returncode, "empty: ended with 2" in first.stderr) == (1, True), first.stderr
    table = (found / "stiffness.csv").read_text()
    assert len(table.splitlines()) > 1
    assert json.loads((found / "arm" / "results.json").read_text())["stiffness"]
    (recordings / "empty").rmdir()
    again = run(service.url)
    assert again.returncode == 0, again.stderr
    assert (found / "stiffness.csv").read_text() == table
    with Client(service.url) as opened:
        study = opened.upload_study(recordings / "arm")
        assert len([each for each in opened.jobs(study) if each.kind == "evaluate"]) == 1


LOGIN = "<html><script>evil()</script><body>\x1b[31mPlease <b>sign in</b></body></html>"


@contextmanager
def another(status: int, body: str, kind: str, **headers: str) -> Iterator[str]:
    """The address of something that is no exogauge."""

    class Answers(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self.rfile.read(int(self.headers.get("Content-Length", 0)))
            self.send_response(status)
            for name, value in {"Content-Type": kind, **headers}.items():
                self.send_header(name, value)
            self.end_headers()
            self.wfile.write(body.encode() if self.command != "HEAD" else b"")

        do_POST = do_HEAD = do_PATCH = do_DELETE = do_GET

        def log_message(self, *_: object) -> None: ...

    with HTTPServer(("127.0.0.1", 0), Answers) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}"
        server.shutdown()


@pytest.mark.parametrize(
    ("status", "body", "kind", "headers", "ended", "says"),
    [
        (200, LOGIN, "text/html", {}, 2, "'Please sign in'"),
        (200, '{"ok": true}', "application/json", {}, 2, "exogauge"),
        (200, "[1]", "application/json", {}, 2, "does not answer as exogauge does"),
        (302, "", "text/html", {"Location": "https://login.example/?a"}, 2, "https://login.example/"),
        (403, LOGIN, "text/html", {}, 4, "not by exogauge"),
        (404, LOGIN, "text/html", {}, 2, "not by exogauge"),
        (502, LOGIN, "text/html", {"Retry-After": "0"}, 3, "not by exogauge"),
    ],
)
def test_what_answers_in_the_services_place_is_told_as_such(
    told, study_folder, tmp_path, monkeypatch, status, body, kind, headers, ended, says
):
    monkeypatch.setattr(transport, "FIRST_PAUSE_S", 0.001)
    job = "12345678-1234-1234-1234-123456789012"
    with another(status, body, kind, **headers) as url:
        for command in (
            ("studies",), ("upload", study_folder), ("wait", job), ("results", job, "--out", tmp_path / "out"),
            ("compare", job), ("run", study_folder),
        ):  # fmt: skip
            code, out, said = told(*command, "--server", url)
            assert (code, out) == (ended, ""), (command, said)
            assert says in said, (command, said)
            assert "\x1b" not in said
        if kind == "text/html":
            with Client(url) as opened, pytest.raises(ClientProblem):
                opened.export_series(job, "a", tmp_path / "a.csv")
        monkeypatch.setattr(uploading, "LARGE", 1)
        assert told("upload", study_folder, "--server", url)[0] == ended
    assert not list(tmp_path.glob("out/*"))
    assert not (tmp_path / "a.csv").exists()


def test_an_upload_that_was_broken_off_goes_on_in_another_process(service, tmp_path, monkeypatch):
    monkeypatch.setattr(uploading, "PIECE", 1000)
    file = tmp_path / "large.bin"
    file.write_bytes(os.urandom(5500))
    first, second = list[int](), list[int]()

    def broken(sent: int) -> None:
        first.append(sent)
        if sent >= 3000:
            raise KeyboardInterrupt

    with Client(service.url) as opened, pytest.raises(KeyboardInterrupt):
        uploading.upload(opened._http, file, broken)
    with Client(service.url) as opened:
        key = uploading.upload(opened._http, file, second.append)
        assert (first, second) == ([1000, 2000, 3000], [4000, 5000, 5500])
        assert (service.folder / "data" / "uploads" / key).read_bytes() == file.read_bytes()
        file.write_bytes(os.urandom(5500))  # other bytes under the same name are another file
        assert uploading.upload(opened._http, file) != key
        with pytest.raises(ClientProblem, match=r"study\.yaml"):
            opened.study_of_uploads([key], ["large.bin"])


def test_two_who_hand_in_the_same_large_study_at_once_both_have_it(service, study_folder, monkeypatch):
    monkeypatch.setattr(uploading, "LARGE", 1)
    monkeypatch.setattr(uploading, "PIECE", 300)
    (study_folder / "note.txt").write_text(os.urandom(2000).hex())
    found = list[str]()

    def send() -> None:
        with Client(service.url) as opened:
            found.append(opened.upload_study(study_folder).id)

    both = [threading.Thread(target=send) for _ in range(2)]
    for each in both:
        each.start()
    for each in both:
        each.join()
    assert len(found) == 2
    assert len(set(found)) == 1
