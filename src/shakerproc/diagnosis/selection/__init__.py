"""Held-out scores, nesting, calibrated probability, verdict, next test."""
