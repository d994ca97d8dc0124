# Every target sets up what it needs in .venv; Python >= 3.11 with venv, a C++20 compiler and make
# are all that must be there.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip --disable-pip-version-check --quiet
export PATH := $(CURDIR)/$(BIN):$(PATH)

SOURCES := pyproject.toml CMakeLists.txt constraints.txt \
  $(shell find core/include bindings python scenarios studies vehicles -type f -not -name '*.pyc')
CXX_FILES := $(shell find core bindings -name '*.hpp' -o -name '*.cpp')

.PHONY: help reproduce test test-ray test-drake fuzz lint format bench bench-growth \
  bench-vehicles bench-study campaign campaign-sample test-flights docs wheel clean

help:
	@echo "make reproduce   the paper's tests: figures, data, report in out/paper"
	@echo "make test        all tests"
	@echo "make test-ray    studies on a Ray cluster of two nodes, one of which is killed"
	@echo "make test-drake  flights against a second multibody engine, Drake"
	@echo "make test-flights  the paper's experiments, flown through all wires"
	@echo "make campaign    three hundred flights with faults; campaign-sample: twenty"
	@echo "make fuzz        millions of messages and files that nobody should send or write"
	@echo "make lint        ruff, mypy, clang-format"
	@echo "make format      let ruff and clang-format mend what they can"
	@echo "make bench       speed, as ratios in one run"
	@echo "make bench-growth  time and memory from one world to a million: half an hour"
	@echo "make bench-vehicles  time a step from two vehicles to 64"
	@echo "make bench-study   a hundred thousand worlds, from the command to the report"
	@echo "make docs        the documentation as web pages in docs/_build/html"
	@echo "make wheel       a wheel in dist/, tried in an environment of its own"
	@echo "make clean       remove everything that make made"

# The build tools live in the environment too, so that builds are incremental and need no network
# once it stands.
$(VENV)/.tools: constraints.txt
	@test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	@echo "setting up $(VENV) ..."
	@$(PIP) install -c constraints.txt scikit-build-core nanobind cmake ninja
	@touch $@

# $(VENV)/.with-EXTRA: the package with one of its extras, as people install it.
$(VENV)/.with-%: $(VENV)/.tools $(SOURCES)
	@echo "building and installing multilift[$*] ..."
	@$(PIP) install -c constraints.txt --no-build-isolation ".[$*]"
	@touch $@

reproduce: $(VENV)/.with-all
	$(BIN)/multilift reproduce -o out/paper --force

test: $(VENV)/.with-test
	$(BIN)/python -m pytest -n 2

test-ray: $(VENV)/.with-test $(VENV)/.with-ray
	$(BIN)/python -m pytest tests/test_study_ray.py

test-drake: $(VENV)/.with-test $(VENV)/.with-drake
	$(BIN)/python -m pytest tests/test_spatial_drake.py

test-flights: $(VENV)/.with-test
	MULTILIFT_ALL_FLIGHTS=1 $(BIN)/python -m pytest -n 2 tests/test_flight_claims.py

campaign: $(VENV)/.with-test
	mkdir -p out
	$(BIN)/python -m multilift.flight.campaign --jobs 2 --output out/campaign.csv

campaign-sample: $(VENV)/.with-test
	$(BIN)/python -m multilift.flight.campaign --flights 20 --jobs 2

fuzz: $(VENV)/.with-test
	$(BIN)/python tests/rt_fuzz.py
	$(BIN)/python tests/fuzz_sitl.py 5000000 1
	$(BIN)/python tests/fuzz_lab.py 2000000 1

lint: $(VENV)/.with-test $(VENV)/.with-lint
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/clang-format --dry-run --Werror $(CXX_FILES)

format: $(VENV)/.with-test $(VENV)/.with-lint
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .
	$(BIN)/clang-format -i $(CXX_FILES)
	$(BIN)/python -m nanobind.stubgen -q -m multilift._core -o python/multilift/_core.pyi

bench: $(VENV)/.with-test
	$(BIN)/python benchmarks/bench.py

bench-growth: $(VENV)/.with-test
	$(BIN)/python benchmarks/growth.py

bench-vehicles: $(VENV)/.with-test
	$(BIN)/python benchmarks/vehicles.py

bench-study: $(VENV)/.with-test
	$(BIN)/multilift study benchmarks/sim1_many.toml -o out/sim1_many --force

docs: $(VENV)/.with-docs
	$(BIN)/sphinx-build -W -n -q -b html docs docs/_build/html
	@echo "docs/_build/html/index.html"

wheel: $(VENV)/.tools
	@$(PIP) install -c constraints.txt build
	$(BIN)/python -m build --no-isolation --outdir dist .
	rm -rf build/wheel-check && $(PYTHON) -m venv build/wheel-check
	build/wheel-check/bin/pip install -q -c constraints.txt "$$(ls -t dist/*.whl | head -n 1)[report]"
	cd build && wheel-check/bin/multilift reproduce -o wheel-check/paper

clean:
	rm -rf $(VENV) build dist out docs/_build docs/generated
