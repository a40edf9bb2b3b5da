"""The demonstration: a synthetic study goes through the whole service, over HTTP, and its result is printed.

The server runs as a process of its own on a free port; the sample is generated once and kept. Running it again finds
the same study and the same result.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import textwrap
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from exogauge import synthetic
from exogauge.client import Client
from exogauge.errors import Unavailable
from exogauge.settings import Settings
from exogauge.terminal import bar, text_table

SEED = 1
START_S = 120.0
ANNOUNCED = "exogauge serves on "
BASE = ("base.fx", "base.fy", "base.fz", "base.mx", "base.my", "base.mz")
TRUNK = ("torso", "waist", "chest", "lumbar", "trunk")
SHOWN_JOINTS = 6
JOINT_PARAMETERS = ("k_T", "k_d", "tau_c", "tau_s", "tau_o")


def demo(settings: Settings) -> None:
    """Make the sample, serve, upload, run, print."""
    sample = make_sample(settings.data_dir / "sample")
    with running_server(settings) as url, Client(url) as client:
        print(f"service: {url}")
        study = client.upload_study(sample)
        print(f"study:   {study.name}")
        job = client.wait(client.submit(study))
        result = client.results(job)
        files = [artifact.name for artifact in client.artifacts(job)]
    print_result(result)
    print(f"\nfiles kept with the result: {', '.join(files)}")
    print("\nTo look at the same result in the browser: `make serve`, then open")
    print(f"  http://{settings.host}:{settings.port}/")


def make_sample(folder: Path) -> Path:
    """The sample study below `folder`, generated when it is not there; a half-made one never looks whole."""
    target = folder / f"hrp4_like_{SEED}"
    if not (target / "study.yaml").is_file():
        unfinished = folder / f".unfinished-{os.getpid()}"
        shutil.rmtree(unfinished, ignore_errors=True)
        print("generating the sample study (synthetic; once)")
        with bar("sample") as progress:
            synthetic.write_sample(unfinished, SEED, progress=progress)
        shutil.rmtree(target, ignore_errors=True)
        unfinished.replace(target)
    return target


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


def print_result(result: Mapping[str, Any]) -> None:
    """Held-out errors before and after, then some of the joints' parameters."""
    found = result["identification"]
    held_out = [fit for fit in found["validation"] if fit["held_out"]]
    print("\nHeld-out RMSE: the a-priori model, the identified model, and the noise of the measurement")
    wanted = [fit for fit in held_out if fit["channel"] in BASE or is_trunk(fit["channel"])]
    columns = ("log", "channel", "prior", "identified", "noise", "unit")
    keys = ("log", "channel", "rmse_prior", "rmse_identified", "noise_floor", "unit")
    print(text_table(columns, [[fit[key] for key in keys] for fit in wanted]))
    if found.get("summary"):
        print("\nThe same, over all held-out samples")
        rows = [summary_row(each) for each in found["summary"]]
        print(text_table(("what", "prior", "identified", "noise", "identified/prior", "unit"), rows))
    print("\nJoint parameters: value ± standard deviation")
    joints = sorted(found["joints"], key=lambda entry: not is_trunk(entry["joint"]))[:SHOWN_JOINTS]
    print(text_table(("joint", *JOINT_PARAMETERS), [joint_row(entry) for entry in joints]))
    for warning in result.get("warnings", []):
        print("note:", textwrap.shorten(warning, 200, placeholder=" … (all of it in results.json)"))


def summary_row(summary: Mapping[str, Any]) -> Sequence[Any]:
    before, after = summary["rmse_prior"], summary["rmse_identified"]
    return [summary["kind"].replace("_", " "), before, after, summary["noise_floor"], after / before, summary["unit"]]


def joint_row(entry: Mapping[str, Any]) -> Sequence[str]:
    values = (entry.get(name) for name in JOINT_PARAMETERS)
    return [entry["joint"], *("" if each is None else quantity(each) for each in values)]


def quantity(entry: Mapping[str, Any]) -> str:
    if entry["value"] is None:
        return ""
    std = "" if entry["std"] is None else f" ± {entry['std']:.2g}"
    return f"{entry['value']:.4g}{std} {entry['unit']}"


def is_trunk(channel: str) -> bool:
    return any(word in channel.lower() for word in TRUNK)
