"""Which part of the body a marker or a bone is on, by the names that are in use."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence

from exogauge.robots.moving.segments import Segment

SIDES = ("L", "R", "LEFT", "RIGHT")
_LIMBS = ("upper_arm", "forearm", "hand", "thigh", "shank", "foot")


def _limbs(before: str, names: str) -> dict[str, str]:
    """Of a skeleton's bones, in the order of `_LIMBS`. before: what stands there, or there in other files."""
    return {f"{{s}}_{limb}": " ".join(each + name for each in before.split(" "))
            for limb, name in zip(_LIMBS, names.split(), strict=True)}  # fmt: skip


_BOTH: dict[str, dict[str, str]] = {  # {s} is the side's letter
    "Plug-in Gait, CMU and Vicon": {
        "pelvis": "{s}ASI {s}PSI {s}FWT {s}MWT {s}BWT",
        "thorax": "{s}SHO {s}FSH {s}BSH {s}BAC",
        "head": "{s}FHD {s}BHD",
        "{s}_upper_arm": "{s}UPA {s}UPB {s}ELB {s}IEL {s}UA1 {s}UA2 {s}UA3",
        "{s}_forearm": "{s}FRM {s}FRA {s}WRA {s}WRB {s}LA1 {s}LA2 {s}LA3 {s}OWR {s}IWR {s}WRE",
        "{s}_hand": "{s}FIN {s}IHAND {s}OHAND",
        "{s}_thigh": "{s}THI {s}THI2 {s}THI3 {s}HIP {s}KNE {s}KNI",
        "{s}_shank": "{s}TIB {s}TIB2 {s}TIB3 {s}SHN {s}ANK",
        "{s}_foot": "{s}HEE {s}HEL {s}TOE {s}MT1 {s}MT5 {s}LATFOOT",
    },
    "OpenCap and OpenSim": {
        "pelvis": "{s}.ASIS {s}.PSIS {s}_HJC {s}_HJC_REG {s}HJC",
        "thorax": "{s}_SHOULDER {s}_STERNUM",
        "{s}_upper_arm": "{s}_HUMERUS {s}_ELBOW_LAT {s}_ELBOW_MED {s}_LELBOW {s}_MELBOW",
        "{s}_forearm": "{s}_FOREARM {s}_WRIST_RADIUS {s}_WRIST_ULNA {s}_LWRIST {s}_MWRIST",
        "{s}_thigh": "{s}_THIGH1 {s}_THIGH2 {s}_THIGH3 {s}_THIGH4 {s}_THIGH5 {s}_KNEE {s}_MKNEE",
        "{s}_shank": "{s}_SHANK_ANTSUP {s}_SH1 {s}_SH2 {s}_SH3 {s}_SH4 {s}_ANKLE {s}_MANKLE",
        "{s}_foot": "{s}_CALC {s}_TOE {s}_5META",
    },
    "OptiTrack and Qualisys": {
        "pelvis": "WAIST{s}FRONT WAIST{s}BACK",
        "thorax": "BACK{side} BACK{s} {s}SHOULDERTOP {s}SHOULDERBACK",
        "head": "HEAD{s}",
        "{s}_upper_arm": "{s}UARMHIGH {s}ARM {s}ELBOWOUT {s}ELBOWIN",
        "{s}_forearm": "{s}WRISTOUT {s}WRISTIN",
        "{s}_hand": "{s}HANDOUT {s}HANDIN",
        "{s}_thigh": "{s}THIGH {s}KNEEOUT {s}KNEEIN",
        "{s}_shank": "{s}SHIN {s}ANKLEOUT {s}ANKLEIN",
        "{s}_foot": "{s}HEEL {s}HEELBACK {s}TOEIN {s}TOEOUT {s}TOETIP {s}FOREFOOTIN {s}FOREFOOTOUT",
    },
    "Cleveland Clinic clusters": {
        "pelvis": "{s}PV1 {s}PV2 {s}PV3",
        "{s}_upper_arm": "{s}AR1 {s}AR2 {s}AR3",
        "{s}_forearm": "{s}FA1 {s}FA2 {s}FA3",
        "{s}_thigh": "{s}TH1 {s}TH2 {s}TH3",
        "{s}_shank": "{s}SK1 {s}SK2 {s}SK3",
        "{s}_foot": "{s}FT1 {s}FT2 {s}FT3",
        "thorax": "{s}TA1 {s}TA2 {s}TA3",
    },
    "OpenSim's gait models": {
        "pelvis": "{s}.ASIS {s}.PSIS",
        "thorax": "{s}.ACROMIUM {s}.SHOULDER",
        "{s}_upper_arm": "{s}.BICEP {s}.BICEPS {s}.ELBOW",
        "{s}_forearm": "{s}.FOREARM {s}.WRIST",
        "{s}_thigh": "{s}.THIGH.UPPER {s}.THIGH.FRONT {s}.THIGH.REAR {s}.KNEE.LAT {s}.KNEE.MED {s}.THIGH {s}.KNEE "
                     "{s}.KNEE.MEDIAL",
        "{s}_shank": "{s}.SHANK.UPPER {s}.SHANK.FRONT {s}.SHANK.REAR {s}.ANKLE.LAT {s}.ANKLE.MED {s}.SHANK {s}.ANKLE "
                     "{s}.ANKLE.MEDIAL",
        "{s}_foot": "{s}.HEEL {s}.MIDFOOT.SUP {s}.MIDFOOT.LAT {s}.TOE.TIP {s}.TOE",
    },
    "Visual3D and IOR": {
        "pelvis": "{s}_IAS {s}_IPS {s}IAS {s}IPS",
        "thorax": "{s}_SAE {s}SAE",
        "head": "{s}_HEAD",
        "{s}_upper_arm": "{s}_HLE {s}_HME {s}HLE {s}HME",
        "{s}_forearm": "{s}_RSP {s}_USP {s}RSP {s}USP",
        "{s}_hand": "{s}_HM2 {s}_HM5 {s}HM2 {s}HM5",
        "{s}_thigh": "{s}_FTC {s}_FLE {s}_FME {s}FTC {s}FLE {s}FME {s}_THI {s}_TH1 {s}_TH2 {s}_TH3 {s}_TH4",
        "{s}_shank": "{s}_TTC {s}_FAX {s}_FAL {s}_TAM {s}TTC {s}FAX {s}FAL {s}TAM {s}_TIB {s}_SK1 {s}_SK2 {s}_SK3",
        "{s}_foot": "{s}_FCC {s}_FM1 {s}_FM2 {s}_FM5 {s}FCC {s}FM1 {s}FM2 {s}FM5",
    },
    "OpenPose and Pose2Sim": {  # centres of joints, as seen in videos (BODY_25, HALPE_26, COCO, BLAZEPOSE)
        "pelvis": "{s}HIP",
        "thorax": "{s}SHOULDER",
        "head": "{s}EYE {s}EAR",
        "{s}_upper_arm": "{s}ELBOW",
        "{s}_forearm": "{s}WRIST",
        "{s}_hand": "{s}THUMB {s}INDEX {s}PINKY",
        "{s}_thigh": "{s}KNEE",
        "{s}_shank": "{s}ANKLE",
        "{s}_foot": "{s}BIGTOE {s}SMALLTOE {s}HEEL",
    },
    "Acclaim (CMU)": _limbs("{s}", "HUMERUS RADIUS HAND FEMUR TIBIA FOOT"),
    "iClone": _limbs("{s}_", "UPPERARM FOREARM HAND THIGH CALF FOOT"),
    "MotionBuilder and Mixamo": _limbs("{side}", "ARM FOREARM HAND UPLEG LEG FOOT"),
    "3ds Max Biped": _limbs("{s}_", "UPPERARM FOREARM HAND THIGH CALF FOOT"),
    "Xsens MVN": _limbs("{side}", "SHOULDER ELBOW WRIST HIP KNEE ANKLE"),
    "Motive": _limbs("{s}", "UARM FARM HAND THIGH SHIN FOOT"),
    "Rokoko": _limbs("{side}", "ARM FOREARM HAND THIGH SHIN FOOT"),
    "Daz and Poser": _limbs("{s}", "SHLDR FOREARM HAND THIGH SHIN FOOT"),
    "SMPL": _limbs("{s}_ {side}_", "SHOULDER ELBOW WRIST HIP KNEE ANKLE"),
    "Xsens MVN's segments": _limbs("{side}", "UPPERARM FOREARM HAND UPPERLEG LOWERLEG FOOT"),
    "Unreal": _limbs("", "UPPERARM_{s} LOWERARM_{s} HAND_{s} THIGH_{s} CALF_{s} FOOT_{s}"),
    "VRM and Bandai Namco": _limbs("", "UPPERARM_{s} LOWERARM_{s} HAND_{s} UPPERLEG_{s} LOWERLEG_{s} FOOT_{s}"),
    "Unity": _limbs("{side}", "UPPERARM LOWERARM HAND UPPERLEG LOWERLEG FOOT"),
    "VRoid": _limbs("{s}_", "UPPERARM LOWERARM HAND UPPERLEG LOWERLEG FOOT"),
    "Kinect": _limbs("", "SHOULDER{side} ELBOW{side} WRIST{side} HIP{side} KNEE{side} ANKLE{side}"),
    "Rigify": _limbs("", "UPPER_ARM.{s} FOREARM.{s} HAND.{s} THIGH.{s} SHIN.{s} FOOT.{s}"),
}  # fmt: skip
_MIDDLE: dict[str, dict[str, str]] = {  # of a skeleton, the thorax where no arms say which it is
    "Plug-in Gait, CMU and Vicon": {"pelvis": "SACR", "thorax": "C7 T10 CLAV STRN RBAK", "head": "ARIEL"},
    "OpenCap and OpenSim": {"thorax": "C7"},
    "OptiTrack and Qualisys": {"thorax": "BACKTOP SPINETOP CHEST", "head": "HEADTOP HEADFRONT HEADSIDE"},
    "OpenPose and Pose2Sim": {"pelvis": "HIP CHIP", "thorax": "NECK", "head": "HEAD NOSE"},
    "Acclaim (CMU)": {"pelvis": "ROOT", "thorax": "THORAX", "head": "HEAD"},
    "iClone": {"pelvis": "HIP", "thorax": "SPINE02", "head": "HEAD"},
    "MotionBuilder and Mixamo": {"pelvis": "HIPS", "thorax": "SPINE2", "head": "HEAD"},
    "3ds Max Biped": {"pelvis": "PELVIS", "thorax": "SPINE2", "head": "HEAD"},
    "Xsens MVN": {"pelvis": "HIPS", "thorax": "CHEST4", "head": "HEAD"},
    "Motive": {"pelvis": "HIP", "thorax": "CHEST", "head": "HEAD"},
    "Rokoko": {"pelvis": "HIPS", "thorax": "SPINE4", "head": "HEAD"},
    "Daz and Poser": {"pelvis": "HIP", "thorax": "CHEST", "head": "HEAD"},
    "SMPL": {"pelvis": "PELVIS", "thorax": "SPINE3", "head": "HEAD"},
    "Xsens MVN's segments": {"pelvis": "PELVIS", "thorax": "T8", "head": "HEAD"},
    "Unreal": {"pelvis": "PELVIS", "thorax": "SPINE_03", "head": "HEAD"},
    "VRM and Bandai Namco": {"pelvis": "HIPS", "thorax": "CHEST", "head": "HEAD"},
    "Unity": {"pelvis": "HIPS", "thorax": "CHEST", "head": "HEAD"},
    "VRoid": {"pelvis": "C_HIPS", "thorax": "C_UPPERCHEST C_CHEST", "head": "C_HEAD"},
    "Kinect": {"pelvis": "SPINEBASE", "thorax": "SPINESHOULDER", "head": "HEAD"},
    "Rigify": {"pelvis": "SPINE HIPS", "thorax": "SPINE.003 CHEST", "head": "SPINE.006 HEAD"},
    "OpenSim's gait models": {"pelvis": "V.SACRAL", "thorax": "STERNUM", "head": "TOP.HEAD FRONT.HEAD REAR.HEAD"},
    "Visual3D and IOR": {"thorax": "CV7 TV2 TV8 TV10 MAI SJN SXS SME", "head": "SGL"},
}


def _preset(name: str) -> dict[str, Segment]:
    found: dict[str, str] = {label: part for part, labels in _MIDDLE.get(name, {}).items() for label in labels.split()}
    for letter, side in (("L", "LEFT"), ("R", "RIGHT")):
        for part, labels in _BOTH[name].items():
            for label in labels.split():
                found[label.format(s=letter, side=side)] = part.format(s=letter.lower())
    return found  # type: ignore[return-value]


PRESETS: Mapping[str, Mapping[str, Segment]] = {name: _preset(name) for name in _BOTH}


def recognise(labels: Iterable[str]) -> tuple[str | None, dict[str, Segment]]:
    """The preset that knows most of the labels, as `alike` has them, and the parts of those that it knows."""
    same = {label: alike(label) for label in labels}
    known = {
        name: {label: preset[other] for label, other in same.items() if other in preset}
        for name, preset in PRESETS.items()
    }
    best = max(known, key=lambda name: len(known[name]))
    return (best, known[best]) if known[best] else (None, {})


def subjects(labels: Iterable[str]) -> dict[str, int]:
    """What stands before the names of one preset, up to a colon, a space or an underscore, and before how many of them:
    one person each, "" where nothing does. Less than half as many names as the best has are nobody's."""
    found: Counter[tuple[str, str]] = Counter()
    for label in dict.fromkeys(labels):
        begins = [0, *(k + 1 for k, letter in enumerate(label) if letter in ":_ " and label[:k].upper() not in SIDES)]
        found.update(
            (name, label[:k]) for k in begins for name, preset in PRESETS.items() if alike(label[k:]) in preset
        )
    if not found:
        return {}
    best, most = found.most_common(1)[0]
    return {of: count for (name, of), count in found.items() if name == best[0] and 2 * count >= most}


def carried_by(names: Sequence[str], parent: Sequence[int], segment: Mapping[str, Segment]) -> dict[str, Segment]:
    """The same with the bone as thorax on which both arms hang, however many vertebrae a program has; where they hang
    on the neck, what carries that."""
    arms = [next((k for k, name in enumerate(names) if segment.get(name) == f"{s}_upper_arm"), -1) for s in "lr"]
    if min(arms) < 0:
        return dict(segment)
    ways = [_way(parent, arm) for arm in arms]
    both = [k for k in ways[0] if k in ways[1] and "NECK" not in names[k].upper()]
    if not both or segment.get(names[both[0]]) not in (None, "thorax"):
        return dict(segment)
    return {name: part for name, part in segment.items() if part != "thorax"} | {names[both[0]]: "thorax"}


def _way(parent: Sequence[int], bone: int) -> list[int]:
    """To the root."""
    way = [bone]
    while parent[way[-1]] >= 0:
        way.append(parent[way[-1]])
    return way


def alike(label: str) -> str:
    """Letters' case aside, a space as an underscore, without what OpenCap puts behind markers that it infers."""
    return label.upper().replace(" ", "_").removesuffix("_STUDY")
