"""Amplitudes over frequency: of a steady state, and over time of a motion that varies."""
