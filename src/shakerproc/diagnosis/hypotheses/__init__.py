"""Hypotheses from the effects' own identification data."""
