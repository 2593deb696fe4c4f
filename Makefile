# Every target starts from nothing: it makes .venv, installs into it, and writes nowhere else.
VENV := .venv
BIN := $(VENV)/bin
SOURCES := $(shell find primitives models exploration recognition -name '*.py' -o -name '*.toml')
export PIP_NO_CACHE_DIR := 1
export PIP_DISABLE_PIP_VERSION_CHECK := 1

.PHONY: demo test test-all bench soak faults lint docs site clean

demo: $(VENV)/.kernels
	$(BIN)/palpate explore block --out runs/demo --overwrite
	$(BIN)/palpate recognize runs/demo --library docs/library

test: $(VENV)/.dev $(VENV)/.kernels
	$(BIN)/python -m pytest -n 2 --dist worksteal -rs -m "not long"

test-all: $(VENV)/.dev $(VENV)/.kernels
	$(BIN)/python -m pytest -n 2 --dist worksteal -rs

bench: $(VENV)/.bench $(VENV)/.kernels
	$(BIN)/python tests/bench

soak: $(VENV)/.dev
	$(BIN)/python tests/bench/wire_soak.py 1000000

faults: $(VENV)/.dev
	$(BIN)/python tests/bench/fault_soak.py 200

lint: $(VENV)/.dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

docs: $(VENV)/.kernels
	$(BIN)/python docs/draw_parts.py
	$(BIN)/python docs/site/make_pages.py

site: $(VENV)/.docs
	NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build --quiet --strict --config-file docs/site/mkdocs.yml
	@echo "build/site/index.html"

clean:
	rm -rf $(VENV) build dist *.egg-info

$(VENV)/.made:
	@python=; for p in python3 python3.13 python3.12 python3.11; do \
	  if $$p -c 'import sys, venv, ensurepip; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 13))' 2>/dev/null; \
	  then python=$$p; break; fi; done; \
	if [ -z "$$python" ]; then \
	  echo "palpate needs Python 3.11, 3.12 or 3.13 with its venv module (Debian: apt-get install python3-venv)" >&2; \
	  exit 1; fi; \
	echo "making $(VENV) with $$($$python --version)"; $$python -m venv $(VENV)
	@touch $@

$(VENV)/.installed: pyproject.toml | $(VENV)/.made
	$(BIN)/python -m pip install --quiet -e .
	@touch $@

$(VENV)/.dev: pyproject.toml | $(VENV)/.installed
	$(BIN)/python -m pip install --quiet -e '.[dev]'
	@touch $@

$(VENV)/.docs: pyproject.toml | $(VENV)/.installed
	$(BIN)/python -m pip install --quiet -e '.[docs]'
	@touch $@

$(VENV)/.bench: pyproject.toml | $(VENV)/.dev
	$(BIN)/python -m pip install --quiet -e '.[dev,bench]'
	@touch $@

# All of these at once: every call of pip resolves and builds anew.
$(VENV)/.everything: pyproject.toml | $(VENV)/.made
	$(BIN)/python -m pip install --quiet -e '.[dev,docs]'
	@touch $(VENV)/.installed $(VENV)/.dev $(VENV)/.docs $@

$(VENV)/.kernels: $(SOURCES) | $(VENV)/.installed
	$(BIN)/python -m compileall -q primitives models exploration recognition
	$(BIN)/python -m recognition.warm
	@touch $@
