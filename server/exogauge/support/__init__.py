"""Supporting torque of a worn device: with minus without it on the same motion (A), model minus measurement (B)."""
