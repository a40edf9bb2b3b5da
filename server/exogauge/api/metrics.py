"""What Prometheus asks for: requests of this server, and what the whole installation has to do. It names no lab."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from typing import final

import sqlalchemy as sa
from fastapi import Request, Response
from prometheus_client import CONTENT_TYPE_LATEST, generate_latest
from prometheus_client.core import GaugeMetricFamily
from prometheus_client.registry import Collector

from exogauge.api.dependencies import SettingsDep
from exogauge.api.routing import Router
from exogauge.errors import NotFound, Unavailable
from exogauge.sandbox.asking import at_once
from exogauge.settings import Settings
from exogauge.storage import chores
from exogauge.storage.database import database_now
from exogauge.storage.store import Installation
from exogauge.storage.tables import STATES, Job, LiveStream

router = Router(root="", tags=["health"])
LOSSES = ("corrupt", "missing", "sizes", "broken")


@router.get(
    "/metrics",
    operation_id="getMetrics",
    response_class=Response,
    responses={200: {"description": "Text of Prometheus", "content": {"text/plain": {"schema": {"type": "string"}}}}},
)
def get_metrics(request: Request, settings: SettingsDep) -> Response:
    """404 unless this server listens on this machine alone, or EXOGAUGE_METRICS says that it is let out."""
    if not (settings.local_only if settings.metrics is None else settings.metrics):
        raise NotFound("this server tells no metrics (EXOGAUGE_METRICS)")
    return Response(generate_latest(request.app.state.measures.registry), media_type=CONTENT_TYPE_LATEST)


@final
class OfInstallation(Collector):
    """Asked of the database when Prometheus asks."""

    def __init__(self, installation: Installation, settings: Settings) -> None:
        self._installation, self._settings = installation, settings

    def describe(self) -> list[GaugeMetricFamily]:
        """Nothing is asked when it is registered."""
        return []

    def collect(self) -> Iterator[GaugeMetricFamily]:
        yield gauge("exogauge_readers", "Children that read uploads now", at_once.taken)
        yield gauge("exogauge_disk_free_bytes", "Where the data are", shutil.disk_usage(self._settings.data_dir).free)
        try:
            yield from self._of_database()
        except Unavailable:
            yield gauge("exogauge_database_up", "Whether the database answers", 0)

    def _of_database(self) -> Iterator[GaugeMetricFamily]:
        workers = self._installation.workers_alive()
        with self._installation.reading() as session:
            counted = sa.select(Job.state, sa.func.count().label("jobs")).group_by(Job.state)
            states = {row.state: row.jobs for row in session.execute(counted)}
            oldest = session.scalar(sa.select(sa.func.min(Job.created_at)).where(Job.state == "queued"))
            waited = 0.0 if oldest is None else (database_now(session) - oldest).total_seconds()
            cpu = session.scalar(sa.select(sa.func.sum(Job.cpu_s))) or 0.0
            live = session.scalar(sa.select(sa.func.count(LiveStream.id)).where(LiveStream.state == "open")) or 0
            told = chores.outcomes(session)
        yield gauge("exogauge_database_up", "Whether the database answers", 1)
        jobs = GaugeMetricFamily("exogauge_jobs", "Jobs of all labs", labels=["state"])
        for state in STATES:
            jobs.add_metric([state], states.get(state, 0))
        yield jobs
        yield gauge("exogauge_workers_alive", "Workers with a lease", workers)
        yield gauge("exogauge_oldest_queued_seconds", "How long the oldest queued job has waited", waited)
        yield gauge("exogauge_job_cpu_seconds", "CPU seconds of all jobs that are kept", cpu)
        yield gauge("exogauge_live_streams", "Live streams that are open", live)
        if (swept := told.get("sweep")) is not None:
            waiting = swept["orphans_waiting"]
            yield gauge("exogauge_orphans_waiting", "Blobs that nothing names, at the last sweep", waiting)
        if (checked := told.get("check")) is not None:
            lost = sum(checked[each]["count"] for each in LOSSES)
            yield gauge("exogauge_store_faults", "Blobs and rows found damaged or missing, at the last check", lost)


def gauge(name: str, words: str, value: float) -> GaugeMetricFamily:
    return GaugeMetricFamily(name, words, value=value)
