"""What a start leads to, and where along a parameter that changes."""
