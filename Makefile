# Every target sets up .venv first if it is missing or out of date; nothing else needs to be installed.
PYTHON ?= python3
BIN := .venv/bin
PYTEST := $(BIN)/pytest -n auto --dist loadfile

.PHONY: report docs test test-browser coverage test-all bench bench-history bench-joints bench-peers mutants lint surface build changes clean

report: .venv/ready
	$(BIN)/polydraulic report --out report

# Warnings are errors, among them links that lead nowhere.
docs: .venv/ready
	$(BIN)/sphinx-build -q -W --keep-going docs docs/_build/html
	@echo docs/_build/html/index.html

# Tests start many processes: what is kept of the sources as bytecode need not be compiled in each.
test coverage test-all: export PYTHONDONTWRITEBYTECODE =

# Whatever holds a kernel or calls one by itself: the rest is the same in plain Python, and slower.
PLAIN := tests/test_elementary.py tests/machine tests/flow tests/simulation tests/control tests/networks/model \
	tests/networks/growth/test_derivatives.py tests/networks/growth/test_least_squares.py tests/networks/growth/test_refine.py \
	tests/networks/growth/test_scoring.py tests/networks/growth/test_variables.py tests/networks/proof/test_taylor.py \
	tests/identification/equations/fit/test_circuit_slopes_at.py tests/identification/equations/fit/test_weighing.py \
	tests/identification/equations/test_pilot_fit.py \
	tests/identification/equations/test_spool_motion.py \
	tests/networks/dynamic/test_free_run.py tests/networks/dynamic/test_rows.py tests/networks/dynamic/test_joint_strength.py tests/networks/dynamic/test_lagged_terms.py \
	tests/export/translate tests/export/test_machine.py tests/export/test_controller.py \
	tests/watch/kernels tests/watch/test_sequential.py

# Compiled first, then the tests of kernels once more in plain Python: they must not depend on the compiler.
test: .venv/ready
	$(PYTEST) -m "not slow and not browser" $(MEASURED)
	NUMBA_DISABLE_JIT=1 $(PYTEST) -m "not slow" $(PLAIN)

# The cockpit's page in a real browser without a screen, one process: Debian's chromium and chromium-driver, without which this fails.
# `make test` leaves these tests out, plain `pytest` runs them where there is a browser and else says what is missing.
test-browser: .venv/ready
	POLYDRAULIC_BROWSER=needed $(BIN)/pytest tests/browser

# The same tests, and what share of the lines of the package they run compiled; kernels are left out, since compiled code is not seen.
# pyproject.toml says what share there must be; the modules with the least stand first.
coverage: .venv/ready
	rm -f .coverage
	$(MAKE) test MEASURED="--cov --cov-report= --cov-fail-under=0"
	$(BIN)/coverage report --sort=cover --fail-under=0 | sed -n 1,25p
	$(BIN)/coverage report --format=total

test-all: .venv/ready
	$(PYTEST) -m "not browser"
	NUMBA_DISABLE_JIT=1 $(PYTEST) -m "not slow" $(PLAIN)

# What is printed is kept in benchmarks/results, and pages state no number of it that is not there (tests/test_measured.py).
bench: .venv/ready
	$(BIN)/python benchmarks/keep.py run
	$(BIN)/python benchmarks/keep.py solvers
	$(BIN)/python benchmarks/keep.py machine
	$(BIN)/python benchmarks/keep.py machine_c
	$(BIN)/python benchmarks/keep.py tree_motion
	$(BIN)/python benchmarks/keep.py flows
	$(BIN)/python benchmarks/keep.py straight_line $(if $(OTHER),--other $(OTHER))
	$(BIN)/python benchmarks/keep.py exports
	$(BIN)/python benchmarks/keep.py series
	$(BIN)/python benchmarks/keep.py layouts
	$(BIN)/python benchmarks/keep.py stepping
	$(BIN)/python benchmarks/keep.py gym
	$(BIN)/python benchmarks/keep.py tip_loads
	$(BIN)/python benchmarks/keep.py methods
	$(BIN)/python benchmarks/keep.py waits $(if $(OLD),--old $(OLD))
	$(BIN)/python benchmarks/keep.py worst_step
	$(BIN)/python benchmarks/keep.py watch_update
	$(BIN)/python benchmarks/networks.py --quick --only accuracy
	$(BIN)/python benchmarks/keep.py networks --quick --only scoring fitting evaluation
	$(BIN)/python benchmarks/keep.py importing
	$(BIN)/python benchmarks/keep.py identify
	$(BIN)/python benchmarks/keep.py control --figure docs/images/control.svg

# A few figures, appended to benchmarks/history.jsonl with commit and processor; says which is slower than before.
bench-history: .venv/ready
	$(BIN)/python benchmarks/history.py

# The learners people would use instead, some of which need NumPy 1; DATA=folder adds its CSV files.
bench-peers: .venv/ready .venv-peers/ready
	$(BIN)/python benchmarks/networks.py --peers $(if $(DATA),--data $(DATA))

# Joints learnt from commands on a public log, which DATA=folder holds.
bench-joints: .venv/ready
	$(BIN)/python benchmarks/keep.py joints --data $(DATA)

# Whether tests notice changes of the code that decides what holds: hours, or minutes with MODULE=measure.checks.clock.
# First what stands in functions, then constants of modules; what no test noticed is listed. In plain Python, since
# changed sources would be compiled anew.
mutants: export NUMBA_DISABLE_JIT = 1
mutants: .venv-mutants/ready
	.venv-mutants/bin/python tools/function_mutants.py $(MODULE)
	.venv-mutants/bin/python tools/constant_mutants.py $(MODULE)

lint: .venv/ready
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/towncrier build --draft --version unreleased > /dev/null

# After a change of public names or signatures; a file in changes/ must say it first.
surface: .venv/ready
	$(BIN)/python tools/public_surface.py

# Wheel (made from the source distribution) and source distribution, each tried in an environment outside of the checkout.
build: .venv/ready
	rm -rf dist
	$(BIN)/python -m build --outdir dist .
	$(BIN)/python tools/install_built.py dist

changes: .venv/ready
	$(BIN)/towncrier build --draft --version unreleased

.venv/ready: pyproject.toml
	$(PYTHON) -m venv .venv
	$(BIN)/pip install --quiet --upgrade pip
	$(BIN)/pip install --quiet --editable ".[all]"
	touch $@

.venv-peers/ready: benchmarks/peers/requirements.txt
	$(PYTHON) -m venv .venv-peers
	.venv-peers/bin/pip install --quiet --requirement $<
	touch $@

# mutmut runs tests in its own process, so that it needs all that they need.
.venv-mutants/ready: pyproject.toml
	$(PYTHON) -m venv .venv-mutants
	.venv-mutants/bin/pip install --quiet --editable ".[all,mutants]"
	touch $@

clean:
	rm -rf .venv .venv-peers .venv-mutants mutants report dist docs/_build docs/reference
