"""What hangs on a wrist force/torque sensor: identified in two stages, then taken out of what the sensor reads."""
