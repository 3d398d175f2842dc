"""From symbolic model and law to machine code."""

NUMERICS_VERSION = 30  # raised whenever generated code gives other numbers for the same equations
