# Every target sets up what it needs: `make demo` and `make test` work alone on a fresh clone
# with Python 3.11 to 3.13 and a C compiler.

PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed
DEMO := build/diligent

.PHONY: system setup demo docs vscode playground ros2 ros-mcp test pythons lint check bench fuzz fuzz-c faults mutants targets prove coverage soak agree teams known clean

setup: $(STAMP)

# Debian packages that help, where we may install them; says what is missing and never fails.
system:
	.ci/system

# NuSMV, for second opinions, comes with this wheel where there is one; of what the wheel depends on it needs nothing.
NUSMV := pyboolnet==3.0.16

# Bytecode is made as pip does it for all that is not editable: without it the command begins 0.25 s later.
$(STAMP): pyproject.toml
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --editable '.[dev]'
	-$(BIN)/python -m pip install --quiet --no-deps --only-binary :all: '$(NUSMV)'
	$(BIN)/python -m compileall -q exover
	touch $@

demo: setup
	@echo '# 1. check the rules of the robot Diligent'
	$(BIN)/exover check specs/diligent.exo
	@echo '# 2. emit its tables: C sources, the bytes alone, and a drawing of the diagram'
	$(BIN)/exover emit specs/diligent.exo --target c,bin,dot --out $(DEMO)
	ls -l $(DEMO)
	@echo '# 3. compile the C runtime and run a recorded mission through it'
	$(BIN)/exover simulate specs/diligent.exo --events specs/diligent.mission.jsonl --engine c > $(DEMO)/mission.c.jsonl
	@echo '# 4. the reference interpreter gives the same answers'
	$(BIN)/exover simulate specs/diligent.exo --events specs/diligent.mission.jsonl > $(DEMO)/mission.reference.jsonl
	cmp $(DEMO)/mission.c.jsonl $(DEMO)/mission.reference.jsonl
	@echo '# the last answers of the mission'
	tail -n 12 $(DEMO)/mission.c.jsonl

# The documentation as a site with search, in build/site.
DOCS := $(VENV)/.docs

$(DOCS): $(STAMP)
	$(BIN)/python -m pip install --quiet --editable '.[docs]'
	touch $@

docs: $(DOCS)
	$(BIN)/python -m mkdocs build --quiet --strict
	@echo 'build/site/index.html'

# The extension for VS Code, with the official packager; needs Node.js 20 or newer and npm.
vscode:
	cd editors/vscode && npm ci --ignore-scripts --no-audit --no-fund && npm run --silent package
	@echo 'editors/vscode/exover.vsix'

# The page of a report with an editor, answered in the browser, in build/playground, for any static server; needs npm.
playground: setup
	cd playground && npm ci --ignore-scripts --no-audit --no-fund
	$(BIN)/python -m playground playground/node_modules/pyodide build/playground
	@echo 'build/playground/index.html, to be served: python -m http.server --directory build/playground'

# The gate of ROS 2 between peers that share nothing with it, in Rust; needs cargo and the network, and minutes the first time.
GOALS ?= 10000
ros2: setup
	cargo build --quiet --locked --manifest-path tests/gate/peers/Cargo.toml --target-dir build/peers
	EXOVER_ROS2_PEERS=$(CURDIR)/build/peers/debug/peers EXOVER_ROS2_GOALS=$(GOALS) \
	    $(BIN)/python -m pytest -q -rs tests/gate/test_ros2_rust.py

# The gate of agents before ros-mcp, which wants versions of MCP of its own.
ROS_MCP := build/ros-mcp

ros-mcp: setup
	test -x $(ROS_MCP)/bin/ros-mcp || $(PYTHON) -m venv $(ROS_MCP)
	$(ROS_MCP)/bin/python -m pip install --quiet ros-mcp==3.1.2
	ROS_MCP=$(CURDIR)/$(ROS_MCP)/bin/ros-mcp $(BIN)/python -m pytest -q -rs tests/gate/test_ros_mcp.py

# In one process more than there are processors, for many tests wait; a file of tests to one of them: `make test JOBS=0`
# takes this one. What Python compiles is kept, for every process would compile it again, and so is what compilers make of
# equal sources, in COMPILED, for the next time; `make test COMPILED=`: it is not. TESTS: some of them.
JOBS ?= $(shell $(PYTHON) -c 'import os; print(1 + len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() + 1)')
TESTS ?=
COMPILED ?= $(CURDIR)/build/compiled
test: setup
	PYTHONDONTWRITEBYTECODE= $(if $(COMPILED),EXOVER_TESTS_KEPT='$(COMPILED)') $(BIN)/python -m pytest -q -rs -n $(JOBS) --dist loadfile --no-loadscope-reorder $(TESTS)

# The same under every other version of Python that is here and that exover supports, each in an environment of its own in
# build; PYTHONS: the programs, if not those on PATH.
pythons: setup
	.ci/pythons $(BIN)/python $(TESTS)

lint: setup
	$(BIN)/ruff check .
	$(BIN)/mypy --strict
	$(BIN)/lint-imports

check: lint test

# All figures, or ROWS of them: `python -m benchmarks --list` tells what they are called.
ROWS ?=
bench: setup
	$(BIN)/python -m benchmarks $(ROWS)

# The engines against each other, then the checks against plain enumeration; SECONDS for each.
SECONDS ?= 600
fuzz: setup
	$(BIN)/python -m tests.support.fuzz --native --seconds $(SECONDS)
	$(BIN)/python -m tests.support.fuzz --checks --seconds $(SECONDS)

# Every bit of tables and state of running checkers flipped, in every build and in six specs that use every feature; 100 000 damaged tables refused.
faults: setup
	EXOVER_ALL_FAULTS=1 $(BIN)/python -m pytest -q tests/runtime/test_flips.py tests/runtime/test_damage.py \
	    tests/runtime/test_flips_of_rules.py
	EXOVER_ALL_FAULTS=1 $(BIN)/python -m pytest -q tests/runtime/test_rust.py -k flipped

# Damaged tables with a right checksum: so many of each of eight specs, none of which may pass for the rules.
MUTANTS ?= 50
mutants: setup
	EXOVER_MUTANTS=$(MUTANTS) $(BIN)/python -m pytest -q tests/equivalence/test_mutations.py

# What needs tools that are not everywhere: cross compilers, QEMU, cppcheck. Tests whose tool is missing are left out.
targets: setup
	$(BIN)/python -m pytest -q -rs tests/runtime/test_targets.py tests/runtime/test_build.py

# That loading, scrubbing and first events have no run-time error, by Frama-C's Eva; left out where it is not installed (Debian package frama-c-base).
prove: setup
	$(BIN)/python -m pytest -q -rs tests/runtime/test_proved.py

# Statements, branches and MC/DC of exover.c and its parts, with every gap; needs gcc, and clang to find the decisions. It ends
# with status 1 if a gap has no reason in tests/runtime/gaps.toml. What times single instructions is left out.
MEASURED := mismatch load refused faults faulty guards misuse damage extremes bounds boolean corners box resume swap calls
coverage: setup
	rm -rf build/coverage
	mkdir -p build/coverage
	EXOVER_COVERAGE=$(CURDIR)/build/coverage $(BIN)/python -m pytest -q $(MEASURED:%=tests/runtime/test_%.py) \
	    --deselect tests/runtime/test_misuse.py::test_a_call_within_a_call_never_launches_both_of_a_pair \
	    --deselect tests/runtime/test_misuse.py::test_answers_stay_within_their_places_whatever_their_number_becomes
	$(BIN)/python -m tests.runtime.coverage build/coverage

# libFuzzer on loading and on events, with sanitizers; what it finds new stays in build/corpus. It needs clang with its
# run-time library (Debian packages clang and, for clang 14, libclang-rt-14-dev), which `make system` installs where it may.
fuzz-c: setup
	$(BIN)/python -m tests.runtime.corpus build/corpus
	clang -std=c99 -g -O1 -fsanitize=fuzzer,address,undefined -fno-sanitize-recover=all -DEXOVER_WIDTH=2 -Iexover/runtime \
	    tests/runtime/fuzz.c -o build/fuzz-c
	build/fuzz-c -max_total_time=$(SECONDS) -max_len=16384 build/corpus

# So many random decisions of the emitted C and of the emitted Rust against mutexes, read a second time; and so many of the
# C against the tables, walked in Python, on all kinds of rules; and so many events of each spec on its page. More random
# specs in Rust.
DECISIONS ?= 1000000000
WALKED ?= 1000000
STEPS ?= 100000
soak: setup
	EXOVER_STEPS=$(STEPS) $(BIN)/python -m pytest -q tests/page/test_walker.py -k random_runs
	EXOVER_DECISIONS=$(DECISIONS) EXOVER_WALKED=$(WALKED) \
	    $(BIN)/python -m pytest -q tests/runtime/test_decisions.py tests/runtime/test_rust.py \
	    -k 'random_decisions or as_the_others_do'

# Everything that is asked of specs as teams write them has to be answered.
teams: setup
	EXOVER_TEAMS=600 EXOVER_ANSWERED=1 $(BIN)/python -m pytest -q tests/checks/test_team_specs.py

# The same for a minute each: what is answered has to be what is known.
known: setup
	EXOVER_TEAMS=60 $(BIN)/python -m pytest -q tests/checks/test_team_specs.py

# All engines and plain enumeration on random small specs.
SPECS ?= 200
agree: setup
	$(BIN)/python -m tests.support.agreement --specs $(SPECS)

clean:
	rm -rf build dist $(VENV) *.egg-info .mypy_cache .ruff_cache .pytest_cache .hypothesis .import_linter_cache
	find exover tests benchmarks -name __pycache__ -type d -prune -exec rm -rf {} +
