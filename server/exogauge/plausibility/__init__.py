"""What was measured against what the robot's description leads one to expect, before anything is identified."""
