# Everything runs in .venv, which is made on the first call; only Python 3.11+, pip and make needed.

PYTHON ?= python3
BIN := .venv/bin

help:
	@echo "make demo   run the case 'duct' and say where its report is"
	@echo "make test   style, import contracts and tests, as CI does"
	@echo "make slow   the long tests, which 'make test' leaves out"
	@echo "make lint   style and import contracts alone"
	@echo "make clean  remove .venv, caches and what was built; runs/ stays"

demo: .venv/installed
	$(BIN)/spm run duct

test: lint
	$(BIN)/python -m pytest -n 2 --dist loadfile

slow: .venv/installed-with-tests
	$(BIN)/python -m pytest -m slow

lint: .venv/installed-with-tests
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/lint-imports --no-logo

clean:
	rm -rf .venv build dist .pytest_cache .ruff_cache .hypothesis .import_linter_cache
	find . -name __pycache__ -prune -exec rm -rf {} +
	rm -rf src/*.egg-info

.venv/installed: pyproject.toml | .venv/made
	@echo "Installing into .venv ..."
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable .
	@touch $@

.venv/installed-with-tests: pyproject.toml | .venv/made
	@echo "Installing into .venv ..."
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[test]'
	@touch .venv/installed $@

.venv/made:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	{ echo "Python 3.11 or later is needed: make PYTHON=python3.12 ..."; exit 1; }
	$(PYTHON) -m venv .venv
	@touch $@

.PHONY: help demo test slow lint clean
