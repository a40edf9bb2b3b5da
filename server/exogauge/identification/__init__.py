"""Section 3 of [Evaluator]: from logs and a robot with a-priori values to an identified robot with uncertainty."""
