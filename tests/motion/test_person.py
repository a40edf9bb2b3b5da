"""A person's motion cut, slowed, mirrored, repeated; and what is nearest to what cannot be had."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from scipy.spatial.transform import Rotation
from tests.motion.captures import BONES, ENDS, bow, bvh, written_order

from exogauge.errors import BadMotion
from exogauge.motion.files import open_motion
from exogauge.motion.fit.fit import fit_human
from exogauge.motion.human import Contacts
from exogauge.motion.person import Person, person_of
from exogauge.motion.plan.possible import nearest

T = 40
LEFT = np.arange(T) < 30


@pytest.fixture
def person() -> Person:
    """Bends ahead, leans and turns to the left, walks ahead and to the left, lifts the left arm sideways."""
    s = np.linspace(0.0, 1.0, T)
    trunk = np.stack([pin.rpy.rotate("z", 0.4 * a) @ pin.rpy.rotate("y", 0.6 * a) @ pin.rpy.rotate("x", -0.2 * a)
                      for a in s])  # fmt: skip
    turn = np.stack([pin.rpy.rotate("z", 0.3 * a) for a in s])
    place = np.stack([s, 0.5 * s, 0.9 - 0.1 * s], axis=1)
    arm = np.stack([0 * s, np.sin(s), -np.cos(s)], axis=1)
    other = np.tile([0.0, 0.0, -1.0], (T, 1))
    return Person("p", 0.1 * np.arange(T), place, turn, trunk, {"l_upper_arm": arm, "r_upper_arm": other}, 0.8,
                  Contacts(LEFT, np.ones(T, bool)))  # fmt: skip


def test_a_mirrored_person_does_with_the_right_what_it_did_with_the_left(person: Person) -> None:
    other = person.mirrored()
    assert other.pelvis[-1] == pytest.approx([1.0, -0.5, 0.8])
    assert pin.rpy.matrixToRpy(other.turn[-1])[2] == pytest.approx(-0.3)
    back = other.trunk[-1] @ [1.0, 0.0, 0.0]
    assert back == pytest.approx((person.trunk[-1] @ [1.0, 0.0, 0.0]) * [1.0, -1.0, 1.0])
    assert np.linalg.det(other.trunk) == pytest.approx(np.ones(T))
    assert other.limbs["r_upper_arm"][-1] == pytest.approx([0.0, -np.sin(1.0), -np.cos(1.0)])
    assert other.contacts is not None
    assert (other.contacts.right == LEFT).all()
    again = other.mirrored()
    assert again.trunk == pytest.approx(person.trunk)
    assert again.limbs["l_upper_arm"] == pytest.approx(person.limbs["l_upper_arm"])


def test_a_share_of_the_trunks_angle_is_that_share(person: Person) -> None:
    half = person.trunk_share(0.5)
    assert half.trunk @ half.trunk == pytest.approx(person.trunk)
    assert person.trunk_share(0.0).trunk == pytest.approx(np.tile(np.eye(3), (T, 1, 1)))
    assert half.turn == pytest.approx(person.turn)


def test_a_repeated_motion_comes_again_after_a_pause(person: Person) -> None:
    twice = person.repeated(2, 1.5)
    assert (np.diff(twice.time) > 0.0).all()
    assert twice.time[T] - twice.time[T - 1] == pytest.approx(1.5)
    assert twice.cut(twice.time[T], np.inf).trunk == pytest.approx(person.trunk)
    assert person.slowed(2.0).time[-1] == pytest.approx(2.0 * person.time[-1])


def test_parts_can_be_left_out(person: Person) -> None:
    assert person.without("arms").limbs == {}
    still = person.without("pelvis")
    assert np.ptp(still.pelvis, axis=0) == pytest.approx(np.zeros(3))
    assert still.trunk == pytest.approx(person.trunk)


@pytest.mark.parametrize(("wanted", "safe", "edge"), [(1.0, 4.0, 2.3), (1.0, 0.0, 0.62)])
def test_what_is_nearest_to_what_is_wanted_is_found(wanted: float, safe: float, edge: float) -> None:
    asked = []

    def holds(value: float) -> bool:
        asked.append(value)
        return (value - edge) * (safe - wanted) >= 0.0

    found = nearest(holds, wanted, safe, 0.05)
    assert found is not None
    assert holds(found)
    assert abs(found - edge) <= 0.05
    assert len(asked) < 10
    assert nearest(lambda _: False, wanted, safe, 0.05) is None


@pytest.mark.parametrize("up", ["x", "-x", "-y", "z"])
def test_a_body_that_does_not_stand_at_rest_is_refused_with_the_axis_to_say(tmp_path: Path, up: str) -> None:
    """A wrong axis gave a division by zero, or a person as tall as a hair."""
    (tmp_path / "bow.bvh").write_bytes(bvh(bow()))
    with pytest.raises(BadMotion) as refused:
        person_of(open_motion(tmp_path / "bow.bvh", up=up))
    assert refused.value.faults[0].rule == "not_upright"
    assert "--up" in (refused.value.faults[0].advice or "")
    assert person_of(open_motion(tmp_path / "bow.bvh", up="y")).hip_height == pytest.approx(0.85, abs=0.01)


@pytest.mark.parametrize(
    ("thigh", "shank"),
    [
        ("0 43 0", "0 42 0"),  # folded up, as iClone's: the hips stood a leg below the ankles
        ("14.707 -40.407 0", "14.365 -39.467 0"),  # spread by 20 degrees, as CMU's: the hips stood 6 % too low
        ("0 -43 0", "0 0 -42"),  # kneeling
    ],
)
def test_a_person_is_as_tall_however_the_file_rests(tmp_path: Path, thigh: str, shank: str) -> None:
    other = bvh(bow()).replace(b"OFFSET 0 -43 0", f"OFFSET {thigh}".encode())
    (tmp_path / "rests.bvh").write_bytes(other.replace(b"OFFSET 0 -42 0", f"OFFSET {shank}".encode()))
    assert person_of(open_motion(tmp_path / "rests.bvh", up="y", unit="cm")).hip_height == pytest.approx(0.85, abs=1e-4)


def _along_bones(flexion: np.ndarray, yaw_deg: float) -> str:
    """The person of `captures` who bows, turned about the vertical, with bones whose own x runs along them, as Rokoko
    writes: with all angles at zero they are no posture."""
    own = {name: np.eye(3) for name, _, _ in BONES}
    for name, parent, _ in BONES:
        child = next((offset for _, of, offset in BONES if of == name), ENDS.get(name))
        if parent is not None and child is not None:
            x = np.array(child) / np.linalg.norm(child)
            z = np.cross(x, [0.0, 0.0, 1.0] if abs(x[2]) < 0.9 else [1.0, 0.0, 0.0])
            z /= np.linalg.norm(z)
            own[name] = np.stack([x, np.cross(z, x), z], axis=1) @ Rotation.from_euler("x", 0.4).as_matrix()
    lines = bvh(flexion).decode().split("\n")
    begin, name = lines.index("MOTION"), ""
    for k, line in enumerate(lines[:begin]):
        words = line.split()
        if words and words[0] in ("ROOT", "JOINT", "End"):
            of = next((parent for each, parent, _ in BONES if each == words[1]), None)
            name = name if words[0] == "End" else words[1]
            into = own[name if words[0] == "End" else of] if of is not None or words[0] == "End" else np.eye(3)
        elif words and words[0] == "OFFSET":
            lines[k] = "OFFSET " + " ".join(f"{x:.9f}" for x in np.array(words[1:], dtype=float) @ into)
    order = written_order()
    for k in range(begin + 3, len(lines) - 1):
        row = np.array(lines[k].split(), dtype=float)
        for j, each in enumerate(order):
            parent = next(parent for other, parent, _ in BONES if other == each)
            turn = Rotation.from_euler("ZXY", row[3 + 3 * j : 6 + 3 * j], degrees=True)
            if parent is None:
                turn = Rotation.from_euler("Y", yaw_deg, degrees=True) * turn
            before = np.eye(3) if parent is None else own[parent]
            local = before.T @ turn.as_matrix() @ own[each]
            row[3 + 3 * j : 6 + 3 * j] = Rotation.from_matrix(local).as_euler("ZXY", degrees=True)
        lines[k] = " ".join(f"{x:.9f}" for x in row)
    return "\n".join(lines)


@pytest.mark.slow
def test_bones_that_are_no_posture_at_rest_are_read_by_what_they_carry(tmp_path: Path) -> None:
    """A trunk that stood was fitted as if it lay, and retargeting refused what Rokoko writes."""
    (tmp_path / "a.bvh").write_text(_along_bones(bow(30.0), 40.0))
    (tmp_path / "b.bvh").write_bytes(bvh(bow(30.0)))
    motion = open_motion(tmp_path / "a.bvh")
    person, other = person_of(motion), person_of(open_motion(tmp_path / "b.bvh"))
    assert np.degrees(np.arctan2(person.trunk[:, 0, 2], person.trunk[:, 2, 2])) == pytest.approx(bow(30.0), abs=1e-4)
    assert person.trunk == pytest.approx(other.trunk, abs=1e-5)
    about = Rotation.from_euler("z", 40.0, degrees=True).as_matrix()
    assert person.turn == pytest.approx(about @ other.turn, abs=1e-5)
    assert person.limbs["l_upper_arm"] == pytest.approx(other.limbs["l_upper_arm"], abs=1e-5)
    fit = fit_human(motion)
    assert np.degrees(fit.q[:, fit.body.index("trunk_flexion")]) == pytest.approx(bow(30.0), abs=0.5)
    with pytest.raises(BadMotion) as refused:
        person_of(open_motion(tmp_path / "a.bvh", up="z"))
    assert refused.value.faults[0].rule == "not_upright"
