"""Changes as plain values become the changes that `devices` applies."""

from __future__ import annotations

from collections.abc import Sequence

from exogauge.devices.band_changes import (
    AddBand,
    CopyBand,
    InsertPoint,
    MirrorBand,
    MovePoint,
    PlacePoint,
    RemoveBand,
    RemovePoint,
)
from exogauge.devices.changes import Change, Law, NaturalLength, Pretension, Stiffness
from exogauge.devices.device import Band, ViaPoint
from exogauge.studies.device_pages import change_entries as entries
from exogauge.studies.device_pages.change_entries import ChangeEntry, NewBand


def changes_of(written: Sequence[ChangeEntry]) -> tuple[Change, ...]:
    return tuple(change_of(entry) for entry in written)


def change_of(entry: ChangeEntry) -> Change:
    match entry:
        case entries.StiffnessEntry():
            return Stiffness(entry.of, entry.to, entry.times)
        case entries.NaturalLengthEntry():
            return NaturalLength(entry.of, entry.to, entry.by, entry.times)
        case entries.PretensionEntry():
            return Pretension(entry.of, entry.to)
        case entries.LawEntry():
            return Law(entry.of, entry.law, entry.values)
        case entries.MovePointEntry():
            return MovePoint(entry.band, entry.point, entry.by)
        case entries.PlacePointEntry():
            return PlacePoint(entry.band, entry.point, entry.xyz, entry.link)
        case entries.AddPointEntry():
            return InsertPoint(entry.band, entry.at, entry.link, entry.xyz)
        case entries.RemovePointEntry():
            return RemovePoint(entry.band, entry.point)
        case entries.RemoveBandEntry():
            return RemoveBand(entry.of)
        case entries.AddBandEntry():
            return AddBand(band_of(entry.band))
        case entries.CopyBandEntry():
            return CopyBand(entry.band, entry.name, entry.group)
        case entries.MirrorBandEntry():
            return MirrorBand(entry.band, entry.name, entry.group, entry.links)


def band_of(written: NewBand) -> Band:
    return Band(
        name=written.name,
        group=written.group or written.name,
        via_points=tuple(ViaPoint(point.link, point.xyz) for point in written.via_points),
        stiffness=written.stiffness_n_per_m,
        natural_length=written.natural_length_m,
        ground_truth=written.ground_truth,
        law=written.law,
        law_values=dict(written.law_values),
    )
