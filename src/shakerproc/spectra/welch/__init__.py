"""Spectra by averaging segments (Welch), and what they add up to."""
