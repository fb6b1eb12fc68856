# d3pg: two commands do everything, set-up included. Times are those of two quiet cores; the first
# command of a kind adds its set-up: a minute or two for .venv, one for what the tests need.
#
#   make demo        start the service, a local Ray and a small sweep; Ctrl-C stops it   1 min
#   make test        every check and every test: check, fast, cluster, browser           14 min
#
#   make check       format, lint, types, import contracts: 8 s; 60 s without caches
#   make fast        the tests that need neither Ray nor a browser                       8 min
#   make cluster     the tests with a real local Ray                                     2 min
#   make browser     the tests in a real Chromium                                        4 min
#   make test-slow   the tests that learn whole curves and kill whole clusters           an hour
#
#   make containers  build the image and run docker/compose.yml in containers (root)     20 min
#                    D3PG_CONTAINERS=folder keeps the images for the next time
#   make docs        build the documentation and serve it at http://127.0.0.1:8001       10 s
#   make bench       speed beside peers (installs them)                                  an hour
#   make figures     the figures to hold, as a table: goal, measured, held               two hours
#   make paper       the paper's evaluation; goes on where it was stopped                12 core-hours
#   make format      format the code and mend what the linter can                        1 s
#   make clean       remove .venv and all caches but those in the home folder            1 s

PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
# Python compiles each module as it is first imported: most of what is installed never is.
PIP    := $(BIN)/python -m pip install --quiet --no-compile --disable-pip-version-check
PYTEST := $(BIN)/python -m pytest --durations 40
CORES  ?= $(shell nproc)
# A file's tests stay together where they share its fixtures; the long ones are collected first.
SHARED := -n $(CORES) --dist loadfile --no-loadscope-reorder
# npm trusts whom the machine trusts: a network may have a certificate authority of its own.
NODE   := NODE_OPTIONS=--use-system-ca PATH="$(CURDIR)/web/node_modules/.bin:$(CURDIR)/$(BIN):$$PATH"
SUDO   := $(shell test "$$(id -u)" = 0 || echo sudo)

.DEFAULT_GOAL := help
.PHONY: help demo paper test test-slow check postgresql fast cluster browser containers docs bench figures format clean

help:
	@sed -n 's/^#   \(make .*\)/\1/p; s/^#$$//p' Makefile

# torch goes first and alone: its CPU build is what everything else must find already there.
$(VENV)/installed: pyproject.toml hatch_build.py
	@$(PYTHON) -c 'import sys; v = sys.version_info[:2]; v >= (3, 11) or sys.exit("d3pg needs Python 3.11 or newer; this is %d.%d. Name another: make PYTHON=python3.12 ..." % v)'
	@echo "== Setting up $(VENV) (once; a few minutes)"
	@test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	@echo "   torch, CPU build"; $(PIP) 'torch~=2.13.0'
	@echo "   d3pg and what it needs"; $(PIP) --editable .
	@touch $@

$(VENV)/installed-dev: $(VENV)/installed
	@echo "== Installing what the tests need"
	@$(PIP) --editable '.[dev]'
	@# Alone: moviepy, which Gymnasium's RecordVideo writes with, asks for an older Pillow and does
	@# not need it here.
	@$(PIP) --no-deps 'moviepy~=2.2.1'
	@touch $@

# Node comes as a wheel and is for development only: no page needs it, and no user.
web/node_modules/.package-lock.json: web/package.json web/package-lock.json $(VENV)/installed-dev
	@echo "== Installing what checks the page's scripts"
	@cd web && $(NODE) npm ci --loglevel error >/dev/null
	@touch $@

# The answers of the API as TypeScript, of the code as it is.
web/types/api.d.ts: web/node_modules/.package-lock.json $(shell find service workers/messages -name '*.py')
	@$(BIN)/python -m tests.web.openapi_document >$(VENV)/openapi.json
	@cd web && $(NODE) openapi-typescript $(CURDIR)/$(VENV)/openapi.json --output types/api.d.ts >/dev/null

$(VENV)/installed-peers: $(VENV)/installed-dev
	@echo "== Installing the peers of the benchmarks"
	@$(PIP) --editable '.[dev,peers]'
	@# Alone: gymnax asks for an older Gymnasium, flax for checkpoints and another event loop, and
	@# neither needs them here.
	@$(PIP) --no-deps 'gymnax~=1.0.1' 'flax~=0.12.8'
	@touch $@

demo: $(VENV)/installed
	@$(BIN)/d3pg demo

paper: $(VENV)/installed
	@$(BIN)/d3pg paper

test: check fast cluster browser

check: $(VENV)/installed-dev web/types/api.d.ts
	@echo "== Format, lint, types, import contracts"
	@$(BIN)/ruff format --check .
	@$(BIN)/ruff check .
	@$(BIN)/mypy --num-workers $(CORES)
	@PATH="$(CURDIR)/$(BIN):$$PATH" $(BIN)/lint-imports
	@cd web && $(NODE) tsc --project .
	@cd web && $(NODE) oxlint --deny-warnings .

postgresql:
	@ls /usr/lib/postgresql/*/bin/initdb >/dev/null 2>&1 || { echo "   installing Debian's postgresql"; \
	  $(SUDO) apt-get update -qq && $(SUDO) apt-get install -y -qq postgresql >/dev/null; }

fast: $(VENV)/installed-dev postgresql
	@echo "== Tests: fast"
	@$(PYTEST) $(SHARED) -m "not slow and not cluster and not browser"

cluster: $(VENV)/installed-dev postgresql
	@echo "== Tests: with a real local Ray"
	@$(PYTEST) $(SHARED) -m "cluster and not slow" tests/end_to_end tests/workers

browser: $(VENV)/installed-dev
	@echo "== Tests: in a real Chromium"
	@command -v chromium >/dev/null || { echo "   installing Debian's chromium"; \
	  $(SUDO) apt-get update -qq && $(SUDO) apt-get install -y -qq chromium >/dev/null; }
	@$(PYTEST) -n $(CORES) --dist worksteal -m "browser and not slow" tests/web

test-slow: $(VENV)/installed-dev postgresql
	@echo "== Tests: slow (minutes)"
	@$(PYTEST) -m slow --timeout 3600

# Of Debian's packages; podman-compose of Debian 12 is too old for the file.
containers: $(VENV)/installed-dev
	@echo "== Tests: in containers"
	@command -v podman runc debootstrap >/dev/null || { echo "   installing Debian's podman"; \
	  $(SUDO) apt-get update -qq && $(SUDO) apt-get install -y -qq --no-install-recommends \
	    podman runc debootstrap catatonit netavark aardvark-dns iptables >/dev/null; }
	@$(PIP) 'podman-compose~=1.6.0'
	@$(PYTEST) -s -m slow --timeout 3600 tests/docker/test_containers.py

# Material for MkDocs names its successors at every build unless told not to.
docs: export NO_MKDOCS_2_WARNING = 1
docs: $(VENV)/installed-dev
	@$(BIN)/python -m mkdocs serve

figures: $(VENV)/installed-dev postgresql
	@$(BIN)/python -m benchmarks.held

bench: $(VENV)/installed-peers postgresql
	@for name in $$(basename -s .py -a benchmarks/[a-z]*.py); do \
	  echo "== $$name"; $(BIN)/python -m benchmarks.$$name || exit 1; done

format: $(VENV)/installed-dev
	@$(BIN)/ruff format .
	@$(BIN)/ruff check --fix .

clean:
	rm -rf $(VENV) web/node_modules web/types/api.d.ts web/static/vendor .mypy_cache .ruff_cache .pytest_cache .hypothesis .import_linter_cache
