"""Blows of a hammer: found, judged and windowed."""
