# Everything a newcomer needs: `make demo` and `make test`. The rest is for working on the project.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
NATIVE := $(shell find hil/core/native -name '*.[ch]' -o -name '*.def') hil/core/_native.pyx

.PHONY: demo test test-native lint wheel clean

demo: $(VENV)/.base
	@$(BIN)/hil serve examples/demo.yaml

test: $(VENV)/.dev
	@$(MAKE) --no-print-directory test-native
	$(BIN)/python -m pytest -q

# The C alone: no Python, under the address, undefined-behaviour and thread sanitizers.
test-native:
	$(MAKE) --no-print-directory -C hil/core/native/tests

lint: $(VENV)/.dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

wheel: $(VENV)/.dev
	$(BIN)/pip wheel -q --no-deps -w dist .

clean:
	rm -rf $(VENV) build dist *.egg-info hil/core/_native.c hil/core/*.so

$(VENV)/bin/python:
	$(PYTHON) -m venv $(VENV)

$(VENV)/.base: $(VENV)/bin/python pyproject.toml setup.py $(NATIVE)
	$(BIN)/pip install -q --disable-pip-version-check -e .
	@touch $@

$(VENV)/.dev: $(VENV)/bin/python pyproject.toml setup.py $(NATIVE)
	$(BIN)/pip install -q --disable-pip-version-check -e '.[dev]'
	@touch $@ $(VENV)/.base
