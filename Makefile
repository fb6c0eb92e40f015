# `make demo` and `make test` set up all they need in .venv the first time, and nothing after that.
PYTHON ?= python3
# Another Python, as in `make test PYTHON=python3.13`, has an environment of its own.
VENV := $(if $(filter python3,$(PYTHON)),.venv,build/$(notdir $(PYTHON)))
BIN := $(VENV)/bin
# Two cores: BLAS and torch must not fight the processes beside them.
export OMP_NUM_THREADS ?= 1
# Text read or written in whatever encoding the locale has is an error in the tests.
test quick slow night peers: export PYTHONWARNDEFAULTENCODING ?= 1

.PHONY: demo test quick docs lint types layers package slow night peers explore browser mutation bench clean

demo: $(VENV)/ready
	$(BIN)/stickslip demo

test: lint types layers
	$(BIN)/python -m pytest -n 2 --dist loadgroup

# Capacities, readouts, and a policy on the simulated body, with as few packages as these need: for other Pythons.
quick: $(VENV)/quick-ready
	$(BIN)/python -m pytest tests/reservoir tests/robot

slow: $(VENV)/interop-ready $(VENV)/docs-ready $(VENV)/browser-ready peers
	$(BIN)/python -m pytest -m slow

# The site, in docs/_build/html: pages, reference and the tutorials, which are run.
docs: $(VENV)/docs-ready
	$(BIN)/python docs/environment_page.py
	$(BIN)/python -m sphinx --builder html --nitpicky --fail-on-warning --quiet docs docs/_build/html

# Hypothesis searches at random here, and prints a blob with what it finds: @reproduce_failure takes it.
night: export HYPOTHESIS_PROFILE := night
night: $(VENV)/interop-ready $(VENV)/docs-ready $(VENV)/browser-ready
	$(BIN)/python -m pytest -m "slow or not slow"

# Jobs of others' libraries, which the development install does without.
peers: $(VENV)/peers-ready
	$(BIN)/python -m pytest -m "slow or not slow" tests/benchmarks/test_peers.py tests/benchmarks/test_batch_peers.py

# The page one can play with; its address is printed, and opened where there is a browser.
explore: $(VENV)/explore-ready
	$(BIN)/stickslip explore

# That page's tests, in a browser without a window.
browser: $(VENV)/browser-ready
	$(BIN)/python -m pytest -m "slow or not slow" tests/explore

# Faults put into the code, and whether the tests notice: hours for all; more options in the script.
mutation: $(VENV)/ready
	$(BIN)/python benchmarks/mutation.py --minutes 20

lint: $(VENV)/ready
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(VENV)/ready
	$(BIN)/mypy -p stickslip

layers: $(VENV)/ready
	$(BIN)/lint-imports --no-cache

package: $(VENV)/ready
	rm -rf dist
	$(BIN)/python -m build

bench: $(VENV)/ready
	for script in $(filter-out benchmarks/measuring.py benchmarks/mutation.py,$(wildcard benchmarks/*.py)); do $(BIN)/python $$script || exit 1; done

$(VENV)/ready: pyproject.toml constraints.txt
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --constraint constraints.txt --editable '.[dev]'
	touch $@

$(VENV)/quick-ready: pyproject.toml constraints.txt
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --constraint constraints.txt --editable '.[cli,plot]' hypothesis mpmath pytest
	touch $@

# The packages of docs/recipes.md; what cannot share this environment has one in $(VENV)/interop, made by its test.
$(VENV)/interop-ready: $(VENV)/ready
	$(BIN)/python -m pip install --quiet --constraint constraints.txt --editable '.[interop]'
	touch $@

$(VENV)/peers-ready: $(VENV)/ready
	$(BIN)/python -m pip install --quiet --constraint constraints.txt --editable '.[peers]'
	touch $@

$(VENV)/docs-ready: $(VENV)/ready
	$(BIN)/python -m pip install --quiet --constraint constraints.txt --editable '.[docs]'
	touch $@

# The page needs Bokeh beside the package, and nothing of what tests do.
$(VENV)/explore-ready: pyproject.toml constraints.txt
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --constraint constraints.txt --editable '.[explore]'
	touch $@

# What moves a browser in the page's tests.
$(VENV)/browser-ready: $(VENV)/ready $(VENV)/explore-ready
	$(BIN)/python -m pip install --quiet --constraint constraints.txt playwright
	touch $@

clean:
	rm -rf $(VENV) build dist docs/_build runs *.egg-info src/*.egg-info
