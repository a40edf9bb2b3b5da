"""What was identified, in the words of those who use it: models of robots, controllers of robots, tables."""
