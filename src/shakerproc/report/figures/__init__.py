"""Figures as data, drawn as SVG for the page and as PNG for files, in one style."""
