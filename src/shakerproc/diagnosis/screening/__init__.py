"""Regression on the measured motion: a force without a name, as a table."""

from shakerproc.diagnosis.screening.outside import FreeLaw, free_laws

__all__ = ["FreeLaw", "free_laws"]
