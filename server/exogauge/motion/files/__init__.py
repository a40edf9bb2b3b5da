"""Files of captured motion, each in its own reader; `open_motion` knows them by what they hold."""

from exogauge.motion.files.open import open_motion

__all__ = ["open_motion"]
