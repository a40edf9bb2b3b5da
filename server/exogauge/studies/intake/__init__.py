"""Files in: study, robot, device, logs and mappings, read and checked."""
