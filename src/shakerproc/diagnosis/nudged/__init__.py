"""Identification by runs that are held to the measured motion by a rate that falls."""
