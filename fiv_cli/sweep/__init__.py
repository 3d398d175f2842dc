"""Sweeps: plan, scheduler, journal, resume."""
