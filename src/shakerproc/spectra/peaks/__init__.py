"""Peaks of spectra and response functions, and their damping."""
