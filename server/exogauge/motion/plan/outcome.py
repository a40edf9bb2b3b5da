"""A plan in a few lines, and as a file that a robot plays."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy
from numpy.typing import NDArray

from exogauge.criteria.motion_plan import USUAL
from exogauge.logs.findings import runs
from exogauge.motion.human import DOUBTS
from exogauge.motion.person import Person
from exogauge.motion.plan.asked import Asked
from exogauge.motion.plan.judge import Judged
from exogauge.motion.plan.solve import Planned
from exogauge.motion.plan.written import STANDS
from exogauge.robots.moving.robot import MotionRobot
from exogauge.robots.moving.touching import Pairs, hulls_alone
from exogauge.studies.csv_table import csv_table

PLACES = 8  # decimals: a ten-thousandth of what an encoder tells
UNBOUNDED = 1e-6  # share of a bound: makers write 1e9 where they know none
Told = dict[str, str | float | list[str]]


def summarise(
    robot: MotionRobot, person: Person, asked: Asked, missed: NDArray[np.float64], planned: Planned, judged: Judged,
    smooth_hz: float = USUAL.smooth_hz,
) -> Told:  # fmt: skip
    """Trunk asked and given, margins, what breaks; missed: (N,) [rad] of `ask`. smooth_hz: below which the plan
    follows; what a recording holds above it is its own jitter, and is told apart from what the plan is off."""
    torso = robot.base + np.array(robot.torso)
    given = planned.spline.at_nodes()[0]
    wanted = slow(asked.q[:, torso], asked.step, smooth_hz)
    off, fast = np.degrees(given[:, torso] - wanted), np.degrees(asked.q[:, torso] - wanted)
    said: Told = {
        "robot": robot.name, "motion": person.name, "seconds": round(float(judged.time[-1]), 3),
        "rounds": planned.rounds,
    }  # fmt: skip
    said |= {key: person.told[key] for key in DOUBTS if key in person.told}
    for k, j in enumerate(robot.torso):
        low, high = np.degrees(asked.q[:, torso[k]].min()), np.degrees(asked.q[:, torso[k]].max())
        bound = np.degrees(robot.limits.lower[j]), np.degrees(robot.limits.upper[j])
        outside = (asked.q[:, torso[k]] < robot.limits.lower[j]) | (asked.q[:, torso[k]] > robot.limits.upper[j])
        within = off[~outside, k]
        wanted_of_it = (f"asked {low:.1f} to {high:.1f}°, the joint bears {bound[0]:.1f} to {bound[1]:.1f}° "
                        f"({100 * outside.mean():.2g} % of nodes lie beyond)")  # fmt: skip
        said[f"trunk {robot.joints[j]}"] = (
            wanted_of_it
            if not planned.rounds
            else (
                f"{wanted_of_it}; given to {np.sqrt(np.mean(within**2)):.2g}° rms, "
                f"{np.abs(within).max():.2g}° at most where it bears them"
                f"{_binds(robot, planned, judged, np.where(outside, 0.0, off[:, k]))}; "
                f"{np.sqrt(np.mean(fast[:, k] ** 2)):.2g}° rms lie above {smooth_hz:g} Hz and are left out"
            )
        )
    said["trunk not expressed"] = (
        f"{np.degrees(np.sqrt(np.mean(missed**2))):.3g}° rms, {np.degrees(missed.max()):.3g}° at most, "
        "in directions in which the torso has no joint"
    )
    if person.contacts is not None:
        lifts = 100.0 * float((person.contacts.left ^ person.contacts.right).mean())
        ups = 0.0 if planned.stands is None else 100.0 * float((~planned.stands).any(axis=1).mean())
        lifted = f"the person lifts one in {lifts:.2g} % of frames, the robot in {ups:.2g} % of nodes"
        said["feet that stand"] = f"{lifted}, and puts it down where it was" if lifts else "both throughout"
    return said | margins(robot, judged)


def _binds(robot: MotionRobot, planned: Planned, judged: Judged, off: NDArray[np.float64]) -> str:
    """What is at its bound where a joint of the trunk is farthest from what is asked, off: (N,) [°]."""
    worst = int(np.abs(off).argmax())
    if abs(off[worst]) < USUAL.told_deg:
        return ""
    when = worst * planned.spline.step
    q, v, a = (each[0] for each in planned.spline.at(np.array([when])))
    now, own = int(np.abs(judged.time - when).argmin()), robot.base + np.array(robot.torso)
    limits, torso = robot.limits, np.array(robot.torso)
    shares = [("torque", judged.torque[now] / limits.torque, range(len(robot.joints))),
              ("velocity", v[own] / limits.velocity[torso], robot.torso),
              ("acceleration", a[own] / limits.acceleration[torso], robot.torso)]  # fmt: skip
    full = [f"{what} of {robot.joints[j]} is at {100 * abs(x):.0f} %" for what, share, joints in shares
            for j, x in zip(joints, share, strict=True) if abs(x) > USUAL.kept - 2.0 * USUAL.more_kept]  # fmt: skip
    pairs = Pairs(robot, USUAL.clearance_m)
    near = pairs.near(q[None], USUAL.apart_m + USUAL.clearance_m / 10.0)
    full += [f"{' and '.join(pairs.names[p])} are {1e3 * d:.1f} mm apart" for p, d in
             zip(near.pair.tolist(), near.distance, strict=True)
             if pairs.levers[p, own].any()]  # fmt: skip
    if judged.inside[now] < USUAL.margin_m + USUAL.clearance_m / 10.0:
        full.append(f"the centre of pressure is {1e3 * judged.inside[now]:.0f} mm inside")
    return f", most at {when:.2f} s" + (f", where {', '.join(full)}" if full else "")


def slow(angles: NDArray[np.float64], step: float, smooth_hz: float) -> NDArray[np.float64]:
    """(N, K) without what is faster: 1 / (1 + (f / smooth_hz)⁴) of it is left, as the plan's own cost leaves of what is
    asked."""
    low_pass = scipy.signal.butter(2, 2.0 * step * smooth_hz, output="sos")
    return np.asarray(scipy.signal.sosfiltfilt(low_pass, angles, axis=0))


def margins(robot: MotionRobot, judged: Judged) -> Told:
    """What is left of every bound, and what is broken."""
    said = _on_feet(robot, judged) if robot.floating else Told()
    shares = {
        "velocity": np.abs(judged.dq[:, robot.base :]) / robot.limits.velocity,
        "torque": np.abs(judged.torque) / robot.limits.torque,
    }
    for what, share in shares.items():
        j = int(share.max(axis=0).argmax())
        known = share.max() > UNBOUNDED
        said[what] = (
            "no bound is known" if not known else f"{100 * share.max():.0f} % of its bound at most ({robot.joints[j]})"
        )
    if judged.nearest is not None:
        *pair, when = judged.nearest
        said["nearest"] = f"{1e3 * judged.apart.min():.1f} mm, {' and '.join(pair)} at {when:.3f} s"
    elif robot.shapes:
        said["nearest"] = f"no two links come nearer than {1e3 * judged.apart.min():.0f} mm"
    said |= may_touch(robot, judged.left_out) | unseen(robot)
    said["broken"] = list(judged.broken)
    return said


def _on_feet(robot: MotionRobot, judged: Judged) -> Told:
    said = Told()
    inside, lifted_off = judged.least_inside, 100.0 * float(np.isnan(judged.inside).mean())
    known = "" if inside is None else f"{1e3 * inside:.1f} mm inside the soles at least"
    nowhere = f"nowhere in {lifted_off:.2g} % of samples: the feet carry too little for one" if lifted_off else ""
    said["centre of pressure"] = ", ".join(filter(None, (known, nowhere)))
    said["weight on the feet"] = f"{judged.carried.min():.2f} of the weight at least"
    lifted = ups(robot, judged)
    if lifted:
        said["feet that lift"] = "; ".join(
            f"{link} from " + ", ".join(f"{a:.3f} to {b:.3f} s" for a, b in spans) for link, spans in lifted.items()
        )
    way = f"move by {1e3 * judged.feet_m:.3f} mm and {np.degrees(judged.feet_rad):.4f}° at most"
    said["feet"] = f"{way} while they stand" if lifted else way
    return said


def may_touch(robot: MotionRobot, left_out: Sequence[tuple[str, str]], why: str = "") -> dict[str, str]:
    """Pairs that are not looked at, those apart that only the convex hulls of hollow meshes bring together; in part:
    others of the shapes of the two links are. why: after the first."""
    asked = [pair for pair in left_out if pair not in robot.ignored and pair[::-1] not in robot.ignored]
    hulls = hulls_alone(robot, asked, USUAL.clearance_m) if robot.home is not None else {}
    links = [shape.link for shape in robot.shapes]
    several = any(links.count(link) > 1 for pair in left_out for link in pair)
    asked_too = {frozenset(pair) for pair in Pairs(robot, USUAL.clearance_m).names} if several else set()
    touch = [" and ".join(pair) + (" in part" if frozenset(pair) in asked_too else "") for pair in left_out
             if pair not in hulls]  # fmt: skip
    apart = [f"{' and '.join(pair)} ({1e3 * gap:.0f} mm)" for pair, gap in hulls.items()]
    said = {"may touch": ", ".join(touch) + why} if touch else {}
    if apart:
        near = f"nearer than {1e3 * USUAL.clearance_m:g} mm at home"
        said["touch as hulls"] = (
            f"{', '.join(apart)}: {near} as convex hulls, with the surfaces of their meshes so far apart; never looked "
            "at, unless `collision.shapes` has boxes or capsules"
        )
    return said


def unseen(robot: MotionRobot) -> dict[str, str]:
    """What of it can touch unseen, if anything."""
    lacks = "their meshes are not there, or neither STL, OBJ nor PLY"
    if robot.shapeless:
        return {"not looked at": f"collisions of {', '.join(robot.shapeless)}: {lacks}; `collision.shapes` stands in"}
    return {} if robot.shapes else {"not looked at": "collisions: no link has a shape"}


def frame_by_frame_words(alone: Judged) -> str:
    """What would have become of the same motion, had each frame been taken by itself."""
    least = alone.least_inside
    pressure = "no centre of pressure" if least is None else f"centre of pressure {1e3 * least:.1f} mm inside at least"
    if least is not None and least < 0.0:
        pressure = (f"centre of pressure outside the soles in {100.0 * alone.outside:.2g} % of samples, by up to "
                    f"{-1e3 * least:.1f} mm")  # fmt: skip
    feet = f"feet move by {1e3 * alone.feet_m:.3f} mm and {np.degrees(alone.feet_rad):.4f}°"
    return f"{pressure}; {feet}; {len(alone.broken) or 'no'} bounds broken"


def motion_table(robot: MotionRobot, judged: Judged) -> bytes:
    """t [s], then `q.<joint>` [rad, or m of a prismatic joint]; where a foot lifts, `stands.<link>` of every foot, 1 or
    0."""
    table = np.column_stack([judged.time, judged.q[:, robot.base :]])
    rows: Sequence[Sequence[float]] = np.round(table, PLACES).tolist()
    names = ["t", *(f"q.{name}" for name in robot.joints)]
    if not judged.stands.all():
        names += [f"{STANDS}{sole.link}" for sole in robot.soles]
        stands: Sequence[Sequence[int]] = judged.stands.astype(int).tolist()
        rows = [[*row, *each] for row, each in zip(rows, stands, strict=True)]
    return csv_table(names, rows)


def ups(robot: MotionRobot, judged: Judged) -> dict[str, list[tuple[float, float]]]:
    """[s] from the first to the last sample at which a foot does not stand, of every foot that lifts."""
    found = {}
    for sole, stands in zip(robot.soles, judged.stands.T, strict=True):
        starts, lengths = runs(~stands)
        if len(starts):
            found[sole.link] = [(round(float(judged.time[a]), 6), round(float(judged.time[a + n - 1]), 6))
                                for a, n in zip(starts, lengths, strict=True)]  # fmt: skip
    return found
