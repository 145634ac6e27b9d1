"""Tests of shakerproc; a package, so that no other one called tests stands before it."""
