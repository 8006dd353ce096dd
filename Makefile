# make demo    grow two textures and a material into demo/
# make studio  open a page on this machine to see, grow, paint and keep
# make test    lint, types and tests
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
N ?= 1000

INTARSIA := $(BIN)/python -m intarsia

.PHONY: help demo studio test test-slow test-long check-plugins mutants lint format fuzz bench docs pictures tables clean clean-all

help:
	@echo "make demo      grow sample:stones, sample:tiles and the material sample:setts to 1024x1024 into demo/"
	@echo "make studio    open a page on this machine to see, grow, paint and keep; what is made lies in intarsia-studio/"
	@echo "make test      check style and types, then run the tests"
	@echo "make test-slow run the slow tests that make test leaves out (SHARE=3: a third of them, drawn by the commit)"
	@echo "make test-long run all that make test leaves out: the slow tests, and more cases of others"
	@echo "make check-plugins  try each plug-in inside its program, as far as this machine can have it (ONLY='gimp krita': some)"
	@echo "make mutants   break the code line by line, and see that the tests notice (RULES='axes cuts': some rows; SHARE=10: a tenth)"
	@echo "make lint      check style and types only"
	@echo "make format    put imports in order and repair what ruff can repair"
	@echo "make fuzz      try N=1000 mutated files of each format, hostile documents, kills and damaged caches (now N=$(N))"
	@echo "make bench     measure speed and memory; writes bench/results.json"
	@echo "make docs      build the documentation as a site in build/site, and check its links"
	@echo "make pictures  remake the pictures of the documentation"
	@echo "make tables    rewrite the tables of the documentation that follow from the code, and the drawing of its rooms"
	@echo "make clean     remove what the others made; clean-all removes .venv, too"
	@echo "PYTHON=... chooses the Python for .venv (3.11 or newer), WORKERS=... the test processes (now $(WORKERS))"

$(BIN)/python:
	@test -n "$(PYTHON)" || { echo "intarsia needs Python 3.11 or newer, and none was found; install it, or name it: make PYTHON=/path/to/python3"; exit 1; }
	@$(PYTHON) -c '$(NEW_ENOUGH)' 2>/dev/null || { echo "intarsia needs Python 3.11 or newer, not $(PYTHON); name another: make PYTHON=/path/to/python3"; exit 1; }
	@$(PYTHON) -c 'import ensurepip, venv' 2>/dev/null || { echo "this Python cannot make environments; install the package python3-venv"; exit 1; }
	@echo "making $(VENV)"
	@$(PYTHON) -m venv --clear $(VENV)

# Installing is remembered by a stamp for each set of packages.
$(VENV)/.installed-studio $(VENV)/.installed-dev: pyproject.toml | $(BIN)/python
	@$(BIN)/python -c '$(NEW_ENOUGH)' || { rm -rf $(VENV); $(MAKE) --no-print-directory $(BIN)/python; }
	@$(PIP) --version >/dev/null 2>&1 || $(BIN)/python -m ensurepip >/dev/null || { rm -rf $(VENV); $(MAKE) --no-print-directory $(BIN)/python; }
	@echo "installing intarsia and what it needs into $(VENV), once"
	@$(PIP) install -e '.[$(if $(findstring dev,$@),dev,studio)]'
	@touch $@ $(VENV)/.installed-studio

# A stamp cannot know that the environment was moved, or that something was removed from it since.
define check
	@$(BIN)/python -c '$(HERE); import click, numba, numpy, OpenImageIO, PIL, rich, scipy, skimage' 2>/dev/null \
		|| { rm -f $(VENV)/.installed*; $(MAKE) --no-print-directory $(VENV)/.installed$(1); }
endef
HERE := import intarsia, os; assert os.path.samefile(os.path.dirname(intarsia.__file__), "src/intarsia")

demo: $(VENV)/.installed-studio
	$(call check,-studio)
	@mkdir -p demo
	@$(INTARSIA) grow sample:stones -o demo/stones.png --size 1024 --force
	@$(INTARSIA) grow sample:tiles -o demo/tiles.png --size 1024 --seed 1 --force
	@$(INTARSIA) grow sample:setts -o demo/setts.png --size 1024 --force
	@echo "grown from built-in exemplars, 1024x1024 px each:"
	@echo "  $(CURDIR)/demo/stones.png"
	@echo "  $(CURDIR)/demo/tiles.png"
	@echo "  $(CURDIR)/demo/setts.png, a material with setts_normal.png, setts_roughness.png and setts_height.png"

studio: $(VENV)/.installed-studio
	$(call check,-studio)
	@$(BIN)/python -c 'import python_multipart, starlette, uvicorn' 2>/dev/null \
		|| { rm -f $(VENV)/.installed-studio; $(MAKE) --no-print-directory $(VENV)/.installed-studio; }
	@$(INTARSIA) studio

test: lint
	@$(INTARSIA) warm-up --quiet
	@OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest -q -n $(WORKERS) --dist worksteal

test-slow: lint
	@$(INTARSIA) warm-up --quiet
	@OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest -q -n $(WORKERS) --dist worksteal -m 'slow and not long' \
		$(if $(SHARE),--share $(SHARE) --seed "$$(git rev-parse HEAD)")

test-long: lint
	@$(INTARSIA) warm-up --quiet
	@OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest -q -n $(WORKERS) --dist worksteal -m 'slow or long'

check-plugins: $(VENV)/.installed-dev
	$(call check,-dev)
	@$(BIN)/python tests/programs/check.py $(ONLY)

mutants: lint
	@WORKERS=$(WORKERS) $(BIN)/python tests/mutants.py $(RULES) $(if $(SHARE),--share $(SHARE)) $(if $(SEED),--seed $(SEED))

lint: $(VENV)/.installed-dev
	$(call check,-dev)
	@$(BIN)/python -c 'import axe_playwright_python, dask, distributed, httpx, hypothesis, mypy, playwright, pytest, pytest_timeout, python_multipart, ruff, starlette, tifffile, uvicorn, xdist, zarr' 2>/dev/null \
		|| { rm -f $(VENV)/.installed-dev; $(MAKE) --no-print-directory $(VENV)/.installed-dev; }
	@$(BIN)/python -m ruff check --quiet src tests examples benchmarks tools docs
	@$(BIN)/python -m mypy --no-error-summary

format: $(VENV)/.installed-dev
	@$(BIN)/python -m ruff check --fix src tests examples benchmarks tools docs

fuzz: $(VENV)/.installed-dev
	$(call check,-dev)
	@PYTHONPATH=tests $(BIN)/python -m hostile.fuzz --count $(N)

bench: $(VENV)/.installed-dev
	$(call check,-dev)
	@$(BIN)/python benchmarks/bench.py

$(VENV)/.installed-docs: pyproject.toml | $(BIN)/python
	@$(PIP) install -e '.[docs]'
	@touch $@

docs: $(VENV)/.installed-docs
	@NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build --quiet
	@echo "the site lies in build/site; open build/site/index.html"

pictures: $(VENV)/.installed-dev
	$(call check,-dev)
	@$(BIN)/python docs/make_pictures.py && $(BIN)/python docs/make_studio_pictures.py

tables: $(VENV)/.installed-dev
	$(call check,-dev)
	@$(BIN)/python docs/make_tables.py && $(BIN)/python docs/make_architecture.py

clean:
	@rm -rf build demo bench fuzz dist .mutants .pytest_cache .mypy_cache .ruff_cache .hypothesis
	@find src tests examples benchmarks tools docs -name __pycache__ -type d -prune -exec rm -rf {} +

clean-all: clean
	@rm -rf $(VENV)
