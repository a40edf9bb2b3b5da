"""Any file of captured motion becomes a `HumanMotion`: metres, z up, seconds from 0. What was guessed is told."""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.motion_import import USUAL
from exogauge.motion.files.captured import AXES, METRES, STILL, Captured, even_time, fault
from exogauge.motion.human import HumanMotion, JointTree, Markers
from exogauge.motion.leaps import leap_of_bones, rate_doubt, sort_out
from exogauge.motion.presets import carried_by, recognise, subjects
from exogauge.motion.sides import sides_doubt
from exogauge.robots.moving.segments import Segment
from exogauge.stand_ins import stands_in

Array = NDArray[np.float64]
FORMATS = "C3D, TRC, TSV of Qualisys, CSV of Motive, of Nexus or plain, MVNX, MOT, STO, BVH or AMC"
TABLES = (".csv", ".tsv", ".txt")
CAPTURES = (".c3d", ".trc", *TABLES, ".mvnx", ".mot", ".sto", ".bvh", ".amc")
ELSEWHERE = {
    ".mvn": "Xsens MVN exports MVNX and BVH of the same take",
    ".v .xlsx .xls .ods": "Vicon, OptiTrack and Qualisys export C3D of the same take",
    ".fbx .glb .gltf .dae .usd .usda": "Blender, MotionBuilder and Maya export its skeleton as BVH",
    ".npz .npy .pkl .mat .json": "Write its joints as BVH, or its markers as TRC",
    ".tak .qtm .trb .vsk .x1d .x2d .cap .anb .trak": "Its program exports C3D",
    ".asf": "An ASF holds bones without motion: give the AMC, and this by --skeleton",
    ".gz .zip .bz2 .xz .7z": "Unpack it first",
}
UNITS = {name: METRES[name] for name in ("m", "cm", "mm", "in", "cmu")}


def open_motion(
    path: Path, *, skeleton: Path | None = None, up: str | None = None, unit: str | None = None,
    angle: str | None = None, subject: str | None = None, names: Mapping[str, str] | None = None,
) -> HumanMotion:  # fmt: skip
    """C3D, TRC, tables of Qualisys, Motive and Nexus, plain ones, MVNX, MOT/STO, BVH, or AMC with its ASF as
    `skeleton`. Raises BadMotion.

    up: x, y, z or -x, -y, -z, unit: m, cm, mm, in or cmu, angle: deg or rad, where the file is silent or wrong.
    subject: the prefix of one of several people. names: own label or bone -> the name it is known by. `told`: format,
    unit, up, prefix, preset, unknown, left_out, far_away, duplicates, unit_doubt, renamed, as far as there is one.
    """
    for each in (path, *([] if skeleton is None else [skeleton])):
        if each.is_dir():
            raise fault(each, "is a folder", "a_folder", _files_in(each, CAPTURES if each is path else (".asf",)))
        if not each.is_file():
            raise fault(each, "there is no such file", "no_file", "Look at its name")
    if path.stat().st_size > USUAL.most_bytes:
        raise fault(path, "the file is too large", "too_large", "Cut the motion", value=f"{path.stat().st_size} bytes")
    for each in (path, *([skeleton] if skeleton is not None else [])):
        if other := stands_in(_head(each)):
            raise fault(each, f"is {other[0]}", "stands_in", other[1])
    head = _head(path)
    try:
        captured = _read(path, head, skeleton, angle)
    except (ValueError, IndexError, KeyError, OverflowError, csv.Error) as problem:  # what no rule of a reader foresaw
        detail = f"the file is damaged: {problem}"
        raise fault(path, detail, "damaged", "Export it again, from the program that captured it") from problem
    if isinstance(captured, HumanMotion):
        return captured
    return _canonical(path, _renamed(path, _one_person(path, captured, subject), names or {}), up, unit)


def _files_in(folder: Path, kinds: tuple[str, ...]) -> str:
    """Advice: which of its files may be meant."""
    found = sorted(each.name for each in folder.iterdir() if each.suffix.lower() in kinds)
    if not found:
        return f"Name a file; it holds no {', '.join(kinds)}"
    return f"Name a file in it: {', '.join(found[:5])}{' …' if len(found) > 5 else ''}"


def _head(path: Path) -> bytes:
    with path.open("rb") as stream:
        return stream.read(512)


def _read(path: Path, head: bytes, skeleton: Path | None, angle: str | None) -> Captured | HumanMotion:
    kind = path.suffix.lower()
    if angle not in (None, "deg", "rad"):
        raise fault(path, "no such unit of angles", "bad_angle", "deg or rad", column="angle", value=angle)
    if kind == ".c3d":
        from exogauge.motion.files.c3d import read_c3d

        return read_c3d(path)
    if kind == ".trc" or head.startswith(b"PathFileType"):
        from exogauge.motion.files.trc import read_trc

        return read_trc(path)
    if kind in (".mot", ".sto"):
        from exogauge.motion.files.storage import read_storage

        return read_storage(path, angle)
    if kind == ".bvh" or head.lstrip().startswith(b"HIERARCHY"):
        from exogauge.motion.files.bvh import read_bvh

        return read_bvh(path, angle)
    if kind in TABLES:
        from exogauge.motion.files.marker_tables import read_table

        return read_table(path)
    if kind == ".mvnx":
        from exogauge.motion.files.mvnx import read_mvnx

        return read_mvnx(path)
    if kind == ".amc":
        from exogauge.motion.files.acclaim import read_amc

        return read_amc(path, skeleton, angle)
    beside = next((f". {advice}" for kinds, advice in ELSEWHERE.items() if kind in kinds.split()), "")
    raise fault(path, "no such format of motion is known", "unknown_format", f"{FORMATS}{beside}",
                value=path.suffix or None)  # fmt: skip


def _one_person(path: Path, captured: Captured, subject: str | None) -> Captured:
    """Prefixes of subjects off; what is named twice and cannot be told apart is numbered, and told."""
    told, body, position = dict(captured.told), captured.skeleton, captured.position
    labels = captured.labels if body is None else body.names
    colons = {label.rsplit(":", 1)[0] + ":" for label in labels if ":" in label}
    people = subjects(labels) or dict.fromkeys(colons if body is None or len(colons) == 1 else (), 0)
    chosen = [of for of in {*people, *colons} if subject is not None and subject in (of, of[:-1])]
    if len(people) > 1 and not chosen:
        raise fault(path, f"{len(people)} people are in the file", "two_people",
                    f"Say which one: {', '.join(sorted(of[:-1] for of in people))}", column="subject",
                    value=subject)  # fmt: skip
    if subject is not None and not chosen:
        named = ", ".join(sorted(of[:-1] for of in {*people, *colons} if of))
        raise fault(path, "nobody of that name is in the file", "no_subject",
                    f"There is {named}" if named else "Its labels have no prefixes: leave it out", column="subject",
                    value=subject)  # fmt: skip
    of = next(iter(chosen or people), "")
    if of:
        told["prefix"] = of[:-1]
    if position is None:
        assert body is not None
        names = tuple(name.removeprefix(of) for name in body.names)
        return replace(captured, skeleton=replace(body, names=names), told=told)
    others = tuple((set(people) | colons) - {of, ""})
    kept = [k for k, label in enumerate(labels) if label.startswith(of or ":") or not label.startswith(others)]
    if len(kept) < len(labels):
        beside = [label for k, label in enumerate(labels) if k not in kept]
        told["left_out"] = ", ".join(filter(None, (told.get("left_out"), *beside)))
    labels, position = tuple(labels[k].removeprefix(of) for k in kept), position[:, kept]
    seen: Counter[str] = Counter()
    twice = sorted(label for label, times in Counter(labels).items() if times > 1)
    if twice:
        told["duplicates"] = ", ".join(twice)
    single = []
    for label in labels:
        seen[label] += 1
        single.append(label if seen[label] == 1 and label not in twice else f"{label} #{seen[label]}")
    return replace(captured, labels=tuple(single), position=position, told=told)


def _renamed(path: Path, captured: Captured, names: Mapping[str, str]) -> Captured:
    """What is not in the file is told; two of one name are refused."""
    body = captured.skeleton
    labels = captured.labels if body is None else body.names
    if not names:
        return captured
    told, now = dict(captured.told), tuple(names.get(label, label) for label in labels)
    twice = sorted(label for label, times in Counter(now).items() if times > 1)
    if twice:
        raise fault(path, "two would have the same name", "same_name", "Map each to a name of its own", column="names",
                    value=twice[0])  # fmt: skip
    known = set(labels)
    if lost := [name for name in names if name not in known]:
        told["not in the file"] = ", ".join(lost)
    told["renamed"] = ", ".join(f"{own} = {names[own]}" for own in labels if own in names)
    if body is None:
        return replace(captured, labels=now, told=told)
    return replace(captured, skeleton=replace(body, names=now), told=told)


def _canonical(path: Path, captured: Captured, up: str | None, unit: str | None) -> HumanMotion:
    time = even_time(path, captured.time, captured.row)
    rate = (len(time) - 1) / time[-1]
    body = captured.skeleton
    names = captured.labels if body is None else body.names
    preset, segment = recognise(names)
    if body is not None:
        segment = carried_by(names, body.parent.tolist(), segment)
    points = captured.position if body is None else body.position
    assert points is not None
    if points[..., 0].size > USUAL.most_points:
        raise fault(path, "more points than are taken", "too_large", "Cut the motion", value=str(points[..., 0].size))
    if not np.isfinite(points).any():
        raise fault(path, "no marker was seen in any frame", "all_gaps", "Export the trial with its trajectories")
    told = {"format": captured.format, **captured.told, "preset": preset or "none knows these names"}
    if np.array_equal(points, np.broadcast_to(points[0], points.shape), equal_nan=True):
        told["still"] = STILL
    twice = sorted(name for name, times in Counter(names).items() if times > 1 and name in segment)
    if twice:
        raise fault(path, "two bones have the same name", "same_name", "Give each a name of its own", column="names",
                    value=twice[0])  # fmt: skip
    unknown = [name for name in names if name not in segment]
    if unknown:
        told["unknown"] = ", ".join(unknown)
    tall = _feet_to_head(points, names, segment)
    axis, told["up"] = _up(path, captured, up, tall, unknown)
    height = float(np.percentile(np.linalg.norm(tall, axis=1), 90)) if tall is not None else np.nan
    metres, told["unit"] = _metres(path, captured, unit, height)
    if tall is not None and not USUAL.shortest_m <= height * metres <= USUAL.tallest_m:
        told["unit_doubt"] = f"feet to head would be {height * metres:.3g} m"
        if not USUAL.shortest_m / USUAL.no_body <= height * metres <= USUAL.no_giant_m:
            raise fault(path, told["unit_doubt"], "no_body", "Say the unit: m, cm, mm, in or cmu", column="unit",
                        value=told["unit"])  # fmt: skip
    turn = _upright(axis)
    if tall is None and body is None:
        over = metres * np.nanmedian(_reach(points))
        if not USUAL.shortest_m / USUAL.no_body <= over <= USUAL.widest_m:
            told["unit_doubt"] = f"no names of feet and head are known, and the markers lie {over:.3g} m apart"
    if body is None:
        place = points @ turn.T * metres
        away = np.abs(place).max(axis=2) > USUAL.farthest_m
        if away.any():
            place[away] = np.nan
            told["far_away"] = ", ".join(label for label, ever in zip(names, away.any(axis=0), strict=True) if ever)
        told |= sort_out(names, place, rate, segment)
        markers = Markers(captured.labels, place, np.zeros(place.shape[:2], dtype=bool), segment)
        return _doubted(HumanMotion(path.stem, time, markers=markers, told=told), place)
    places = {name: getattr(body, name) @ turn.T * metres for name in ("position", "end", "rest_position", "rest_end")}
    turns = {name: turn @ getattr(body, name) for name in ("rotation", "rest_rotation")}
    tree = replace(body, **places, **turns, segment=segment)
    if (leap := leap_of_bones(names, tree.position, rate)) is not None:
        told["leaps"] = leap
    return _doubted(HumanMotion(path.stem, time, tree=tree, told=told), tree.position)


def _doubted(motion: HumanMotion, points: Array) -> HumanMotion:
    """With what is doubted of its sides and of its rate; points: (T, N, 3), in the order of its names."""
    whole = motion.tree or motion.markers
    assert whole is not None
    names = whole.names if isinstance(whole, JointTree) else whole.labels
    trunk = [k for k, name in enumerate(names) if whole.segment.get(name) in ("pelvis", "thorax", "head")]
    doubts = {"sides_doubt": sides_doubt(motion)}
    if not {"leaps", "joined"} & set(motion.told):
        feet = [k for k, name in enumerate(names) if whole.segment.get(name) in ("l_foot", "r_foot")]
        doubts["rate_doubt"] = rate_doubt(points[:, trunk], points[:, feet], motion.rate)
    return replace(motion, told={**motion.told, **{key: words for key, words in doubts.items() if words is not None}})


def _reach(points: Array) -> Array:
    """(T',) widest side of the box around what is seen in a frame, of frames that show two."""
    shown = points[np.isfinite(points[..., 0]).sum(axis=1) > 1]
    return np.asarray((np.nanmax(shown, axis=1) - np.nanmin(shown, axis=1)).max(axis=1))


def _feet_to_head(points: Array, names: tuple[str, ...], segment: dict[str, Segment]) -> Array | None:
    """(T', 3) from the feet to the head, or to the thorax where no head is known, in some frames that show both."""
    of = {part: [k for k, name in enumerate(names) if segment.get(name, "").endswith(part)]
          for part in ("foot", "shank", "thorax", "head")}  # fmt: skip
    below, above = of["foot"] or of["shank"], of["head"] or of["thorax"]
    if not below or not above:
        return None
    seen = np.isfinite(points[..., 0])
    both = np.flatnonzero(seen[:, below].any(axis=1) & seen[:, above].any(axis=1))
    some = both[:: max(1, len(both) // USUAL.looked_at)]  # medians: one marker in another unit is not the body
    way = np.nanmedian(points[some][:, above], axis=1) - np.nanmedian(points[some][:, below], axis=1)
    return way if len(way) else None


def _up(
    path: Path, captured: Captured, stated: str | None, tall: Array | None, unknown: list[str]
) -> tuple[Array, str]:
    if stated is not None and stated.lower() not in AXES:
        raise fault(path, "no such axis", "bad_up", "x, y, z or -x, -y, -z", column="up", value=stated)
    mean = np.zeros(3) if tall is None else np.median(tall, axis=0)
    k = int(np.abs(mean).argmax())
    along = np.sign(mean[k]) * np.eye(3)[k] if abs(mean[k]) > USUAL.upright * np.linalg.norm(mean) else None
    if stated is not None:
        axis = AXES[stated.lower()]
        if along is not None and along @ axis < USUAL.level:
            return axis, f"stated: {stated.lower()}, though feet to head lie along {_name(along)}"
        return axis, f"stated: {stated.lower()}"
    if captured.up is not None:
        if along is not None and not along @ captured.up > 0.0:
            seen, read = _name(along), _name(captured.up)
            raise fault(path, f"the file says that {read} points up, and feet to head lie along {seen}", "other_up",
                        f"Say which way is up: {seen}, or {read} of somebody who lies", column="up",
                        value=read)  # fmt: skip
        return captured.up, f"read: {_name(captured.up)}"
    if tall is None and (twice := captured.told.get("duplicates")) is not None:
        raise fault(path, "labels are there more than once: two people, or a joined file", "two_people",
                    "Put a name before the labels of each, as Ann:LASI, or export each alone", column="subject",
                    value=twice[:80])  # fmt: skip
    if tall is None:
        detail = "which way is up is neither said nor seen: no names of feet and head or chest are known"
        advice = "Say what yours are called elsewhere (`names`, --name OWN=KNOWN), or up = x, y or z"
        raise fault(path, detail, "no_up_axis", advice, column="up", value=", ".join(unknown[:8]) or None)
    if along is None:
        raise fault(path, "feet and head lie along no single axis", "no_up_axis", "Say which way is up: x, y or z",
                    column="up", value=", ".join(f"{each:.3g}" for each in mean))  # fmt: skip
    return along, f"guessed: {_name(along)}, from the feet to the head"


def _metres(path: Path, captured: Captured, stated: str | None, height: float) -> tuple[float, str]:
    if stated is not None:
        if stated not in UNITS:
            raise fault(path, "no such unit", "bad_unit", "m, cm, mm, in or cmu", column="unit", value=stated)
        return UNITS[stated], f"stated: {stated}"
    if captured.unit is not None:
        return captured.unit, f"read: {captured.unit:g} m"
    fit = [name for name, metres in UNITS.items() if USUAL.shortest_m <= height * metres <= USUAL.tallest_m]
    if len(fit) != 1:
        detail = "the unit of length is neither said nor seen" + ("" if np.isfinite(height) else
                 ": no names of feet and head are known")  # fmt: skip
        raise fault(path, detail, "no_unit", "Say it: m, cm, mm, in or cmu", column="unit",
                    value=f"feet to head {height:.4g}" if np.isfinite(height) else None)  # fmt: skip
    return UNITS[fit[0]], f"guessed: {fit[0]}, as feet to head are {height * UNITS[fit[0]]:.2f} m then"


def _name(axis: Array) -> str:
    k = int(np.abs(axis).argmax())
    return ("-" if axis[k] < 0 else "") + "xyz"[k]


def _upright(up: Array) -> Array:
    """(3, 3) rotation whose last row is `up`."""
    first = np.roll(np.abs(up), 1)
    return np.stack([first, np.cross(up, first), up])
