# Two commands on a fresh machine: `make demo` and `make test`. Both live in .venv, which they make themselves.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
# Maps made by others, if they are there; the oracle is verified on them as well.
MAPS := $(wildcard ../shared/maps/*.npz)
PIP := $(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt

# A release tarball of onnxruntime, unpacked; without one, a folder like it is made from packages.
ONNXRUNTIME_ROOT ?= build/onnxruntime

.PHONY: cpp demo test test-slow verify verify-pybullet verify-meshes lint types contracts check bench bench-full clean help

help:
	@echo "make demo       compare the oracle, the network and baselines on built-in courses; writes demo/report.html"
	@echo "make test       the fast tests"
	@echo "make test-slow  what takes minutes: a million calls, the wheel where there was nothing"
	@echo "make verify     the fast oracle against the brute-force reference (some 20 minutes; killed, it goes on later)"
	@echo "make verify-pybullet, make verify-meshes   its collisions against PyBullet's contacts, against full meshes"
	@echo "make check      lint, types, import contracts"
	@echo "make bench      latency of every stage on this machine"
	@echo "make bench-full the same with torch, C++ and 100,000 calls, for our pages (half an hour; killed, it goes on)"
	@echo "make cpp        the C++ library's programs, in build/cpp (ONNXRUNTIME_ROOT=... for an onnxruntime of your own)"

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
	$(BIN)/footsel compare --selectors oracle cnn nominal terrain_only --poses 100 --jobs 2 --out demo
	@echo "report: $(CURDIR)/demo/report.html"

test: $(VENV)/dev.stamp
	$(BIN)/python -m pytest -m "not slow"

test-slow: $(VENV)/dev.stamp
	$(BIN)/python -m pytest -m slow

verify: $(VENV)/dev.stamp
	$(BIN)/python -m footsel.oracle.verification $(MAPS) --out verify.json

verify-pybullet: $(VENV)/dev.stamp
	$(BIN)/python -m footsel.walking.cross_check contacts $(MAPS) --out verify-pybullet.json

verify-meshes: $(VENV)/dev.stamp
	$(BIN)/python -m footsel.walking.cross_check meshes $(MAPS) --cells 250 --out verify-meshes.json

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

bench-full: $(VENV)/dev.stamp cpp
	$(BIN)/footsel bench --run export/anymal_b --histogram 100000 --plot docs/figures/latency.png --out docs/results/bench.json
	$(BIN)/python docs/update_tables.py

# Asked every time: it sees itself whether it is complete.
.PHONY: build/onnxruntime
build/onnxruntime: $(VENV)/demo.stamp
	$(BIN)/python deploy/cpp/fetch_onnxruntime.py $@

cpp: $(ONNXRUNTIME_ROOT)
	cmake -S deploy/cpp -B build/cpp -DONNXRUNTIME_ROOT=$(abspath $(ONNXRUNTIME_ROOT))
	cmake --build build/cpp
	cmake --install build/cpp --prefix build/cpp/installed

clean:
	rm -rf $(VENV) build demo bench.json verify.json verify.json.parts verify-pybullet.json verify-meshes.json
