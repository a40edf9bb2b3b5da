"""iCub walking: 12 s of joint positions, an IMU and the vertical force under each foot; no torques, no currents."""

from __future__ import annotations

from pathlib import Path

RECORDING, FILES = "icub_walking", ("walking.mat", "model.urdf")
SIDES = ("l", "r")
LEG = ("hip_pitch", "hip_roll", "hip_yaw", "knee", "ankle_pitch", "ankle_roll")
ARM = ("shoulder_pitch", "shoulder_roll", "shoulder_yaw", "elbow")
JOINTS = (
    *("neck_pitch", "neck_roll", "neck_yaw", "torso_pitch", "torso_roll", "torso_yaw"),
    *(f"{side}_{joint}" for side in SIDES for joint in ARM),
    *(f"{side}_{joint}" for side in SIDES for joint in LEG),
)

ROBOT = """version: 1
urdf: model.urdf
base: floating
base_link: {base_link}
imu: {{frame: {imu}}}
ft_sensors:
  - {{name: l_foot, frame: l_sole, role: contact, sees: world_on_robot}}
  - {{name: r_foot, frame: r_sole, role: contact, sees: world_on_robot}}
joints:
""" + "".join(f"  - {{{{name: {joint}, actuation: none}}}}\n" for joint in JOINTS)
MAPPING = (
    "version: 1\nrate_hz: 100\nconstants:\n"
    + "".join(f"  ft.{side}_foot.{axis}: 0.0\n" for side in SIDES for axis in ("fx", "fy", "mx", "my", "mz"))
    + "files:\n  - file: walking.mat\n    time: {column: estimatorJointsTime, unit: s}\n    arrays:\n"
    + f"      - {{dataset: estimatorJointsPos, unit: rad, channels: [{', '.join('q.' + j for j in JOINTS)}]}}\n"
    + """    vectors:
      - {channel: acc, dataset: imuAcc, unit: m/s^2}
      - {channel: gyro, dataset: imuOmega, unit: rad/s}
    columns:
      lfForceZ: {channel: ft.l_foot.fz, unit: N}
      rfForceZ: {channel: ft.r_foot.fz, unit: N}
    ignore: rest
"""
)
STUDY = """version: 1
name: iCub walking
robot: robot.yaml
logs:
  - {file: walking.mat, mapping: mapping.yaml, role: identification}
steps: [identify]
"""


def write(folder: Path, base_link: str = "root_link", imu: str = "root_link_imu_frame") -> None:
    (folder / "study.yaml").write_text(STUDY)
    (folder / "mapping.yaml").write_text(MAPPING)
    (folder / "robot.yaml").write_text(ROBOT.format(base_link=base_link, imu=imu))
