"""What hangs on a wrist force/torque sensor: identified in two stages, then taken out of what the sensor reads.

- `contract`, `intake`, `log_names`, `imu`, `limits`: payload.yaml and its logs, read and refused
- `doctor`, `prepare`, `smoothing`, `sensor_motion`: logs examined; poses become the sensor's motion
- `rounding`: what a converter's steps leave
- `holds`, `statics`, `turned_axes`: postures at rest: mass, centre, zero, inclination; axes that are others
- `slips`: units that were stated wrong, a wrench that is late
- `dynamics`, `total_least_squares`: motion: the inertia, and how far the noise of both sides counts
- `calibration`: gains and crosstalk of the sensor: what is taken out, and the doubt that stays
- `contact`, `remainder`, `missing`: what touches, what is left, what a rigid body does not explain
- `stages`, `both_stages`, `placed_imu`, `imu_place`: the recipe's steps: postures and motion, also with the sensor's
  calibration; where an IMU sits
- `evaluate`, `compute`: the recipe whole, what each method leaves, what is said; as a job
- `results`, `schema`, `tables`, `report`, `exports`: what is told, for machines and people
- `planning`: what to record
- `live`, `live_start`, `live_input`, `live_track`, `live_fit`: a stream, sample by sample
- `live_process`, `live_messages`, `live_lines`, `live_record`: that stream's process, and what it says
"""
