# Three commands for a fresh machine: `make install`, `make demo` and `make test` set up what they need in .venv.
# `make test` leaves out the tests marked slow, `make test-all` runs every one.
PYTHON ?= $(shell command -v python3.11 || command -v python3.10 || command -v python3.12 || command -v python3.13 || command -v python3)
BIN := .venv/bin
KERNELS := $(wildcard topology/kernels/*.?pp) topology/kernels/build.py
# One process a core, each with one thread: more threads in each would take the cores from the other. The tests of
# a file stay in one process, which makes their fixtures once.
TESTS := OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest -n 2 --dist loadfile --no-loadscope-reorder

.PHONY: install demo test test-all lint truth docs figures peers schema film python clean

install: .venv/run.stamp

demo: .venv/run.stamp
	$(BIN)/topple demo

test: .venv/dev.stamp
	$(TESTS) -m "not slow"

test-all: .venv/dev.stamp
	$(TESTS)

lint: .venv/dev.stamp
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/codespell
	$(BIN)/python .ci/prose.py
	$(BIN)/ty check

# Whether this tree tells less of the truth than the commit that changes are held against; goes on where it was stopped.
REFERENCE ?= f263487
truth: .venv/dev.stamp
	$(BIN)/topple bench truth --against $(REFERENCE)

# The site, in site/: any warning stops the build, a broken link too.
docs: .venv/dev.stamp
	NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build --strict

# Every picture of the docs, from the scripts in docs/figures and benchmarks; some ten minutes.
figures: .venv/docs.stamp film
	for figure in relations reasoning floor_plan badges pages table charts; do $(BIN)/python docs/figures/$$figure.py || exit 1; done
	$(BIN)/python -m topple.benchmarks.wrong -o docs/wrong
	$(BIN)/python benchmarks/without_order.py 21 docs/without_order.png

# Other planners, for `topple bench motion` to run beside ours; each needs versions of its own.
peers: | python
	for name in mplib pybullet-planning; do \
	  $(PYTHON) -m venv .peers/$$name && .peers/$$name/bin/pip install --quiet $$name || exit 1; \
	done

# The moving picture of the README, from a run that is played for it.
film: .venv/docs.stamp
	$(BIN)/python docs/figures/film.py docs/dishes.webp

# docs/plan.schema.json is what the structs of planner/formats/plan_structs.py say; a test holds it to that.
schema: .venv/dev.stamp
	$(BIN)/python -c 'import json; from topple.planner.planning.plan_format import plan_schema; print(json.dumps(plan_schema(), indent=1))' > docs/plan.schema.json

# Both simulate, and PyBullet or its fork has wheels for CPython 3.10 to 3.13 on Linux x86-64.
python:
	@test -n "$(PYTHON)" || { echo "topple needs Python 3.10 to 3.13: install it, or name it with make PYTHON=/path/to/python3.11"; exit 1; }
	@$(PYTHON) -c 'import platform, sys; sys.exit(sys.version_info[:2] not in ((3, 10), (3, 11), (3, 12), (3, 13)) or (sys.platform, platform.machine()) != ("linux", "x86_64"))' \
	  || $(PYTHON) -c 'import pybullet' 2>/dev/null \
	  || { echo "PyBullet has no wheel for $(PYTHON): name a CPython 3.10 to 3.13 on Linux x86-64 with make PYTHON=/path/to/python3.11 (docs/install.md says what works on others)"; exit 1; }

.venv/bin/python: | python
	$(PYTHON) -m venv .venv

.venv/run.stamp: .venv/bin/python pyproject.toml hatch_build.py $(KERNELS)
	$(BIN)/pip install --quiet --no-compile --editable .
	$(BIN)/python -m compileall -qq -j 0 -x /tests/ .venv/lib || true # on all cores, which pip does not
	@touch $@

.venv/dev.stamp: .venv/bin/python pyproject.toml hatch_build.py $(KERNELS)
	-$(BIN)/python -m pip install --quiet --upgrade pip # an old one reads the indexes of the extra `dev` for a minute
	$(BIN)/pip install --quiet --no-compile --editable '.[dev]'
	$(BIN)/python -m compileall -qq -j 0 -x /tests/ .venv/lib || true # on all cores, which pip does not
	@touch $@ .venv/run.stamp

.venv/docs.stamp: .venv/dev.stamp
	$(BIN)/pip install --quiet --editable '.[docs]'
	@touch $@

clean:
	rm -rf .venv .dev dist site topple-demo .pytest_cache .ruff_cache .hypothesis topology/kernels/kernels_*.so
