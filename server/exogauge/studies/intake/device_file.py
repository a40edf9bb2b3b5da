"""device.yaml becomes a `Device` of a given robot; whatever is wrong in it is told at once, each at its line."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from difflib import get_close_matches
from typing import Any, TypeVar, final

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ValidationError

from exogauge.criteria.identifying import DECLARED
from exogauge.criteria.supporting import DEVICES
from exogauge.devices.device import Band, BenchTest, Device, ViaPoint
from exogauge.devices.routing import Routing
from exogauge.effects.band_laws import law_faults
from exogauge.errors import BadStudy, Fault
from exogauge.logs.channels import shorten
from exogauge.robots.description import Robot
from exogauge.robots.tree import RigidTree
from exogauge.studies.intake import contract
from exogauge.studies.intake.bench_table import read_bench
from exogauge.studies.intake.bundle import Bundle
from exogauge.studies.intake.yaml_file import MAX_BYTES, Pointer, YamlPage, dotted, place, read_yaml, suggestion

Part = TypeVar("Part", bound=BaseModel)

SHOWN_LINKS = 30


@final
@dataclass(frozen=True)
class _Draft:
    """Band `index` as far as it can be read.

    values: without the keys that are broken. points: (index, via point), of as many as are written.
    """

    index: int
    values: contract.Band
    points: tuple[tuple[int, contract.ViaPoint], ...]
    written: int

    def at(self, *deeper: str | int) -> Pointer:
        return ("bands", self.index, *deeper)


def read_device(
    bundle: Bundle, file: str, robot: Robot, named_in: str | None = None, row: int | None = None, column: str = "device"
) -> Device:
    """The device that `file` describes, on this robot. Raises BadStudy with every fault that can be found.

    named_in, row, column: where the file's name is written.
    """
    data = bundle.read(file, limit=MAX_BYTES, named_in=named_in, column=column, row=row)
    page = YamlPage(file, data)
    entry, content, faults = read_yaml(data, contract.DeviceFile, file=file)
    drafts = _drafts(content)
    faults += _name_faults(drafts, page)
    faults += _group_faults(drafts, content, page)
    for draft in drafts:
        faults += _law_faults(draft, page)
    faults += _place_faults(drafts, robot.tree, page)
    benches, bench_faults = _benches(drafts, bundle, page)
    faults += bench_faults
    if faults or entry is None:
        raise BadStudy(sorted(faults, key=lambda fault: (fault.file != file, fault.row or 0)))
    return _device(entry, benches)


def _device(entry: contract.DeviceFile, benches: dict[int, BenchTest]) -> Device:
    """Bands of one group share their stiffness, so one that gives none takes that of its group."""
    known: dict[str, float] = {}
    point_std, donning_std = _uncertainty(entry)
    for band in entry.bands:
        if band.stiffness_n_per_m is not None:
            known.setdefault(band.group or band.name, band.stiffness_n_per_m)
    bands = tuple(
        Band(
            name=band.name,
            group=band.group or band.name,
            via_points=tuple(ViaPoint(point.link, point.xyz) for point in band.via_points),
            stiffness=known.get(band.group or band.name),
            natural_length=band.natural_length_m,
            ground_truth=band.ground_truth,
            law=band.law,
            law_values=dict(band.law_values),
            bench=benches.get(k),
            point_std=point_std,
            donning_std=donning_std,
        )
        for k, band in enumerate(entry.bands)
    )
    return Device(entry.name, bands, frozenset(entry.tied))


def _uncertainty(entry: contract.DeviceFile) -> tuple[float, float]:
    """[m] of via points and of putting it on, as stated or as is usual."""
    if entry.uncertainty == "none":
        return 0.0, 0.0
    stated, usual = entry.uncertainty, DECLARED
    return (
        usual.via_points if stated.via_points is None else stated.via_points,
        usual.donning if stated.donning is None else stated.donning,
    )


def _drafts(content: dict[Any, Any]) -> list[_Draft]:
    """What can be read of every band, also where the file as a whole cannot."""
    drafts = []
    written = content.get("bands")
    for k, band in enumerate(written[:200] if isinstance(written, list) else []):
        if not isinstance(band, dict):
            continue
        via_points = band.get("via_points")
        listed = list(enumerate(via_points[:50])) if isinstance(via_points, list) else []
        points = tuple((j, point) for j, each in listed if (point := _read(contract.ViaPoint, each)) is not None)
        values = _readable(band, k)
        if values is not None:
            drafts.append(_Draft(k, values, points, len(listed)))
    return drafts


def _readable(written: dict[Any, Any], index: int) -> contract.Band | None:
    anywhere = [{"link": "-", "xyz": [0.0, 0.0, 0.0]}] * 2
    kept: dict[Any, Any] = {**written, "via_points": anywhere}
    try:
        return contract.Band.model_validate(kept)
    except ValidationError as invalid:
        broken = {item["loc"][0] for item in invalid.errors() if item["loc"]}
    kept = {key: value for key, value in kept.items() if isinstance(key, str) and key not in broken}
    return _read(contract.Band, {"name": f"band {index}", **kept})


def _read(model: type[Part], written: object) -> Part | None:
    try:
        return model.model_validate(written)
    except ValidationError:
        return None


def _name_faults(drafts: Sequence[_Draft], page: YamlPage) -> Iterator[Fault]:
    first: dict[str, int] = {}
    for draft in drafts:
        name = draft.values.name
        if name in first:
            detail, advice = f"two bands are named {name!r}", "Bands may share a group, but not a name."
            yield page.fault(detail, "duplicate_name", draft.at("name"), advice, name)
        first.setdefault(name, draft.index)


def _group_faults(drafts: Sequence[_Draft], content: dict[Any, Any], page: YamlPage) -> Iterator[Fault]:
    """Bands of a group share stiffness and law; those of a tied group their natural length too."""
    groups: dict[str, list[_Draft]] = {}
    for draft in drafts:
        groups.setdefault(draft.values.group or draft.values.name, []).append(draft)
    written = content.get("tied")
    tied = [name for name in (written if isinstance(written, list) else []) if isinstance(name, str)]
    for k, name in enumerate(tied):
        if name not in groups:
            own = {draft.values.name: draft.values.group for draft in drafts}.get(name)
            advice = f"The band of this name has group {own!r}." if own else suggestion(name, list(groups))
            yield page.fault("no band has this group", "unknown_group", ("tied", k), advice, name)
    for group, members in groups.items():
        shared = ["stiffness_n_per_m", "law"] + (["natural_length_m"] if group in tied else [])
        for key in shared:
            given = [(draft, getattr(draft.values, key)) for draft in members]
            known = [(draft, value) for draft, value in given if value is not None]
            for draft, value in known[1:]:
                if value != known[0][1]:
                    detail = f"band {known[0][0].values.name!r} of the same group {group!r} has {known[0][1]}"
                    advice = "Bands of one group share it: make them equal, or give this band a group of its own."
                    if key == "natural_length_m":
                        advice = f"`tied` says they have one natural length: make them equal, or untie {group!r}."
                    yield page.fault(detail, "group_differs", draft.at(key), advice, value)


def _law_faults(draft: _Draft, page: YamlPage) -> Iterator[Fault]:
    """An unknown law; values that it does not know, lacks, or cannot take."""
    for fault in law_faults(draft.values.law, draft.values.law_values):
        pointer = draft.at(*(fault.column or "law").split(".", 1))
        told = page.fault(shorten(fault.detail, 200), fault.rule, pointer, fault.advice, fault.value)
        missing = fault.rule == "missing_law_value"  # has no line of its own: that of the law
        yield replace(told, row=place(page.data, draft.at("law"))) if missing else told


def _place_faults(drafts: Sequence[_Draft], tree: RigidTree, page: YamlPage) -> Iterator[Fault]:
    """Links that the robot lacks, segments without length, bands that act on no joint."""
    postures = drawn_postures(tree, 2)
    for draft in drafts:
        for j, point in draft.points:
            if point.link not in tree.frames:
                yield _unknown_link(point.link, tree, page, draft.at("via_points", j, "link"))
        known = [(j, point) for j, point in draft.points if point.link in tree.frames]
        if len(known) < 2:
            continue
        on = [tree.frames[point.link][0] for _, point in known]
        band = Band(draft.values.name, "", tuple(ViaPoint(point.link, point.xyz) for _, point in known))
        longest = Routing(tree, [band]).segments(postures, 0).length.max(axis=0)
        for s in np.flatnonzero(longest < DEVICES.same_place_m):
            if known[s + 1][0] == known[s][0] + 1:
                detail = f"this via point is at the same place as the one before it, {_where(on[s], tree)}"
                advice = "Leave one of them out; it may be one point in the frames of two links."
                yield page.fault(detail, "no_segment", draft.at("via_points", known[s + 1][0]), advice)
        if len(set(on)) == 1 and len(known) == draft.written:
            detail = f"all its via points are on one rigid body, {_where(on[0], tree)}: it acts on no joint"
            advice = "A band must cross a joint. Check the links' names."
            if tree.locked:
                advice += f" Joints that robot.yaml does not list count as fixed: {_listed(tree.locked)}."
            yield page.fault(detail, "acts_on_no_joint", draft.at("via_points"), advice)


def _where(body: int, tree: RigidTree) -> str:
    return "the fixed base" if body < 0 else f"that of link {tree.bodies[body]!r}"


def _unknown_link(link: str, tree: RigidTree, page: YamlPage, pointer: Pointer) -> Fault:
    if link in tree.joints:
        moved = tree.bodies[int(np.flatnonzero(tree.dof == tree.joints.index(link))[0])]
        advice = f"It is a joint; the link that it moves is {moved!r}."
    elif near := get_close_matches(link, list(tree.frames), n=3, cutoff=0.6):
        advice = f"Did you mean {' or '.join(map(repr, near))}?"
    else:
        still = [name for name, (body, _) in tree.frames.items() if body < 0][:1]
        advice = f"Links here: {_listed([*still, *tree.bodies])}."
    return page.fault("the robot has no such link or frame", "unknown_link", pointer, advice, link)


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names[:SHOWN_LINKS]) + (", …" if len(names) > SHOWN_LINKS else "")


def _benches(drafts: Sequence[_Draft], bundle: Bundle, page: YamlPage) -> tuple[dict[int, BenchTest], list[Fault]]:
    """Tables by band index; one file may serve several bands and is read, and refused, once."""
    benches: dict[int, BenchTest] = {}
    refused, faults = set[str](), list[Fault]()
    for draft in drafts:
        bench = draft.values.bench
        if bench is None or bench.file in refused:
            continue
        pointer = draft.at("bench", "file")
        where = {"named_in": page.file, "column": dotted(pointer), "row": place(page.data, pointer)}
        try:
            benches[draft.index] = read_bench(bundle, bench.file, bench.is_truth, **where)  # type: ignore[arg-type]
        except BadStudy as bad:
            refused.add(bench.file)
            faults += bad.faults
    return benches, faults


Array = NDArray[np.float64]

DRAWN = 400
WIDEST_TURN, WIDEST_SLIDE = np.pi, 0.5  # [rad], [m] to either side where a joint has no limits


def drawn_postures(tree: RigidTree, count: int = DRAWN) -> Array:
    """(1 + count, J) [rad or m]: all joints at zero, then drawn evenly within their limits, always the same ones."""
    widest = np.array([WIDEST_SLIDE if joint in tree.sliding else WIDEST_TURN for joint in tree.joints])
    lower = np.where(np.isfinite(tree.lower), tree.lower, -widest)
    upper = np.where(np.isfinite(tree.upper), tree.upper, widest)
    drawn = np.random.default_rng(0).uniform(lower, upper, size=(count, len(tree.joints)))
    return np.vstack([np.zeros(len(tree.joints)), drawn])
