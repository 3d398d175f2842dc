"""fiv: a batch tool for friction-induced vibration (brake squeal, creep groan, stick-slip)."""

__version__ = "0.2.0.dev0"
