"""The demonstration: a synthetic study goes through the whole service, over HTTP, and its result is printed.

The server runs as a process of its own on a free port; the sample is generated once and kept. Running it again finds
the same study and the same result.
"""

from __future__ import annotations

import hashlib
import io
import json
import os
import re
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import final

from exogauge import synthetic
from exogauge.client import Client
from exogauge.errors import BadMotion, Fault, Unavailable
from exogauge.settings import Settings
from exogauge.studies.report.summary_text import summary_text
from exogauge.synthetic.disturbances import DEFAULT
from exogauge.terminal import bar, text_table

SEED = 1
START_S = 120.0
SLOWER = (1.0, 1.5, 2.0)  # judgement: times the time; a bow of 02_06 stood at the first with 30 mm
MARGINS_M = (0.02, 0.03, 0.04)  # of the centre of pressure: nothing but the plan keeps the sample's robot upright
ANNOUNCED = "exogauge serves on "


@final
@dataclass(frozen=True)
class Captured:
    """A person's motion for the demonstration. end: [s] of it, None for all. slow: times the time, None for the first
    of `SLOWER` at which the sample's robot stands."""

    file: Path
    skeleton: Path | None = None
    end: float | None = None
    slow: float | None = None


def demo(settings: Settings, realism: str = DEFAULT, captured: Captured | None = None) -> None:
    """Make the sample, serve, upload, run, print. captured: what the robot plays in place of its own motions."""
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(line_buffering=True)  # in step with stderr, also through a pipe
    print("A synthetic humanoid's logs go through the service, over HTTP; about two minutes the first time.\n")
    with running_server(settings) as url, Client(url) as client:
        print(f"service     {url}")
        planned = None if captured is None else plan_captured(client, captured, settings.data_dir / "sample", realism)
        with timed("sample"):
            sample = make_sample(settings.data_dir / "sample", realism, planned)
        with timed("upload"):
            study = client.upload_study(sample)
        print(f"study       {study.name}, content {study.content_hash[:12]}")
        with timed("evaluation"):
            job = client.wait(client.submit(study))
        result = client.results(job)
        files = [artifact.name for artifact in client.artifacts(job)]
    print(f"\n{summary_text(result)}")
    if result.get("support"):
        print(f"\n{published()}")
    series = sum(name.startswith("series/") for name in files)
    others = ", ".join(name for name in files if not name.startswith("series/"))
    page = f"http://{settings.host}:{settings.port}{settings.root_path}"
    print(f"\nFILES  {others}, {series} series (Parquet)")
    print(f"\nTo look at the same result in the browser: `make serve`, then open\n  {page}/")
    print(f"  {page}/api/v1/jobs/{job.id}/artifacts/report.html   (plots and tables)")


@contextmanager
def timed(what: str) -> Iterator[None]:
    start = time.monotonic()
    yield
    print(f"{what:11} {time.monotonic() - start:.1f} s")


def plan_captured(client: Client, captured: Captured, folder: Path, realism: str = DEFAULT) -> Path:
    """The motion of a person as one of the sample's robot, in a table below `folder`: the fastest, and of these the one
    with the least margin, with which it stands in every run of the sample. Raises BadMotion with what was tried."""
    synthetic.write_sample_robot(folder / "robot")
    motion = client.upload_motion(captured.file, captured.skeleton)
    robot = client.upload_robot(folder / "robot" / "robot.yaml")
    options = {} if captured.end is None else {"end": captured.end}
    table = folder / f"{re.sub(r'[^A-Za-z0-9_-]', '_', captured.file.stem)}.csv"
    tried = list[str]()
    for slow, margin in product(SLOWER if captured.slow is None else (captured.slow,), MARGINS_M):
        with timed("motion"):
            plan = client.wait_plan(client.plan_motion(motion, robot, slow=slow, margin_m=margin, **options))
        found = plan.found or {}
        said = f"{slow:g} times the time, {1e3 * margin:g} mm of margin"
        try:
            if found.get("broken"):
                raise BadMotion(Fault("; ".join(found["broken"]), "bound_broken", "", captured.file.name))
            client.export_plan(plan, "csv", table)
            synthetic.refuse_fall(table, SEED, realism)
        except BadMotion as why:
            tried.append(f"{said}: {why.faults[0].detail}")
            print(f"            {tried[-1]}")
        else:
            print(f"plan        {plan.name}, {found['seconds']:.1f} s, {said}: the robot stands")
            return table
    advice = "Take a shorter part of it (--to), or play it slower (--slow)"
    raise BadMotion(Fault(f"the robot cannot: {'; '.join(tried)}", "cannot_stand", advice, captured.file.name))


def make_sample(folder: Path, realism: str, planned: Path | None = None) -> Path:
    """The sample study below `folder`, generated when it is not there; a half-made one never looks whole. planned: a
    motion that is played; each has a sample of its own."""
    own = "" if planned is None else f"_{hashlib.sha256(planned.read_bytes()).hexdigest()[:12]}"
    target = folder / f"hrp4_like_{SEED}{'' if realism == DEFAULT else f'_{realism}'}{own}"
    if not _is_there(target, realism):
        unfinished = folder / f".unfinished-{os.getpid()}"
        shutil.rmtree(unfinished, ignore_errors=True)
        print("generating the sample study, once; it is kept in the data folder")
        with bar("sample") as progress:
            processes = synthetic.processors()
            motions = [] if planned is None else [planned]
            synthetic.write_sample(
                unfinished, SEED, progress=progress, processes=processes, realism=realism, motions=motions
            )
        shutil.rmtree(target, ignore_errors=True)
        unfinished.replace(target)
    return target


def _is_there(target: Path, realism: str) -> bool:
    """Once it had no suits, and no disturbances."""
    if not all((target / name).is_file() for name in ("study.yaml", "device_modified.yaml", "truth.json")):
        return False
    return ("disturbances" in json.loads((target / "truth.json").read_bytes())) == (realism != "ideal")


@contextmanager
def running_server(settings: Settings) -> Iterator[str]:
    """The address of a server on a free port, ended at the end; its output goes to `demo-server.log`."""
    settings.data_dir.mkdir(parents=True, exist_ok=True)
    output = settings.data_dir / "demo-server.log"
    command = [sys.executable, "-m", "exogauge.cli", "--verbose", "serve", "--port", "0", "--with-parent"]
    with output.open("wb") as log:
        environment = {**os.environ, "EXOGAUGE_DATA_DIR": str(settings.data_dir)}
        server = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=log, stderr=log, env=environment)
    try:
        yield announced_address(server, output)
    finally:
        server.terminate()
        assert server.stdin is not None
        server.stdin.close()
        try:
            server.wait(timeout=30.0)
        except subprocess.TimeoutExpired:
            server.kill()
            server.wait()


def announced_address(server: subprocess.Popen[bytes], output: Path) -> str:
    """Wait until the server says where it listens."""
    give_up = time.monotonic() + START_S
    while time.monotonic() < give_up and server.poll() is None:
        for line in output.read_text(errors="replace").splitlines():
            if line.startswith(ANNOUNCED):
                return line.removeprefix(ANNOUNCED)
        time.sleep(0.1)
    tail = output.read_text(errors="replace")[-2000:]
    raise Unavailable(f"the server did not start; the end of {output.name}:\n{tail}")


SUPPORT = (  # motion, suit, RMSE [N·m] of A, B and a-priori values against the band simulation: captions of Figs 12, 13
    ("bending, torso pitch", "normal", "1.97", "2.65", "7.42"),
    ("bending, torso pitch", "modified", "2.56", "3.32", "7.66"),
    ("twisting, torso yaw", "normal", "1.84", "2.51", "5.08"),
    ("twisting, torso yaw", "modified", "1.73", "2.17", "4.71"),
)
STIFFNESS = (  # suit, stiffness [N/m]: truth, A, B, a-priori values: Tables 2 and 3
    ("normal", "197.8", "185.8 (6.1 %)", "181.3 (8.3 %)", "65.8 (66.7 %)"),
    ("modified", "395.6", "364.6 (7.9 %)", "331.5 (16.2 %)", "207.1 (47.8 %)"),
)


def published() -> str:
    return "\n".join(
        [
            "PUBLISHED for HRP-4, measured on the real robot in a real suit; not this sample, whose data are synthetic",
            "",
            text_table(("RMSE, N·m", "suit", "A", "B", "maker's"), SUPPORT),
            "",
            text_table(("stiffness, N/m", "truth", "A", "B", "maker's"), STIFFNESS),
        ]
    )
