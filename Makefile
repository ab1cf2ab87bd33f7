# make train | test | lint | docs | bench | interop | matrix | soak | mutants: each makes .venv, installs
# what it needs, and runs.
PYTHON ?= python3
BIN := .venv/bin
ARGS ?=
EXTRAS_train := train,render
EXTRAS_dev := dev
EXTRAS_docs := dev,docs

.PHONY: train test lint docs bench interop matrix soak mutants clean

train: .venv/train
	$(BIN)/coopenv train $(ARGS)

test: .venv/dev
	$(BIN)/python -m pytest -n 2 $(ARGS)

lint: .venv/dev
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/pyright --pythonpath $(BIN)/python
	$(BIN)/lint-imports --no-cache

docs: .venv/docs
	$(BIN)/python -m sphinx -q -W --keep-going -b html -c docs . build/site $(ARGS)

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

.venv/%: pyproject.toml constraints.txt
	test -x $(BIN)/python || $(PYTHON) -m venv .venv
	$(BIN)/pip install --quiet --constraint constraints.txt --editable ".[$(EXTRAS_$*)]"
	touch $@

clean:
	rm -rf .venv build dist *.egg-info runs
