"""How names, numbers and units are written in a case file and on the command line."""
