"""Models and laws from outside: files that the user names (``--with``), and installed packages."""
