"""Datasets: the table of variables, shards, assembly, NetCDF, comparison."""
