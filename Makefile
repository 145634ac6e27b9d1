# Two commands matter: make demo, make test. Both set up .venv by themselves.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
CORE := $(VENV)/.core
READY := $(VENV)/.ready
PIP := $(BIN)/python -m pip install --quiet --disable-pip-version-check
UV := $(BIN)/uv pip
# where it is set, each of some hundred processes of the tests compiles every module anew
unexport PYTHONDONTWRITEBYTECODE

.PHONY: demo test tests quick long check check_code lint types laws runs more docs oldest benchmark verdicts fuzz
.PHONY: blind chaos healthy real clean

# uv takes a fifth of the time of pip, which does where uv cannot be had or reach anything; the demo
# needs the core alone, and what the tests need besides is chosen when they ask for it: a third less
$(CORE): pyproject.toml
	@echo "Setting up $(VENV) with what pyproject.toml asks for: a minute or two, once."
	$(PYTHON) -m venv $(VENV)
	$(PIP) uv && $(UV) install --quiet --python $(BIN)/python --editable . \
		|| $(PIP) --no-compile --editable ".[dev]"
	touch $@

$(READY): $(CORE)
	$(UV) install --quiet --python $(BIN)/python --editable ".[dev]" \
		|| $(PIP) --no-compile --editable ".[dev]"
	touch $@

demo: $(CORE)  ## the main job on sample_data, then the hidden gap
	$(BIN)/shakerproc demo demo_output

# what is compiled first needs the core alone, so the rest is installed beside it; types and form are
# looked at while tests wait for files and processes. One file of tests is one process's, in the order
# of their names: no fixture is made twice, and what takes long does not come last; linear algebra
# of two processes on two cores takes one thread each
test:  ## everything that CI runs; the manual is built by a test
	$(MAKE) --no-print-directory --jobs 3 laws runs more
	$(MAKE) --no-print-directory --jobs 2 tests check_code

tests: $(READY)
	OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest -n 2 --dist loadfile --no-loadscope-reorder

check_code: types lint

quick: $(READY)  ## the edit loop
	$(BIN)/python -m pytest -m "not slow"

long: $(READY)  ## the tests that take minutes each, which make test leaves out
	$(BIN)/python -m pytest -m long

check: lint types  ## format, lint, rooms, types, the manual
	$(BIN)/mkdocs build --strict --quiet

lint: $(READY)
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/lint-imports

types: $(READY)
	$(BIN)/mypy

laws runs: $(CORE)  ## compiled once, before two processes of the tests would both do so
	$(BIN)/python -m tests.kernels $@

more: $(READY) laws runs  ## the same for what only tests need
	$(BIN)/python -m tests.kernels $@

docs: $(READY)  ## the manual, to read: build/site/index.html
	$(BIN)/mkdocs build --strict

oldest:  ## the quick tests on the oldest versions that pyproject.toml allows, in build/oldest
	$(PYTHON) -m tests.oldest

benchmark: $(READY)  ## ratios of speed and memory, each within one run
	$(BIN)/python -m benchmarks

verdicts: $(READY)  ## every study and statement of the thesis, judged in both places
	$(BIN)/python -m benchmarks.verdicts

chaos: $(READY)  ## kill a batch 500 times and a watch 20 times; 200 batches whose recordings are exchanged
	$(BIN)/python -m tests.campaign.chaos 500
	$(BIN)/python -m tests.campaign.watched 20
	$(BIN)/python -m tests.campaign.exchanges 200

fuzz: $(READY)  ## damage 850,000 recordings, print what became of them (forty minutes); FUZZ="--share 1/7"
	$(BIN)/python -m tests.fuzz --workers 2 $(FUZZ)

healthy: $(READY)  ## 500 healthy runs without a flag, 100 of each dead channel found
	$(BIN)/python -m tests.recordings.healthy 500

blind: $(READY)  ## hidden campaigns from a truth of its own, scored: all that a frozen commit is asked; BLIND="--classes gap*2"
	$(BIN)/python -m blind --classes frozen --seed 400000 $(BLIND)

real: $(READY)  ## real and published sets of ../shared/data: the whole loop, a line each; REAL="emps"
	$(BIN)/python -m benchmarks.real $(REAL)

clean:
	rm -rf $(VENV) demo_output build dist
