# Two commands on a fresh machine: `make demo` and `make test`. Both live in .venv, which they make themselves.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt

.PHONY: demo test verify lint types contracts check bench clean help

help:
	@echo "make demo       compare the oracle, the network and baselines on built-in courses; writes demo/report.html"
	@echo "make test       the fast tests"
	@echo "make verify     the fast oracle against the brute-force reference"
	@echo "make check      lint, types, import contracts"
	@echo "make bench      latency of every stage on this machine"

# A stamp per set of packages: a venv is filled again only if what it should hold has changed.
$(BIN)/python:
	$(PYTHON) -c 'import sys; v = sys.version_info; sys.exit(0 if (3, 10) <= v[:2] else "footsel needs Python 3.10 or newer: make PYTHON=python3.11 ...")'
	$(PYTHON) -m venv $(VENV)

$(VENV)/demo.stamp: pyproject.toml constraints.txt | $(BIN)/python
	$(PIP) --editable '.[oracle,report,maps]'
	@touch $@

$(VENV)/dev.stamp: pyproject.toml constraints.txt | $(BIN)/python
	$(PIP) --editable '.[dev]'
	@touch $@ $(VENV)/demo.stamp

demo: $(VENV)/demo.stamp
	$(BIN)/footsel compare --selectors oracle cnn nominal terrain_only --poses 20 --jobs 2 --out demo
	@echo "report: $(CURDIR)/demo/report.html"

test: $(VENV)/dev.stamp
	$(BIN)/python -m pytest -m "not slow"

verify: $(VENV)/dev.stamp
	$(BIN)/python -m footsel.oracle.verification $(wildcard ../shared/maps/*.npz) --out verify.json

lint: $(VENV)/dev.stamp
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .

types: $(VENV)/dev.stamp
	$(BIN)/mypy

contracts: $(VENV)/dev.stamp
	$(BIN)/lint-imports

check: lint types contracts

bench: $(VENV)/demo.stamp
	$(BIN)/footsel bench --out bench.json

clean:
	rm -rf $(VENV) demo bench.json verify.json
