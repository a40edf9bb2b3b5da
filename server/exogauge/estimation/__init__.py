"""Solvers that know no robot: statistics of linear rows, priors, covariances, and the `Estimate` they all return."""
