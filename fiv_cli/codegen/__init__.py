"""From symbolic model and law to machine code."""

NUMERICS_VERSION = 23  # raised whenever generated code gives other numbers for the same equations
