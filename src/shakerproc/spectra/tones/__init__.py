"""Tones and sweeps: amplitude and phase against frequency, time or speed."""
