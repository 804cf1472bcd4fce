# Every target does its own set-up in .venv; a machine needs Python 3.11 to 3.13, make and pip.
PYTHON ?= python3
BIN := .venv/bin
STAMP := .venv/.installed
DEMO := outputs/demo

.PHONY: help setup test lint demo bench bench-full clean distclean

help:
	@echo "make setup      install the package and its tools into .venv"
	@echo "make test       lint, types and tests"
	@echo "make lint       lint and types only"
	@echo "make demo       recover the conductivity of the bracket and predict a held-out run"
	@echo "make bench      time the solver beside a SciPy loop (bench-full: large bodies as well)"
	@echo "make clean      remove outputs and caches (distclean: .venv as well)"

setup: $(STAMP)

# Runs once for each change of the requirements.
$(STAMP): pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; v = sys.version_info[:2]; ok = (3, 11) <= v <= (3, 13); sys.exit(0 if ok else "Python 3.11 to 3.13 is needed, found %d.%d: make PYTHON=python3.12" % v)'
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet -c constraints.txt -e '.[dev]'
	@touch $@

lint: $(STAMP)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/pyright

test: lint
	$(BIN)/python -m pytest -q -n 2 --dist loadfile --durations=30

demo: $(STAMP)
	$(BIN)/thermo invert data=examples/bracket 'unknown=[conductivity]' field=two_materials \
		optimiser=lm out=$(DEMO)/invert
	$(BIN)/thermo predict data=examples/bracket estimate=$(DEMO)/invert 'runs=[test_heating]' out=$(DEMO)/predict
	@echo "Pictures:"
	@find $(DEMO)/invert $(DEMO)/predict -name '*.png' | sort | sed 's/^/  /'

bench: $(STAMP)
	$(BIN)/python benchmarks/speed/run.py

bench-full: $(STAMP)
	$(BIN)/python benchmarks/speed/run.py --full

clean:
	rm -rf outputs multirun build dist .pytest_cache .ruff_cache .hypothesis
	find src tests examples -name __pycache__ -type d -prune -exec rm -rf {} +

distclean: clean
	rm -rf .venv
