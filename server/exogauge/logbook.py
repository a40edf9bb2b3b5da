"""What goes into the log: words, or one JSON object per line, with the request and the job that it is of."""

from __future__ import annotations

import json
import logging
import sys
from contextvars import ContextVar
from datetime import UTC, datetime
from typing import Any, Literal, final

request_id: ContextVar[str | None] = ContextVar("request_id", default=None)
job_id: ContextVar[str | None] = ContextVar("job_id", default=None)
WORDS = "%(asctime)s %(levelname)s %(name)s: %(message)s"


@final
class AsJson(logging.Formatter):
    """facts: what a record brings as `extra={"facts": {…}}`."""

    def format(self, record: logging.LogRecord) -> str:
        told: dict[str, Any] = {
            "at": datetime.fromtimestamp(record.created, UTC).isoformat(timespec="milliseconds"),
            "level": record.levelname.lower(),
            "from": record.name,
            "message": record.getMessage(),
        }
        told |= {"request": request_id.get(), "job": job_id.get(), **getattr(record, "facts", {})}
        if record.exc_info:
            told["trace"] = self.formatException(record.exc_info)
        return json.dumps({key: value for key, value in told.items() if value is not None}, default=str)


def keep(form: Literal["words", "json"], level: int) -> None:
    """Of this process, on standard error."""
    handler = logging.StreamHandler(sys.stderr)
    handler.setFormatter(AsJson() if form == "json" else logging.Formatter(WORDS))
    logging.basicConfig(level=level, handlers=[handler], force=True)
