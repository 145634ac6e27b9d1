"""Free-run simulation and least squares: one residual function, parameters, intervals."""
