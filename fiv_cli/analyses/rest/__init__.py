"""Equilibria, their eigenvalues and critical parameters; the modes of a plate at rest."""
