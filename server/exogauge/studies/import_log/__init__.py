"""Drafts, by looking: of a mapping for a foreign log, what its columns may be; of a robot.yaml for a URDF."""
