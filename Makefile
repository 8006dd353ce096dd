# make demo    grow two textures into demo/
# make test    lint, types and all tests
# Needs Python 3.11 or newer and make; everything else goes into .venv.

CANDIDATES := python3 python3.14 python3.13 python3.12 python3.11 python
NEW_ENOUGH := import sys; sys.exit(sys.version_info < (3, 11))
ifndef PYTHON
PYTHON := $(shell for p in $(CANDIDATES); do if $$p -c '$(NEW_ENOUGH)' >/dev/null 2>&1; then echo $$p; break; fi; done)
endif

VENV := .venv
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip --disable-pip-version-check --quiet
WORKERS ?= 2

# numba keeps compiled kernels beside the source, so all test workers share what the warm-up has compiled.
QUIET_BLAS := OPENBLAS_NUM_THREADS=1

.PHONY: help demo test lint format bench pictures clean clean-all

help:
	@echo "make demo      grow a built-in colour exemplar and sample:brick to 1024x1024 into demo/"
	@echo "make test      check style and types, then run all tests"
	@echo "make lint      check style and types only"
	@echo "make format    put imports in order and repair what ruff can repair"
	@echo "make bench     measure speed and memory; writes bench/results.json"
	@echo "make pictures  remake the pictures of the documentation"
	@echo "make clean     remove what the others made; clean-all removes .venv, too"
	@echo "PYTHON=... chooses the Python for .venv (3.11 or newer), WORKERS=... the test processes (now $(WORKERS))"

$(BIN)/python:
	@test -n "$(PYTHON)" || { echo "intarsia needs Python 3.11 or newer, and none was found; install it, or name it: make PYTHON=/path/to/python3"; exit 1; }
	@$(PYTHON) -c '$(NEW_ENOUGH)' 2>/dev/null || { echo "intarsia needs Python 3.11 or newer, not $(PYTHON); name another: make PYTHON=/path/to/python3"; exit 1; }
	@$(PYTHON) -c 'import ensurepip, venv' 2>/dev/null || { echo "this Python cannot make environments; install the package python3-venv"; exit 1; }
	@echo "making $(VENV)"
	@$(PYTHON) -m venv $(VENV)

# A stamp remembers what is installed. An environment that somebody else made, or that was moved, is completed or remade.
$(VENV)/.intarsia-%: pyproject.toml | $(BIN)/python
	@if ! $(BIN)/python -c '$(NEW_ENOUGH)' 2>/dev/null || ! $(BIN)/python -m pip --version >/dev/null 2>&1; then \
		echo "making $(VENV) again"; rm -rf $(VENV); $(MAKE) --no-print-directory $(BIN)/python; fi
	@echo "installing intarsia and what it needs into $(VENV) (once)"
	@$(PIP) install -e '$(if $(filter dev,$*),.[dev],.)'
	@touch $@

# What an older stamp cannot know: that somebody removed or replaced a package since.
define complete
	@$(BIN)/python -c 'import click, intarsia, numba, numpy, PIL, rich, scipy, skimage, OpenImageIO $(1)' 2>/dev/null \
		|| { rm -f $(VENV)/.intarsia-*; $(MAKE) --no-print-directory $(VENV)/.intarsia-$(2); }
endef

demo: $(VENV)/.intarsia-run
	$(call complete,,run)
	@mkdir -p demo
	@$(BIN)/intarsia grow sample:stones -o demo/stones.png --size 1024 --force
	@$(BIN)/intarsia grow sample:brick -o demo/brick.png --size 1024 --force
	@echo "grown textures, 1024x1024 px:"
	@echo "  $(CURDIR)/demo/stones.png"
	@echo "  $(CURDIR)/demo/brick.png"

test: lint
	@$(QUIET_BLAS) $(BIN)/intarsia warm-up --quiet
	@$(QUIET_BLAS) $(BIN)/python -m pytest -q -n $(WORKERS)

lint: $(VENV)/.intarsia-dev
	$(call complete,$(comma) hypothesis$(comma) mypy$(comma) pytest$(comma) pytest_timeout$(comma) ruff$(comma) xdist,dev)
	@$(BIN)/ruff check src tests examples benchmarks docs
	@$(BIN)/mypy --no-error-summary

format: $(VENV)/.intarsia-dev
	@$(BIN)/ruff check --fix src tests examples benchmarks docs

bench: $(VENV)/.intarsia-dev
	@$(BIN)/python benchmarks/bench.py

pictures: $(VENV)/.intarsia-dev
	@$(BIN)/python docs/make_pictures.py

clean:
	@rm -rf demo bench dist .pytest_cache .mypy_cache .ruff_cache .hypothesis
	@find src tests examples benchmarks docs -name __pycache__ -type d -prune -exec rm -rf {} +

clean-all: clean
	@rm -rf $(VENV)

comma := ,
