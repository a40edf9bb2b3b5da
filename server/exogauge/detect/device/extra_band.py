"""Where a band could run that nobody declared: straight from link to link, or at one joint where no more is known.

Where a link ends is not known here; what is known is its inertia, and the box that has it. A wire is tried from the
middle of every side of one link's box to every side of another's. What a fixed robot stands on has no inertia: the box
of the link that it carries, with all joints at zero, stands for it.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray
from scipy.optimize import minimize

from exogauge.criteria.supporting import Wearing
from exogauge.detect.device.baseline import Ground, whitened
from exogauge.detect.device.judge import BandJudgement
from exogauge.detect.device.score import BandScore, Scorer
from exogauge.devices.device import Band, ViaPoint
from exogauge.devices.routing import Routing
from exogauge.effects.band import BandEffect
from exogauge.robots.tree import RigidTree
from exogauge.support.band_model import fit
from exogauge.support.band_rows import Course
from exogauge.support.band_weights import spread, weights

Array = NDArray[np.float64]


def further_wires(
    ground: Ground, scorer: Scorer, effect: BandEffect, led_better: bool = False
) -> tuple[Ground, Scorer, list[BandScore], int]:
    """The ground with the likeliest further wires behind the declared bands, its scorer, their scores, the tries.

    led_better: their ends are moved to where they explain most. Only once it is clear that there is such a wire: one
    that may run anywhere would explain what any effect of a declared band does.
    """
    criteria, pulled = ground.model.criteria.device, list(_at_joints(ground))
    by_joint, tried = _best(scorer, effect, pulled, criteria)
    likely = sorted(by_joint, key=lambda each: -each[1].evidence)[: criteria.likely]
    if not likely or likely[0][1].evidence < criteria.wire_worth + 2.0 * np.log(max(len(pulled), 1)):
        return ground, scorer, [], tried
    wires = list(_between_links(ground, sorted({course.column for course, _ in likely})))
    few = _few(ground, scorer)
    coarse, count = _best(few, effect, wires, criteria)
    first_look = _one_per_pair(sorted(coarse, key=lambda each: -each[1].evidence))[: criteria.likely]
    if led_better:
        by_wire = _at(scorer, effect, [_led_better(few, effect, *each, criteria.furthest_m) for each in first_look])
    else:
        by_wire, _ = _best(scorer, effect, [course for course, _ in first_look], criteria)
    price = 2.0 * np.log(max(len(wires), 1))
    chosen = likely[:1] + [(course, replace(one, evidence=one.evidence - price)) for course, one in by_wire]
    first = len(ground.setting.wires)
    more = tuple(ground.setting.logs.wire(course) for course, _ in chosen)
    setting = replace(ground.setting, wires=(*ground.setting.wires, *more))
    scores = [
        replace(one, added=replace(one.added, wire=first + k))
        for k, (_, one) in enumerate(chosen)
        if one.evidence > criteria.wire_worth
    ]
    wider = replace(scorer.setting, wires=setting.wires)
    return (
        replace(ground, setting=setting),
        Scorer(wider, fit(wider, scorer.fitted.wear)),
        scores,
        tried + count,
    )


def led_on(ground: Ground, judged: BandJudgement) -> Iterator[tuple[Ground, Scorer, BandScore]]:
    """The ground with the wire of `judged` led on, joints weighed by what it leaves on them; its scorer and its score.
    Nothing of a wire that has no ends."""
    effect, course = judged.added.effect, ground.setting.wires[judged.added.wire].course
    if course.routing is None:
        return
    sharper = replace(ground, sigma=spread(ground.setting.logs, judged.fitted.e, ground.floor))
    few = _few(sharper, Scorer(*whitened(sharper)))
    first = few.score(effect, judged.added.wire, judged.added.shape)
    if first is None or first.gain <= 0.0:
        return
    led, shape = _led_better(few, effect, course, first, ground.model.criteria.device.furthest_m)
    setting = replace(ground.setting, wires=(*ground.setting.wires, ground.setting.logs.wire(led)))
    wider = replace(ground, setting=setting)
    scorer = Scorer(*whitened(wider))
    scored = scorer.score(effect, len(setting.wires) - 1, shape)
    if scored is not None:
        yield wider, scorer, scored


def _few(ground: Ground, scorer: Scorer) -> Scorer:
    """The same fit seen by one log of every motion."""
    logs = ground.setting.logs.few()
    wires = tuple(logs.wire(wire.course) for wire in ground.setting.wires)
    weight, independent = weights(logs, ground.sigma, np.ones_like(ground.memory))
    setting = replace(ground.setting, logs=logs, wires=wires, weight=weight, independent=independent)
    return Scorer(setting, fit(setting, scorer.fitted))


def _best(
    scorer: Scorer, effect: BandEffect, courses: Sequence[Course], criteria: Wearing
) -> tuple[list[tuple[Course, BandScore]], int]:
    """Every course with its best shape, and how many were tried."""
    setting, found, tried = scorer.setting, list[tuple[Course, BandScore]](), 0
    for course in courses:
        wire = setting.logs.wire(course)
        if wire.travel < (criteria.least_travel_m if course.routing is not None else criteria.joint_moves):
            continue
        best, count = scorer.beside(wire).best(effect, len(setting.wires))
        tried += count
        if best is not None and best.gain > 0.0:
            found.append((course, best))
    return found, tried


def _at_joints(ground: Ground) -> Iterator[Course]:
    logs = ground.setting.logs
    for name, column in zip(logs.names, logs.joints, strict=True):
        for sign in (1.0, -1.0):
            yield Course("joint", name, None, 0, int(column), sign)


def _between_links(ground: Ground, joints: Sequence[int]) -> Iterator[Course]:
    """Between all links with at most a few joints in between, one of the given ones among them."""
    tree, criteria = ground.model.robot.tree, ground.model.criteria.device
    least = criteria.lightest * tree.mass
    heavy = [body for body in range(len(tree.bodies)) if tree.phi[body, 0] > least]
    ends = {body: [ViaPoint(tree.bodies[body], side) for side in _sides(tree, body)] for body in heavy}
    ends = _on_the_base(tree, ends) | ends
    for one, other in itertools.combinations(ends, 2):
        crossed = _crossed(tree, one, other)
        if len(crossed) > criteria.most_crossed or not set(joints) & crossed:
            continue
        name = f"{ends[one][0].link} - {ends[other][0].link}"
        for points in itertools.product(ends[one], ends[other]):
            yield Course("band", name, Routing(tree, [Band(name, name, points)]), 0)


def _on_the_base(tree: RigidTree, ends: Mapping[int, Sequence[ViaPoint]]) -> dict[int, list[ViaPoint]]:
    """Of what a fixed robot stands on; none where nothing heavy hangs on it."""
    base = next(((name, pose) for name, (body, pose) in tree.frames.items() if body < 0), None)
    carried = next((body for body in ends if tree.parent[body] < 0 and not tree.floating), None)
    if base is None or carried is None:
        return {}
    to_base = base[1].inverse() * tree.T_before[carried] * tree.T_after[carried]
    places = [to_base.act(np.array(point.xyz)) for point in ends[carried]]
    return {-1: [ViaPoint(base[0], (float(x), float(y), float(z))) for x, y, z in places]}


def _led_better(
    scorer: Scorer, effect: BandEffect, course: Course, first: BandScore, furthest_m: float
) -> tuple[Course, tuple[float, ...]]:
    """The course with its ends moved to where it explains most, each coordinate at most `furthest_m` from where it was,
    and its shape there."""
    assert course.routing is not None
    (band,), tree = course.routing.bands, course.routing.tree
    points = band.via_points
    begin, places = np.array([point.xyz for point in points]), 3 * len(points)

    def led(moved: Array) -> Course:
        xyz = begin + furthest_m * moved.reshape(begin.shape)
        there = tuple(replace(point, xyz=(float(at[0]), float(at[1]), float(at[2])))
                      for point, at in zip(points, xyz, strict=True))  # fmt: skip
        return replace(course, routing=Routing(tree, [replace(band, via_points=there)]))

    def shape(shares: Array) -> tuple[float, ...]:
        return tuple(one.at(float(share)) for one, share in zip(effect.shapes, shares, strict=True))

    def cost(x: Array) -> float:
        """x: of the ends, and shares of the shapes."""
        found = _at(scorer, effect, [(led(x[:places]), shape(x[places:]))])
        return -found[0][1].gain / first.gain if found else 0.0

    shares = [one.share(value) for one, value in zip(effect.shapes, first.added.shape, strict=True)]
    best = minimize(
        cost, np.concatenate([np.zeros(places), shares]), method="L-BFGS-B",
        bounds=[(-1.0, 1.0)] * places + [(0.0, 1.0)] * len(shares),
        options={"eps": 5e-4, "maxiter": 120, "ftol": 1e-7},
    )  # fmt: skip
    return led(best.x[:places]), shape(best.x[places:])


def _at(
    scorer: Scorer, effect: BandEffect, shaped: Sequence[tuple[Course, tuple[float, ...]]]
) -> list[tuple[Course, BandScore]]:
    """Every course with the shape that is given, where it explains anything."""
    last, found = len(scorer.setting.wires), list[tuple[Course, BandScore]]()
    for course, shape in shaped:
        scored = scorer.beside(scorer.setting.logs.wire(course)).score(effect, last, shape)
        if scored is not None and scored.gain > 0.0:
            found.append((course, scored))
    return found


def _sides(tree: RigidTree, body: int) -> list[tuple[float, float, float]]:
    """The middles of the six sides of the box with the body's inertia, in its frame [m]."""
    inertia = pin.Inertia.FromDynamicParameters(tree.phi[body])
    moments, axes = np.linalg.eigh(inertia.inertia)
    squares = 6.0 / inertia.mass * (moments.sum() - 2.0 * moments)
    half = 0.5 * np.sqrt(np.maximum(squares, 0.0))
    middles = [inertia.lever + sign * half[k] * axes[:, k] for k in range(3) for sign in (1.0, -1.0)]
    return [(float(x), float(y), float(z)) for x, y, z in middles]


def _crossed(tree: RigidTree, one: int, other: int) -> set[int]:
    """Columns of q between two bodies."""
    up, down = _above(tree, one), _above(tree, other)
    return {int(tree.dof[body]) for body in up ^ down if tree.dof[body] >= 0}


def _above(tree: RigidTree, body: int) -> set[int]:
    """The body and all that carry it."""
    found = set[int]()
    while body >= 0:
        found.add(body)
        body = int(tree.parent[body])
    return found


def _one_per_pair(ordered: Sequence[tuple[Course, BandScore]]) -> list[tuple[Course, BandScore]]:
    best: dict[str, tuple[Course, BandScore]] = {}
    for each in ordered:
        best.setdefault(each[0].name, each)
    return list(best.values())
