"""Timings (``make bench``). They are figures, not tests: nothing here passes or fails."""
