"""Spans for OpenTelemetry. FastAPI makes one for each request; here is one for each attempt at a job, its stages as
events.

They go to the collector that OpenTelemetry's own variables name, over HTTP; where none is named, nothing is recorded.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager

from opentelemetry import trace
from opentelemetry.trace import SpanKind, Status, StatusCode

from exogauge.errors import BadInput, Fault

COLLECTOR = ("OTEL_EXPORTER_OTLP_TRACES_ENDPOINT", "OTEL_EXPORTER_OTLP_ENDPOINT")
Facts = Mapping[str, str | int]

tracer = trace.get_tracer("exogauge")


def send_spans(part: str) -> Callable[[], None]:
    """Of this process from now on, as service `exogauge-<part>` unless OTEL_SERVICE_NAME says otherwise. What is
    returned sends those that wait, for a process that ends without further ado."""
    named = next((name for name in COLLECTOR if os.environ.get(name)), None)
    if named is None:
        return lambda: None
    try:
        from opentelemetry.exporter.otlp.proto.http.trace_exporter import OTLPSpanExporter
        from opentelemetry.sdk.resources import Resource
        from opentelemetry.sdk.trace import TracerProvider
        from opentelemetry.sdk.trace.export import BatchSpanProcessor
    except ImportError as error:
        advice = "Install it with `pip install 'exogauge[telemetry]'`, or leave the variable away."
        raise BadInput(Fault(f"a collector is named, and {error.name} is not installed", "no_telemetry", advice,
                             column=named)) from error  # fmt: skip
    name = os.environ.get("OTEL_SERVICE_NAME", f"exogauge-{part}")
    provider = TracerProvider(resource=Resource.create({"service.name": name}))
    provider.add_span_processor(BatchSpanProcessor(OTLPSpanExporter()))
    trace.set_tracer_provider(provider)

    def flush() -> None:
        provider.force_flush(timeout_millis=2000)

    return flush


@contextmanager
def of_job(kind: str, facts: Facts) -> Iterator[None]:
    with tracer.start_as_current_span(f"job {kind}", kind=SpanKind.CONSUMER, attributes=dict(facts)):
        yield


def stage(name: str) -> None:
    """The job that is under way has come to this."""
    trace.get_current_span().add_event(name)


def failed(reason: str) -> None:
    """So has the job that is under way."""
    trace.get_current_span().set_status(Status(StatusCode.ERROR, reason))
