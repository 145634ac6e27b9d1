"""Trends over tests, and the changes since an earlier campaign."""
