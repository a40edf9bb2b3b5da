"""One search over one problem: screen candidates, refine, validate, add, prune, correct.

- `state`: what it has come to
- `candidates`, `site_rows`, `baseline`, `sums`, `partial`: what is tried, beside what
- `score`, `refine`, `best_shapes`, `locate`: how much each gains, with which shape, where
- `judge`, `from_log_on`, `noise_taken`, `creeping`: what held-out logs, each log and the noise say of it
- `search`, `taken_out`: add, identify again, take back
- `afterwards`, `residual_correction`, `final_numbers`, `doubt`: shapes once more, curves, numbers beside all else
- `declared`: what is left, and declared doubts of the measurement explain
- `ambiguity`, `finding`: what cannot be told apart, and what is said
"""
