"""Makes the cases of the blind benchmark. Shares no code with what evaluates them."""
