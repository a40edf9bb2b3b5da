"""A human body fitted to captured motion: its proportions, where its markers sit, and its angles over time."""
