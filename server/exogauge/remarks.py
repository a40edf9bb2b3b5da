"""What has to be kept in mind of a result, as data: what it is about, of what, with which numbers. No sentences."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import final


@final
class About(StrEnum):
    """Behind each: `names`, what `each` holds of every one of them, `beside`, and `numbers`, in that order."""

    # the URDF
    INERTIA_RAISED = "inertia_raised"  # links; -; file, worst link; by how much [kg·m²], its principal moments
    TOO_DENSE = "too_dense"  # -; -; file; mass of all links [kg], density that half of it exceeds [kg/m³]
    TOO_LIGHT = "too_light"  # -; -; file; the same, density that half of it is below
    MASSES_ALIKE = "masses_alike"  # -; -; file; mass of every link [kg], how many
    NO_EXTENT = "no_extent"  # -; -; file; mass of all links [kg]
    LIMITS_IN_DEGREES = "limits_in_degrees"  # -; -; file; median end of joints that turn [rad]
    MOVES_NOTHING = "moves_nothing"  # joints; -; file
    # the identification
    FACTOR_OPEN = "factor_open"
    LOAD_NOT_FITTED = "load_not_fitted"  # loads; mass [kg]
    LOAD_IN_EVERY_LOG = "load_in_every_log"  # loads; mass [kg]
    LOAD_FELT_TOO_LITTLE = "load_felt_too_little"  # loads; mass [kg]; -; doubt without and with it, as shares
    HELD_AT_EDGE = "held_at_edge"  # parameters
    STICKS_UNEQUALLY = "sticks_unequally"  # joints
    LITTLE_STEADY = "little_steady"  # joints; steady and moving [s]; -; share that is asked for
    ONE_DIRECTION = "one_direction"  # joints
    HARDLY_SLIDES = "hardly_slides"  # joints; share of steady motion beyond; its unit; way since a turn [rad or m]
    CREEPING = "creeping"  # joints; speed below which; its unit beside
    FEET_AGAINST_MASS = "feet_against_mass"  # -; -; -; mass by the logs, its doubt, stated, its doubt [kg]
    NEGATIVE_MASS = "negative_mass"  # links; mass and its doubt [kg]
    # links, joints; standard deviations as stated by which the logs are off, doubt instead [%]
    CENTRE_LET_GO = "centre_let_go"
    MASS_LET_GO = "mass_let_go"
    GAIN_LET_GO = "gain_let_go"
    LEFT_WITHOUT_SEARCH = "left_without_search"  # channels that no search looked into; error over its noise
    NOT_CONVERGED = "not_converged"  # -; -; -; steps, squared standard deviations above the minimum, and asked for
    REFERENCE_IMPOSSIBLE = "reference_impossible"  # bodies
    UNDECIDED_COMBINATIONS = "undecided_combinations"  # -; -; -; how many
    WORSE_HELD_OUT = "worse_held_out"  # joints
    LOGS_LEFT_OUT = "logs_left_out"  # logs; by which their efforts are late, against their positions [s]
    LOGS_SPOILED = "logs_spoiled"  # logs that are left out; beside: what the doctor holds against them, what to do
    SPOILED_FIT = "spoiled_fit"  # logs that are fitted all the same, as no others are; beside: as above
    LATE_FIT = "late_fit"  # fitted logs; -; channel and what is told of it
    DOCTOR_ERRORS = "doctor_errors"  # channels that the identification rests on
    NO_URDF_OF = "no_urdf_of"  # links
    # the supporting torque
    TOUCHED = "touched"  # the log; -; -; start, stop, start, stop … [s]
    LOW_PASSED = "low_passed"  # logs; -; -; at [Hz]
    STORED_UNLIKE = "stored_unlike"  # logs with the device; -; logs that were low-passed
    MOTION_DOUBTFUL = "motion_doubtful"  # the log and its reference; -; joint; share of its rms velocity, limit, [rad]
    SESSION_UNKNOWN = "session_unknown"  # logs that do not say when they began
    NO_RUN_AFTER = "no_run_after"  # motions
    DRIFT_FOUND = "drift_found"  # coefficient and joint; share that it changes by through the session, its doubt [%]
    ZEROS_FOUND = "zeros_found"  # components; how far the sum of feet moved by the end, its doubt [N, N·m]
    LABELS_EXCHANGED = "labels_exchanged"  # logs that say with it and do not show it, and the reverse; -; device
    DEVICE_ON = "device_on"  # logs that say without it; -; device
    DEVICE_OFF = "device_off"  # logs that say with it; -; device
    DEVICE_ON_WHERE_FITTED = "device_on_where_fitted"  # logs without it; -; device
    NOT_OF_BANDS = "not_of_bands"  # logs; what its bands leave, what is measured [N·m]; device
    WORN_WEIGHT = "worn_weight"  # -; -; device; what feet bear beyond logs without it, its doubt [kg]
    BANDS_OF_FILE = "bands_of_file"
    BANDS_UNKNOWN = "bands_unknown"
    BANDS_IDENTIFIED = "bands_identified"  # -; -; approach
    # bands
    LAW_STATED = "law_stated"  # bands; -; law of each
    STIFFNESS_NOT_AS_STATED = "stiffness_not_as_stated"  # the band; found and stated [N/m]
    LENGTH_NOT_AS_STATED = "length_not_as_stated"  # the band; found and stated [m]
    LENGTHS_TIED = "lengths_tied"  # bands
    PULLS_NOWHERE = "pulls_nowhere"  # the band
    NOT_TOLD_APART = "not_told_apart"  # parameters; -; others
    NOT_TOLD = "not_told"  # the parameter
    BANDS_LEFT_OUT = "bands_left_out"  # bands
    OWN_GROUP = "own_group"  # the band; -; its group before
    SLACK = "slack"  # the band
    BOUND_REACHED = "bound_reached"  # parameters and effects
    # two parts of the evidence; -; -; difference and its doubt [N/m]
    APPROACHES_DISAGREE = "approaches_disagree"
    REPETITIONS_DISAGREE = "repetitions_disagree"
    STROKES_DISAGREE = "strokes_disagree"
    PULLS_DISAGREE = "pulls_disagree"
    RELAXATION = "relaxation"
    SIDES_DISAGREE = "sides_disagree"
    LENGTHS_DISAGREE = "lengths_disagree"  # the parts; -; -; difference of natural length and its doubt [m]
    HALVES_DISAGREE = "halves_disagree"  # the parts; -; -; difference of natural length and its doubt [m]
    SPRINGS_MISFIT = "springs_misfit"  # the joint, -; -; what it may do to the stiffness and its stated doubt [N/m]
    STIFFNESS_OPEN = "stiffness_open"
    ALONE_IN_GROUP = "alone_in_group"  # bands that are slack, or may be; -; their group
    ANOTHER_FIT = "another_fit"  # the band; -; -; its stiffness there [N/m]
    LENGTH_OPEN = "length_open"


@final
@dataclass(frozen=True)
class Remark:
    """names, each, beside, numbers: as `About` says."""

    about: About
    names: tuple[str, ...] = ()
    each: tuple[tuple[float, ...], ...] = ()
    beside: tuple[str, ...] = ()
    numbers: tuple[float, ...] = ()
