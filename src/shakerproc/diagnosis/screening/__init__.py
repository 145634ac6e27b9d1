"""Regression on the measured motion: where to start, and what need not be tried."""
