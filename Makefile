# Two commands for a fresh machine: `make demo` and `make test`. Both set up what they need in .venv.
PYTHON ?= $(shell command -v python3.11 || command -v python3)
BIN := .venv/bin

.PHONY: demo test lint peers schema compiler clean

demo: .venv/run.stamp
	$(BIN)/topple demo

test: .venv/dev.stamp
	$(BIN)/python -m pytest

lint: .venv/dev.stamp
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/pyright

# Other planners, for `topple bench motion` to run beside ours; each needs versions of its own.
peers: | compiler
	for name in mplib pybullet-planning; do \
	  $(PYTHON) -m venv .peers/$$name && .peers/$$name/bin/pip install --quiet $$name || exit 1; \
	done

# docs/plan.schema.json is what the structs of planner/plan_format.py say; a test holds it to that.
schema: .venv/dev.stamp
	$(BIN)/python -c 'import json; from topple.planner.plan_format import plan_schema; print(json.dumps(plan_schema(), indent=1))' > docs/plan.schema.json

# pybullet has wheels for CPython 3.11 on Linux x86-64 alone; anywhere else pip has to compile it.
compiler:
	@test -n "$(PYTHON)" || { echo "topple needs Python 3.11 or newer: install it, or name it with make PYTHON=/path/to/python3"; exit 1; }
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "topple needs Python 3.11 or newer, $(PYTHON) is older: name another with make PYTHON=/path/to/python3"; exit 1; }
	@$(PYTHON) -c 'import platform, sys; sys.exit((sys.version_info[:2], sys.platform, platform.machine()) != ((3, 11), "linux", "x86_64"))' \
	  || command -v c++ >/dev/null || { echo "pybullet has no wheel for this platform: install a C++ compiler (c++), or use CPython 3.11 on Linux x86-64"; exit 1; }

.venv/bin/python: | compiler
	$(PYTHON) -m venv .venv

.venv/run.stamp: .venv/bin/python pyproject.toml hatch_build.py
	$(BIN)/pip install --quiet --editable .
	@touch $@

.venv/dev.stamp: .venv/bin/python pyproject.toml hatch_build.py
	$(BIN)/pip install --quiet --editable '.[dev]'
	@touch $@ .venv/run.stamp

clean:
	rm -rf .venv .dev dist topple-demo .pytest_cache .ruff_cache .hypothesis
