"""A Slurm of one node, this machine, with daemons of its own: for whoever may start them."""

from __future__ import annotations

import os
import shutil
import socket
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

DAEMONS = ("munged", "slurmctld", "slurmd", "sbatch", "sinfo")
CONFIG = """
ClusterName=exogauge
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={ports[0]}
SlurmdPort={ports[1]}
AuthType=auth/munge
AuthInfo=socket={folder}/munge/socket
CryptoType=crypto/munge
SlurmUser=root
SlurmdUser=root
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/pgid
TaskPlugin=task/none
SwitchType=switch/none
MpiDefault=none
SchedulerType=sched/backfill
SelectType=select/cons_tres
ReturnToService=2
NodeName={host} NodeAddr=127.0.0.1 CPUs={cores} State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP OverSubscribe=FORCE:4
"""


def free_port() -> int:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port: int = free.getsockname()[1]
        return port


@contextmanager
def slurm(folder: Path) -> Iterator[dict[str, str]]:
    """What is added to the environment of whoever asks this Slurm."""
    if os.getuid() != 0 or any(shutil.which(name, path="/usr/bin:/usr/sbin") is None for name in DAEMONS):
        pytest.skip("no Slurm of its own can be started here: it takes root and Debian's package slurm-wlm")
    for name in ("state", "spool", "munge"):
        (folder / name).mkdir(mode=0o755)
    key = folder / "munge" / "key"
    key.write_bytes(os.urandom(1024))
    key.chmod(0o600)
    host = socket.gethostname().split(".")[0]
    config = folder / "slurm.conf"
    ports = [free_port(), free_port()]
    config.write_text(CONFIG.format(host=host, ports=ports, folder=folder, cores=os.cpu_count()))
    ours = {"SLURM_CONF": str(config)}
    munged = ["munged", "-F", "--force", f"--key-file={key}", f"--socket={folder}/munge/socket"]
    munged += [f"--{each}-file={folder}/munge/{each}" for each in ("pid", "log", "seed")]
    started = list[subprocess.Popen[bytes]]()
    try:
        for command in (munged, ["slurmctld", "-D"], ["slurmd", "-D", "-N", host]):
            with (folder / f"{command[0]}.out").open("wb") as out:
                path = {"PATH": f"{os.environ['PATH']}:/usr/sbin"}
                started.append(subprocess.Popen(command, env={**os.environ, **path, **ours}, stdout=out, stderr=out))
            time.sleep(0.5)
        until = time.monotonic() + 30.0
        while (
            b"idle" not in (told := subprocess.run(["sinfo"], env={**os.environ, **ours}, capture_output=True)).stdout
        ):
            if time.monotonic() > until:
                pytest.skip(f"Slurm does not start here: {told.stdout + told.stderr!r}")
            time.sleep(0.2)
        yield ours
    finally:
        for each in reversed(started):
            each.terminate()
            each.wait(20.0)
