# `make crank` and `make test` work in a fresh clone: they create their own virtual environment in .venv.
PYTHON ?= python3
VENV   ?= .venv
BIN    := $(VENV)/bin
OUT    ?= out
# Test processes side by side; whole files stay together, because some share what they set up.
WORKERS ?= auto
PARALLEL := -n $(WORKERS) --dist loadfile
# One thread per process: the matrices are small, and test processes run side by side.
export OMP_NUM_THREADS ?= 1
export PIP_DISABLE_PIP_VERSION_CHECK := 1
# SymPy keeps the results of 1000 calls; tests that derive equations ask for more of them again.
export SYMPY_CACHE_SIZE ?= 100000
# Bytecode is kept: pytest rewrites its 200 files once, not in every worker of every run.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: crank test test-all test-matrix lint bench docs man fuzz clean

# A half-made environment (interrupted, or without pip) is made again; uv serves where Debian's python3-venv is missing.
define environment
	@if ! $(BIN)/python -m pip --version >/dev/null 2>&1; then \
	    $(PYTHON) -m venv --clear $(VENV) \
	    || { command -v uv >/dev/null && uv venv --quiet --seed --clear $(VENV); } \
	    || { echo "cannot make a virtual environment: install Python >= 3.10 with venv (Debian: python3-venv) or uv" >&2; exit 1; }; \
	fi
endef

# The C text of the engine and what it is generated from: an installation with another one builds it again.
ENGINE := hatch_build.py $(wildcard spacar/compiled/*.[ch]) $(wildcard spacar/compiled/generator/*.py) \
          $(wildcard spacar/elements/*_symbolic.py spacar/elements/*/*_symbolic.py) \
          spacar/elements/family.py spacar/elements/spatial/beam.py

$(VENV)/.installed: pyproject.toml $(ENGINE)
	$(environment)
	$(BIN)/python -m pip install --quiet -e .
	@-$(BIN)/python -m spacar.compiled
	@touch $@

$(VENV)/.installed-dev: pyproject.toml $(ENGINE)
	$(environment)
	$(BIN)/python -m pip install --quiet --no-compile -e '.[test,dev,symbolic,control]'
	@touch $@ $(VENV)/.installed

$(VENV)/.installed-docs: pyproject.toml $(ENGINE)
	$(environment)
	$(BIN)/python -m pip install --quiet -e '.[docs]'
	@touch $@ $(VENV)/.installed

crank: $(VENV)/.installed
	$(BIN)/spacar 1 data/crank.dat --output-dir $(OUT)
	$(BIN)/spacar draw $(OUT)/crank --at 1:6:42 --output $(OUT)/crank.png
	@echo "log: $(OUT)/crank.log  results: $(OUT)/crank.sbd  picture: $(OUT)/crank.png"

# mypy works beside the tests; what it finds fails the target
test: $(VENV)/.installed-dev
	$(BIN)/ruff check .
	@$(BIN)/mypy >$(VENV)/mypy.log 2>&1 & types=$$!; \
	$(BIN)/python -m pytest -m "not slow" $(PARALLEL) $(PYTEST); status=$$?; \
	wait $$types || { cat $(VENV)/mypy.log; status=1; }; exit $$status

test-all: lint
	$(BIN)/python -m pytest $(PARALLEL) $(PYTEST)

# oldest and newest versions, no engine, four BLAS kernels: see .ci/matrix
test-matrix: $(VENV)/.installed-dev
	.ci/matrix

lint: $(VENV)/.installed-dev
	$(BIN)/ruff check .
	$(BIN)/mypy

# Hours: 20,000 decks, 5,000 result files, every subcommand, 5,000 mechanisms, 200 kills; the report is out/fuzz.md. FUZZ="--decks 500" ...
fuzz: $(VENV)/.installed-dev
	$(BIN)/python -m tests.fuzz $(FUZZ)

# Beside other programs, where they are installed (pip install -e '.[peers]'), then our own cases. PEERS="--only S1b" ...
bench: $(VENV)/.installed-dev
	$(BIN)/python benchmarks/peers/compare.py $(PEERS)
	$(BIN)/python benchmarks/run.py

docs: $(VENV)/.installed-docs
	$(BIN)/sphinx-build -q -W -n --keep-going -c docs . $(OUT)/site
	@echo "pages: $(OUT)/site/index.html"

# the manual page spacar(1), which wheels install
man: $(VENV)/.installed
	$(BIN)/python -m spacar_cli.man_page > docs/man/spacar.1
	@echo "read it: man -l docs/man/spacar.1"

clean:
	rm -rf $(OUT) build dist wheels spacar/compiled/generated .pytest_cache .mypy_cache .ruff_cache .hypothesis
