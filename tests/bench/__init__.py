"""`make bench`: speed and memory as ratios, all sides measured in one run on the same logs."""
