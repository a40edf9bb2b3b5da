"""What decides when a human body is fitted to captured motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final


@final
@dataclass(frozen=True)
class MotionFit:
    """Lengths in metres, angles in radians.

    scale_sd: of a segment's length about its share of 1.75 m; statures of adults differ by 4 % (one sd), their shares
    by some more, children by far more. least_scale, largest_scale: from a child of 1 m to the tallest.
    depth_sd: of the lumbar joint behind the hips, 3 cm at scale 1; a spine bends over its whole length.
    landmark_sd: bony points are palpated to 1 to 2 cm (Della Croce et al., Gait & Posture 21, 2005), nominal places of
    another person's add as much. loose_sd: a marker on a segment's side, at no landmark. unknown_sd: one of no known
    place. joint_sd: a skeleton's own joint centre. start_noise: skin moves by 1 to 2 cm (Leardini et al., Gait &
    Posture 21, 2005). least_noise: below any camera's.
    frames: that decide the shared unknowns; static_frames of them from a static trial. still_rad: how straight the
    trunk is in it; that defines its zero. tilt_rad: how upright the pelvis, how straight the legs.
    bone_rad: how exactly a skeleton's bones say pelvis, trunk and head.
    angle_sd: so weak that only what nothing else decides feels it. acceleration: density [rad²/s³ or m²/s³] of what
    drives a coordinate; 100 leaves a single segment that 1 cm of noise is on about 9 Hz, well beyond what is usually
    kept of a person's motion, 6 Hz (Winter, Biomechanics and Motor Control of Human Movement, 2009).
    bent, bent_sd: elbows and knees at the very start, so that they bend the right way; start_sd: of other joints about
    zero. reach_sd: by which a joint goes beyond its reach (`body.REACH`), which is wide. far_rad: of a limb, from where
    it starts: its markers may lie on the other side, and it is sought once more.
    to_go, first_to_go: what a further step would gain, in σ², where scales and places have settled, and where they
    have so far that postures are sought anew by them; swings: times as much that a step may promise that gains less;
    real_noise: m, below which that is less, in proportion.
    track_settled: the same of a frame's posture. damping, least_damping, least_share: at the start; below which
    covariances do not feel it; of a step, below which damping helps more. felt_s: a posture moves those nearer in time.
    first_hz: frames a second that are tracked before the rest. round_off: of a sum of squares.
    fewest: markers that say how pelvis and thorax lie. rigid_line: m, second singular value over the square root of
    the number of points: less is a line. bad_rms: a marker that misses by more is told. no_body_rms: of all markers,
    beyond which no posture is passed on; recordings leave .3 to 1.1 cm, a body in a mirror 4 to 7.
    slip_m: a marker that misses by more in some frames, unlike most of its segment, is none there, or another's; skin
    and stature leave 3 cm at most where labels are right (OpenCap's STS1). shorter_m: from feet to thorax, by which a
    static trial shows no one who stands; who sits is 40 cm shorter, who breathes or leans 2. moment: share of a
    marker's frames up to which that is for a moment; more is a wrong name. slips: times that it is looked for.
    least_seen: share of frames in which pelvis and thorax must be seen. guessed_s: longer stretches in which they are
    not are told; a spline closes shorter ones. chunk: frames of which slopes are held at once.
    at_once: that
    are tracked at once, beside: and looked at before and after them; what is 2 s away says nothing of a posture.
    most_frames: at 200 Hz a quarter of an hour, which takes 3 GB.
    """

    scale_sd: float = 0.15
    depth_sd: float = 1.0
    least_scale: float = 0.5
    largest_scale: float = 1.6
    landmark_sd: float = 0.02
    loose_sd: float = 0.06
    unknown_sd: float = 0.2
    joint_sd: float = 0.01
    start_noise: float = 0.015
    least_noise: float = 1e-5
    frames: int = 60
    static_frames: int = 8
    still_rad: float = 0.005
    tilt_rad: float = 0.2
    bone_rad: float = 0.001
    angle_sd: float = 10.0
    acceleration: float = 100.0
    bent: float = 0.8
    bent_sd: float = 0.8
    start_sd: float = 1.5
    reach_sd: float = 0.1
    far_rad: float = 2.0
    start_steps: int = 40
    start_settled: float = 1e-4
    shared_steps: int = 30
    track_steps: int = 30
    settled: float = 1e-9
    to_go: float = 0.02
    least_share: float = 0.05
    round_off: float = 1e-9
    first_to_go: float = 10.0
    swings: float = 10.0
    real_noise: float = 1e-4
    nearly: float = 1e-4
    same_noise: float = 1e-3
    longest_memory: float = 0.95
    far_off: float = 0.05
    track_settled: float = 0.01
    damping: float = 1e-3
    least_damping: float = 1e-6
    felt_s: float = 0.2
    first_hz: float = 25.0
    fewest: int = 3
    rigid_line: float = 0.01
    bad_rms: float = 0.03
    no_body_rms: float = 0.03
    slip_m: float = 0.15
    shorter_m: float = 0.1
    moment: float = 0.1
    slips: int = 2
    least_seen: float = 0.5
    guessed_s: float = 0.1
    chunk: int = 512
    at_once: int = 5000
    beside: int = 400
    most_frames: int = 200_000


USUAL = MotionFit()
