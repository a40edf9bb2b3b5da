"""Where markers of a known name sit on the body: metres in their part, left side, at scales 1.

Landmarks are bony points; the places of pelvis, knee and ankle follow Delp et al. 1990, the others a body of 1.75 m in
the proportions of `body`. A loose marker is on a segment's side, where it was stuck.
"""

from __future__ import annotations

from collections.abc import Mapping

from exogauge.motion.fit.body import FOREARM, HIP, SHANK, THIGH, UPPER_ARM
from exogauge.motion.presets import alike

Place = tuple[float, float, float]

LANDMARKS: Mapping[str, Place] = {
    "{s}ASI {s}.ASIS WAIST{s}FRONT {s}_IAS {s}IAS": (0.08, 0.128, 0.07),
    "{s}PSI {s}.PSIS {s}_IPS {s}IPS": (-0.09, 0.05, 0.10),
    "SACR V.SACRAL": (-0.10, 0.0, 0.10),
    "{s}FWT": (0.09, 0.12, 0.08),
    "{s}BWT": (-0.10, 0.06, 0.10),
    "{s}_HJC {s}_HJC_REG {s}HJC pelvis:{s}HIP": HIP,
    "C7 BACKTOP SPINETOP CV7": (-0.06, 0.0, 0.43),
    "CLAV SJN": (0.06, 0.0, 0.36),
    "STRN SXS STERNUM": (0.10, 0.0, 0.21),
    "T10 TV10 TV8": (-0.10, 0.0, 0.19),
    "{s}SHO {s}_SHOULDER {s}SHOULDERTOP {s}_SAE {s}SAE {s}.ACROMIUM {s}.SHOULDER": (-0.01, 0.17, 0.40),
    "{s}_STERNUM": (0.06, 0.025, 0.36),
    "{s}FHD": (0.10, 0.07, 0.17),
    "{s}BHD": (-0.08, 0.07, 0.17),
    "ARIEL HEADTOP TOP.HEAD": (0.0, 0.0, 0.24),
    "{s}ELB {s}_ELBOW_LAT {s}_LELBOW {s}ELBOWOUT {s}_HLE {s}HLE {s}.ELBOW": (0.0, 0.04, -UPPER_ARM),
    "{s}IEL {s}_ELBOW_MED {s}_MELBOW {s}ELBOWIN {s}_HME {s}HME": (0.0, -0.04, -UPPER_ARM),
    "{s}WRA {s}_WRIST_RADIUS {s}IWR {s}_RSP {s}RSP": (0.03, 0.0, -FOREARM),
    "{s}WRB {s}_WRIST_ULNA {s}OWR {s}_USP {s}USP": (-0.03, 0.0, -FOREARM),
    "{s}FIN": (0.0, 0.02, -0.085),
    "{s}KNE {s}_KNEE {s}KNEEOUT {s}_FLE {s}FLE {s}.KNEE.LAT {s}.KNEE": (0.0, 0.055, -THIGH),
    "{s}KNI {s}_MKNEE {s}KNEEIN {s}_FME {s}FME {s}.KNEE.MED {s}.KNEE.MEDIAL": (0.0, -0.055, -THIGH),
    "{s}ANK {s}_ANKLE {s}ANKLEOUT {s}_FAL {s}FAL {s}.ANKLE.LAT {s}.ANKLE": (-0.01, 0.04, -SHANK),
    "{s}_MANKLE {s}ANKLEIN {s}_TAM {s}TAM {s}.ANKLE.MED {s}.ANKLE.MEDIAL": (0.0, -0.04, -SHANK),
    "{s}HEE {s}HEL {s}_CALC {s}HEEL {s}HEELBACK {s}_FCC {s}FCC {s}.HEEL": (-0.06, 0.0, -0.03),
    "{s}TOE {s}_TOE {s}_FM2 {s}FM2 {s}.TOE {s}.TOE.TIP {s}BIGTOE": (0.14, 0.0, -0.035),
    "{s}MT5 {s}_5META {s}TOEOUT {s}FOREFOOTOUT {s}_FM5 {s}FM5 {s}SMALLTOE": (0.10, 0.045, -0.05),
    "{s}MT1 {s}TOEIN {s}FOREFOOTIN {s}_FM1 {s}FM1": (0.12, -0.04, -0.045),
    "{s}LATFOOT": (0.05, 0.045, -0.05),
}
LOOSE: Mapping[str, Place] = {
    "{s}IWR {s}OWR": (0.0, 0.0, -FOREARM), "{s}IHAND {s}OHAND": (0.0, 0.0, -0.08),  # inside is where the hand was then
    "{s}MWT": (0.0, 0.16, 0.11), "{s}FSH": (0.06, 0.17, 0.36), "{s}BSH": (-0.06, 0.17, 0.36),
    "{s}BAC": (-0.1, 0.1, 0.3),
    "{s}UPA {s}_HUMERUS {s}UARMHIGH {s}ARM": (0.0, 0.05, -0.15), "{s}FRM {s}_FOREARM {s}WRE": (0.0, 0.04, -0.12),
    "{s}THI {s}THIGH": (0.0, 0.09, -0.2), "{s}HIP": (0.0, 0.08, -0.1), "{s}TIB {s}SHN {s}SHIN": (0.03, 0.03, -0.2),
    "{s}_SHANK_ANTSUP": (0.045, 0.0, -0.09),
    "WAIST{s}BACK": (-0.06, 0.11, 0.10), "CHEST": (0.08, 0.0, 0.31),  # as OptiTrack's documentation places them
    "BACK{side} BACK{s}": (-0.10, 0.09, 0.19), "{s}SHOULDERBACK": (-0.06, 0.15, 0.37), "HEADFRONT": (0.11, 0.0, 0.17),
}  # fmt: skip


def place_of(label: str, part: str = "") -> tuple[Place, bool] | None:
    """Nominal place of a marker and whether it is a landmark; None where its name says no place.

    part: of the body on which its preset has it, as one name is elsewhere in another set.
    """
    return _PLACES.get(f"{part}:{alike(label)}") or _PLACES.get(alike(label))


def _sides(table: Mapping[str, Place], landmark: bool) -> dict[str, tuple[Place, bool]]:
    return {
        label.format(s=letter, side=name): ((x, side * y, z), landmark)
        for labels, (x, y, z) in table.items()
        for label in labels.split()
        for letter, name, side in (("L", "LEFT", 1.0), ("R", "RIGHT", -1.0))
    }


_PLACES = _sides(LANDMARKS, True) | _sides(LOOSE, False)
