# fiv: from a fresh clone, `make demo` and `make test` need nothing but Python 3.11 and make.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
INSTALLED := $(VENV)/.installed
DEMO := configs/ch7/fig_7_06_reached.toml
CASES = $(wildcard configs/ch*/*.toml configs/own/*.toml)
WORKERS ?= 2

export MPLCONFIGDIR ?= $(CURDIR)/$(VENV)/matplotlib

.DEFAULT_GOAL := help
.PHONY: help demo install test test-all lint regress bench figures clean

help:  ## this list
	@awk -F':.*## ' '/^[a-z-]+:.*## /{printf "  make %-9s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

$(INSTALLED): pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and \
		"fiv needs Python 3.11 or newer, not " + sys.version.split()[0] + \
		"; next: make PYTHON=/path/to/python3.11")'
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[dev]'
	@touch $(INSTALLED)

install: $(INSTALLED)  ## the virtual environment .venv with fiv and its development tools

demo: $(INSTALLED)  ## the main job: the (Omega, N0) map of Figure 7.6 and its figure
	$(BIN)/fiv run --workers $(WORKERS) $(DEMO)
	$(BIN)/fiv show runs/fig_7_06_reached.nc
	$(BIN)/fiv plot runs/fig_7_06_reached.nc -o runs/fig_7_06_reached.png
	@echo "dataset: runs/fig_7_06_reached.nc    figure: runs/fig_7_06_reached.png"

test: $(INSTALLED)  ## the tests, about 10 minutes on two cores
	$(BIN)/python -m pytest -n 2 --dist loadfile

test-all: $(INSTALLED)  ## the tests and the long campaigns
	$(BIN)/python -m pytest -n 2 --dist loadfile -m "campaign or not campaign"

lint: $(INSTALLED)  ## ruff (lint, format) and mypy
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

regress: $(INSTALLED)  ## the regression sweeps of sweeps/ against their reference datasets
	$(BIN)/fiv regress --workers $(WORKERS) sweeps

bench: $(INSTALLED)  ## timings, side by side with SciPy (not a test)
	$(BIN)/python -m tests.benchmarks

figures: $(INSTALLED)  ## every case of configs/ and its figures, into runs/
	$(BIN)/fiv run --workers $(WORKERS) --with configs/own $(CASES)
	@for case in $(CASES); do \
		$(BIN)/fiv plot runs/$$(basename $$case .toml).nc || exit $$?; \
	done

clean:  ## remove the virtual environment, runs/ and caches of tools
	rm -rf $(VENV) runs build .pytest_cache .mypy_cache .ruff_cache .hypothesis *.egg-info
