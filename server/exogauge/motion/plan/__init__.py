"""From what is asked of a robot to a motion that it can do: one trajectory, all bounds at once."""
