"""From symbolic model and law to machine code."""

NUMERICS_VERSION = 29  # raised whenever generated code gives other numbers for the same equations
