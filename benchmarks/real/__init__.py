"""Real and published sets, judged as a user would: python -m benchmarks.real [SET...]."""
