"""Nodes, lines and surfaces of a structure, and the data sets of universal files with them."""

from shakerproc.geometry.wireframe import Axes, Place, Wireframe

__all__ = ["Axes", "Place", "Wireframe"]
