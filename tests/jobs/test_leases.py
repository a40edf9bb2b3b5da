"""A worker that leaves on its own is not one that was declared dead."""

from __future__ import annotations

import threading
import time

import pytest

from exogauge.jobs.leases import Lease
from exogauge.storage.store import Storage


@pytest.mark.slow
@pytest.mark.parametrize("database_url", ["sqlite"], indirect=True)
def test_a_beat_that_comes_after_the_lease_was_given_back_declares_nobody_dead(storage: Storage) -> None:
    lost = list[str]()
    for number in range(4):
        name = f"worker-{number}"
        lease = Lease(storage.engine, name, 0.15)
        lease.take()
        lease.keep(lambda name=name: lost.append(name), lambda may_judge: None)  # type: ignore[misc]
        back = threading.Thread(target=lease.give_back)
        with storage.engine.connect() as other, other.begin():
            other.exec_driver_sql("UPDATE worker_leases SET pid = pid")  # nobody else writes meanwhile
            time.sleep(0.4)  # a beat waits for its turn, and asks more and more seldom
            back.start()
            time.sleep(0.02)
        back.join()
        time.sleep(0.2)
    assert lost == []
