"""The motion in time."""
