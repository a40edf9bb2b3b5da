"""Solvers that know no robot: statistics of linear rows, priors and covariances."""
