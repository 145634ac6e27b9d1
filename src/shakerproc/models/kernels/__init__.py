"""Compiled laws: the force of a table row, and memory carried along a prescribed motion."""
