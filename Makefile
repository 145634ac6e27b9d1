# Two commands matter: make demo, make test. Both set up .venv by themselves.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready

.PHONY: demo test quick check docs oldest benchmark verdicts fuzz blind chaos clean

$(READY): pyproject.toml
	@echo "Setting up $(VENV) with what pyproject.toml asks for: a minute or two, once."
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable ".[dev]"
	touch $@

demo: $(READY)  ## the main job on sample_data, then the hidden gap
	$(BIN)/shakerproc demo demo_output

test: $(READY) check  ## everything that CI runs
	$(BIN)/python -m pytest -n 2

quick: $(READY)  ## the edit loop
	$(BIN)/python -m pytest -m "not slow"

check: $(READY)  ## format, lint, types, rooms, the manual
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/mkdocs build --strict --quiet

docs: $(READY)  ## the manual, to read: build/site/index.html
	$(BIN)/mkdocs build --strict

oldest:  ## the quick tests on the oldest versions that pyproject.toml allows, in build/oldest
	$(PYTHON) -m tests.oldest

benchmark: $(READY)  ## ratios of speed and memory, each within one run
	$(BIN)/python -m benchmarks

verdicts: $(READY)  ## every study and statement of the thesis, judged in both places
	$(BIN)/python -m benchmarks.verdicts

chaos: $(READY)  ## kill a batch 500 times at random moments, resume, compare every output
	$(BIN)/python -m tests.batch.chaos 500

fuzz: $(READY)  ## damage a hundred thousand recordings, print what became of them
	$(BIN)/python -m tests.fuzz --workers 2

blind: $(READY)  ## hidden campaigns from a truth of its own, diagnosed and scored; BLIND="--seed 100000 --each 4"
	$(BIN)/python -m blind $(BLIND)

clean:
	rm -rf $(VENV) demo_output build dist
