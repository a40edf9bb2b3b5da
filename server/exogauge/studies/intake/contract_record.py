"""What a study says of the wear and of the day, for the configuration record: for people; no number depends on it."""

from __future__ import annotations

from datetime import date
from typing import Annotated, Any

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field


def _as_day(value: Any) -> Any:
    """YAML makes a date of 2026-03-01."""
    return value.isoformat() if type(value) is date else value


def _as_text(value: Any) -> Any:
    """A serial number or size may be written as a number."""
    return str(value) if isinstance(value, int | float) and not isinstance(value, bool) else value


Text = Annotated[str, BeforeValidator(_as_text), Field(min_length=1, max_length=200, pattern=r"^[^\x00-\x1f\x7f]+$")]
Day = Annotated[str, BeforeValidator(_as_day), Field(pattern=r"^\d{4}-\d{2}-\d{2}$")]


class _Told(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class DeviceRecord(_Told):
    """`record` in device.yaml: which specimen was worn, and how."""

    model: Text | None = None
    size: Text | None = None
    serial: Text | None = None
    straps: Text | None = None
    pretension: Text | None = None
    garment: Text | None = None


class Conditions(_Told):
    """`conditions` in study.yaml: when and under what the logs were recorded."""

    recorded: Day | None = None
    place: Text | None = None
    temperature: Text | None = None
    robot_cover: Text | None = None
    payload: Text | None = None
