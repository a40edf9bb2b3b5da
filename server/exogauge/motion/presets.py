"""Which part of the body a marker or a bone is on, by the names that are in use."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from exogauge.robots.moving.segments import Segment

_LIMBS = ("upper_arm", "forearm", "hand", "thigh", "shank", "foot")


def _limbs(before: str, names: str) -> dict[str, str]:
    """Of a skeleton's bones, in the order of `_LIMBS`."""
    return {f"{{s}}_{limb}": before + name for limb, name in zip(_LIMBS, names.split(), strict=True)}


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
        "pelvis": "{s}.ASIS {s}.PSIS {s}_HJC {s}_HJC_REG",
        "thorax": "{s}_SHOULDER {s}_STERNUM",
        "{s}_upper_arm": "{s}_HUMERUS {s}_ELBOW_LAT {s}_ELBOW_MED",
        "{s}_forearm": "{s}_FOREARM {s}_WRIST_RADIUS {s}_WRIST_ULNA",
        "{s}_thigh": "{s}_THIGH1 {s}_THIGH2 {s}_THIGH3 {s}_THIGH4 {s}_THIGH5 {s}_KNEE {s}_MKNEE",
        "{s}_shank": "{s}_SHANK_ANTSUP {s}_SH2 {s}_SH3 {s}_SH4 {s}_ANKLE {s}_MANKLE",
        "{s}_foot": "{s}_CALC {s}_TOE {s}_5META",
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
    "Acclaim (CMU)": _limbs("{s}", "HUMERUS RADIUS HAND FEMUR TIBIA FOOT"),
    "iClone": _limbs("CC_BASE_{s}_", "UPPERARM FOREARM HAND THIGH CALF FOOT"),
    "Mixamo": _limbs("{side}", "ARM FOREARM HAND UPLEG LEG FOOT"),
    "3ds Max Biped": _limbs("BIP01_{s}_", "UPPERARM FOREARM HAND THIGH CALF FOOT"),
    "Xsens MVN": _limbs("{side}", "SHOULDER ELBOW WRIST HIP KNEE ANKLE"),
}  # fmt: skip
_MIDDLE: dict[str, dict[str, str]] = {
    "Plug-in Gait, CMU and Vicon": {"pelvis": "SACR", "thorax": "C7 T10 CLAV STRN RBAK", "head": "ARIEL"},
    "OpenCap and OpenSim": {"thorax": "C7"},
    "Acclaim (CMU)": {"pelvis": "ROOT", "thorax": "THORAX", "head": "HEAD"},
    "iClone": {"pelvis": "CC_BASE_HIP", "thorax": "CC_BASE_SPINE02", "head": "CC_BASE_HEAD"},
    "Mixamo": {"pelvis": "HIPS", "thorax": "SPINE2", "head": "HEAD"},
    "3ds Max Biped": {"pelvis": "BIP01_PELVIS", "thorax": "BIP01_SPINE2", "head": "BIP01_HEAD"},
    "Xsens MVN": {"pelvis": "HIPS", "thorax": "CHEST4", "head": "HEAD"},
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
    """The preset that knows most of the labels, letters' case aside, a space as an underscore, and the parts of those
    that it knows."""
    alike = {label: label.upper().replace(" ", "_") for label in labels}
    known = {
        name: {label: preset[other] for label, other in alike.items() if other in preset}
        for name, preset in PRESETS.items()
    }
    best = max(known, key=lambda name: len(known[name]))
    return (best, known[best]) if known[best] else (None, {})
