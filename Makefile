# make train | test | lint | kernels | docs | browse | links | bench | interop | matrix | soak | mutants: each makes
# .venv, installs what it needs, and runs; make rllib | rllib-test with Ray in .venv-rllib, as RLlib pins what we do not.
PYTHON ?= python3
BIN := .venv/bin
ARGS ?=
EXTRAS_train := train,render
RLLIB := .venv-rllib
RLLIB_PINS := tests/interop/requirements/rllib.txt
EXTRAS_dev := dev,docs

.PHONY: train test lint kernels docs browse links bench interop matrix soak mutants rllib rllib-test clean

train: .venv/train
	$(BIN)/coopenv train $(ARGS)

test: .venv/dev
	$(BIN)/python -m pytest -n 2 --dist worksteal $(ARGS)

lint: .venv/dev
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/pyright --pythonpath $(BIN)/python
	$(BIN)/lint-imports --no-cache

# What every process of the tests would else do for itself: kernels, and bytecode, rewritten assertions included.
kernels: .venv/dev
	$(BIN)/coopenv warmup
	found=$$(PYTHONDONTWRITEBYTECODE= $(BIN)/python -m pytest --collect-only --quiet) || { echo "$$found"; exit 1; }

docs: .venv/dev
	$(BIN)/python -m sphinx -q -W --keep-going -b html -c docs . build/site $(ARGS)

browse: docs  # a few seconds if nothing changed, then every page in chromium, where there is one
	$(BIN)/python -m pytest -m "slow or not slow" tests/docs/test_browser.py

links: .venv/dev  # out of the site; needs the net
	$(BIN)/python -m sphinx -q -b linkcheck -c docs . build/links $(ARGS)

bench: .venv/dev
	$(BIN)/python -m benchmarks $(ARGS)

interop: .venv/dev
	$(BIN)/python -m tests.interop $(ARGS)

soak: .venv/dev
	$(BIN)/python -m benchmarks.soak $(ARGS)

mutants: .venv/dev
	$(BIN)/python -m benchmarks.mutants $(ARGS)

matrix: .venv/dev
	$(BIN)/python -m benchmarks.matrix $(ARGS)

rllib: $(RLLIB)/ready
	$(RLLIB)/bin/python -m coopenv.agents.rllib $(ARGS)

rllib-test: $(RLLIB)/ready
	$(RLLIB)/bin/python -m pytest tests/agents/rllib tests/agents/experiments/nodes $(ARGS)

$(RLLIB)/ready: pyproject.toml $(RLLIB_PINS)
	test -x $(RLLIB)/bin/python || $(PYTHON) -m venv $(RLLIB)
	$(RLLIB)/bin/pip install --quiet --requirement $(RLLIB_PINS) --editable ".[train]" pytest hypothesis
	touch $@

# Bytecode is made on all cores, by pip it would be on one; some files of others are templates and no Python.
.venv/%: pyproject.toml constraints.txt
	test -x $(BIN)/python || $(PYTHON) -m venv .venv
	$(BIN)/pip install --quiet --no-compile --constraint constraints.txt --editable ".[$(EXTRAS_$*)]"
	$(BIN)/python -m compileall -qq -j 0 .venv/lib || true
	touch $@

clean:
	rm -rf .venv $(RLLIB) build dist *.egg-info runs
