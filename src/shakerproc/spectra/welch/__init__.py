"""Spectra by averaging segments (Welch), and their sums."""
