"""Periodic orbits, stable or not, and the branches they lie on."""
