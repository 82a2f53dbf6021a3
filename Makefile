# make run    start the service and fit an example       make test        the fast tests, without torch
# make setup  install primfit into .venv                 make test-torch  the tests that need torch
# make test-slow    the slow tests: brute-force optima and more, some minutes
# make test-clock   tests that compare times; needs an idle machine
# make test-fire    load, hostile requests, kills and full disks against a real service, 15 minutes; needs an idle machine
# make test-schema  random requests to the service, checked against its OpenAPI document, some minutes
# make test-fuzz    fuzz every reader, coverage-guided, two minutes each (FUZZ_SECONDS); Linux only
# make test-ray     three nodes of a Ray cluster on this machine, one of them killed; installs Ray, some minutes
# make image  build the container image                  make lint        ruff, mypy, import rules
# make sbom   what the image is made of, as CycloneDX in build/sbom.json
# make wheel  the wheel and the sdist, in dist/          make test-wheel  try the wheel without a compiler
# make lock   write the newest versions to requirements/ make lock-check  do they still match pyproject.toml?
# make weights  train both classifiers again             make clean       remove everything that make created
# make weights-paper  train the networks of the paper's methods, hours; QUICK=1: see that it works, elsewhere
# make training-figures  after make weights: refresh docs/training-figures.md
# make example  refresh the example answer of the API    make openapi     refresh docs/openapi.json
# make viewer   build the page at / from app/viewer (needs node and npm)
# make notebooks  refresh what docs/notebooks print
# make constants  refresh the table of constants in docs/pipeline.md, and count the numbers of the verdict
# make bench  measure primfit on small sets, a few minutes; the report is build/bench/report/benchmark.md
# make bench-steps  has a step of a fit become slower than the recorded figures? half a minute
# make bench-peers  install the libraries to compare with    make bench-full  measure all of them, a few hours

PYTHON ?= python3
PORT   ?= 8000
VENV   ?= .venv
VENV_TORCH ?= .venv-torch
VENV_RAY ?= .venv-ray
# benchmark/runner.py finds the peers here.
VENV_PEERS  = .venv-peers
# Processes that draw the clouds of `make weights`.
PROCESSES ?= 2
# Processes that share the tests, a module each at a time.
TEST_PROCESSES ?= 2
# How long `make test-fuzz` fuzzes each reader.
FUZZ_SECONDS ?= 120
# Pinned: this release has a CPU build for Python 3.11. pyproject.toml gives the range.
TORCH  ?= torch==2.13.0

# `make image`: the first container engine found; docs/docker.md shows a base image made without a registry.
ENGINE     ?= $(notdir $(firstword $(shell command -v docker || command -v podman || command -v buildah)))
BASE_IMAGE ?= python:3.11-slim
IMAGE      ?= primfit:$(VERSION)
VERSION     = $(shell sed -n 's/^version = "\(.*\)"/\1/p' pyproject.toml)
# podman and buildah keep the health check only in this format.
export BUILDAH_FORMAT = docker

# Clouds are small: one thread a process is faster than many, and answers do not depend on the machine.
export OMP_NUM_THREADS ?= 1
export OPENBLAS_NUM_THREADS ?= 1

PYTEST_SHARED = $(VENV)/bin/python -m pytest --numprocesses $(TEST_PROCESSES) --dist loadscope --durations 10

# `make lock` works in this folder; its requirements are for each system and each Python from 3.11 on.
LOCK_AT = .
UPGRADE = --upgrade
COMPILE = $(abspath $(VENV))/bin/uv --quiet pip compile --universal --python-version 3.11 --generate-hashes $(UPGRADE) \
	--custom-compile-command 'make lock'
AS_TESTED = --constraint requirements/dev.txt
BUILT_WITH = $(PYTHON) -c "import tomllib; print(*tomllib.load(open('pyproject.toml', 'rb'))['build-system']['requires'], sep='\n')"

PIP_INSTALL = -m pip install --quiet --disable-pip-version-check

.PHONY: run setup test test-slow test-clock test-fire test-schema test-fuzz test-torch test-ray lint weights weights-paper training-figures example openapi viewer constants notebooks bench bench-steps bench-peers bench-full image sbom wheel test-wheel lock lock-check clean
.DEFAULT_GOAL := run

run: setup
	@$(VENV)/bin/primfit serve --demo --port $(PORT)

setup: $(VENV)/.serving

test: $(VENV)/.dev
	$(PYTEST_SHARED) -m "not slow and not clock and not docker and not schema and not wheel and not fire"

test-slow: $(VENV)/.dev
	$(PYTEST_SHARED) -m slow

test-clock: $(VENV)/.dev
	$(VENV)/bin/python -m pytest -m clock

# hypothesis, which is not used there, is otherwise imported after the last test: on Python 3.11 that may fail.
test-fire: $(VENV)/.dev
	rm -rf build/fire
	$(VENV)/bin/python -m pytest -m fire --capture no -p no:hypothesispytest tests/fire
	@$(VENV)/bin/python -m tests.fire.report

test-schema: $(VENV)/.dev
	$(VENV)/bin/python -m pytest -m schema --capture no

test-fuzz: $(VENV)/.fuzz
	$(VENV)/bin/python -m tests.fuzz --seconds $(FUZZ_SECONDS)

test-torch: $(VENV_TORCH)/.torch
	$(VENV_TORCH)/bin/python -m pytest -m torch

# Ray has an environment of its own: beside the tools of .venv its processes start too slowly for it.
test-ray: $(VENV_RAY)/.ray
	$(VENV_RAY)/bin/python -m pytest -m ray tests/ray

lint: $(VENV)/.dev
	$(VENV)/bin/ruff check .
	$(VENV)/bin/ruff format --check .
	$(VENV)/bin/mypy --package primfit
	$(VENV)/bin/mypy docs/constants.py
	$(VENV)/bin/mypy docs/notebooks/run.py
	$(VENV)/bin/mypy deploy/sbom.py
	$(VENV)/bin/lint-imports

# Both classifiers learn from the same clouds, which are drawn once and kept under build/ for this run only.
weights: $(VENV)/.serving $(VENV_TORCH)/.torch
	rm -rf build/clouds
	$(VENV_TORCH)/bin/python -m primfit.models.training.network --processes $(PROCESSES) --cache build/clouds --curves build/network-curves.json
	$(VENV_TORCH)/bin/python -m primfit.models.training.knn --processes $(PROCESSES) --cache build/clouds
	$(MAKE) example

# Hours on two cores; it goes on where it was cut off. QUICK=1 takes minutes and writes weights of no use under build/.
QUICK_PAPER = $(if $(QUICK),--quick --out build/paper-quick/weights --cache build/paper-quick)
weights-paper: $(VENV_TORCH)/.torch
	$(VENV_TORCH)/bin/python -m primfit.paper.training.m2 --processes $(PROCESSES) \
		$(if $(QUICK),--clouds 100 --out build/paper-quick/weights)
	$(VENV_TORCH)/bin/python -m primfit.paper.training --processes $(PROCESSES) $(QUICK_PAPER)

# After `make weights`, on the same clouds: the design that lost, and the figures of all in docs/.
training-figures: $(VENV_TORCH)/.torch
	$(VENV_TORCH)/bin/python -m primfit.models.training.pointnet --epochs 8 --cache build/clouds --curves build/pointnet-curves.json > build/pointnet.json
	$(VENV_TORCH)/bin/python -m primfit.models.training.report --pointnet build/pointnet.json \
		--curves build/network-curves.json build/pointnet-curves.json

# The OpenAPI document shows a real answer; it names the weights and follows every change of the numbers.
example: $(VENV)/.serving
	$(VENV)/bin/primfit fit --json app/examples/request.json > app/examples/answer.json

# The contract, as a file: clients are generated from it, and a change of it is seen in a diff.
openapi: $(VENV)/.serving
	$(VENV)/bin/primfit openapi > docs/openapi.json

# Types of the API come from docs/openapi.json.
viewer:
	cd app/viewer && npm ci && npm run types && npm run check && npm run build

# The table of docs/pipeline.md from the sources; it installs nothing.
constants:
	@$(PYTHON) docs/constants.py

# Both go on where they were cut off; `primfit bench --help` has more.
# The notebooks with what they print; pictures are not kept.
notebooks: $(VENV)/.dev
	$(VENV)/bin/python docs/notebooks/run.py

bench: $(VENV)/.bench
	$(VENV)/bin/primfit bench run
	$(VENV)/bin/primfit bench proofs
	$(VENV)/bin/primfit bench report

bench-steps: $(VENV)/.serving
	@$(VENV)/bin/primfit bench steps --compare

bench-peers: $(VENV_PEERS)/.peers

bench-full: $(VENV)/.bench $(VENV_PEERS)/.peers
	$(VENV)/bin/primfit bench run --full --peers --out build/bench-full
	$(VENV)/bin/primfit bench proofs --full --out build/bench-full
	$(VENV)/bin/primfit bench report --records build/bench-full --out docs

image:
	$(ENGINE) build --build-arg BASE_IMAGE=$(BASE_IMAGE) $(IMAGE_FLAGS) --tag $(IMAGE) .

# Of an image that is there already: make image.
sbom: $(VENV)/.dev
	$(VENV)/bin/python deploy/sbom.py --engine $(ENGINE) $(IMAGE)

# One wheel for Python 3.11 and later, made from the sdist, so that this is known to be whole.
wheel: $(VENV)/.dev
	rm -rf build/dist dist
	$(VENV)/bin/python -m build --no-isolation --outdir build/dist
	PATH=$(abspath $(VENV))/bin:$$PATH $(VENV)/bin/auditwheel repair --wheel-dir dist build/dist/*.whl
	mv build/dist/*.tar.gz dist
	$(VENV)/bin/abi3audit --strict dist/*.whl

test-wheel: wheel
	$(VENV)/bin/python -m pytest -m wheel

# Versions and hashes of what is developed with, and of the same versions of what is built with and what the image
# holds, with and without extras: an image holds what was tested.
lock: $(VENV)/.uv
	@mkdir -p $(LOCK_AT)/requirements
	cd $(LOCK_AT) && $(COMPILE) --extra dev --output-file requirements/dev.txt pyproject.toml
	cd $(LOCK_AT) && $(BUILT_WITH) | $(COMPILE) $(AS_TESTED) --output-file requirements/build.txt -
	cd $(LOCK_AT) && $(COMPILE) $(AS_TESTED) --extra postgres --output-file requirements/image.txt pyproject.toml
	cd $(LOCK_AT) && $(COMPILE) $(AS_TESTED) --extra bench --extra cad --extra e57 --extra mcp --extra otel --extra postgres \
		--output-file requirements/full.txt pyproject.toml

# The same on a copy, without looking for newer versions.
lock-check: $(VENV)/.uv
	rm -rf build/lock && mkdir -p build/lock && cp -r pyproject.toml requirements build/lock
	@$(MAKE) --no-print-directory lock LOCK_AT=build/lock UPGRADE=
	diff -r requirements build/lock/requirements

clean:
	rm -rf $(VENV) $(VENV_TORCH) $(VENV_RAY) $(VENV_PEERS) build dist src/primfit.egg-info fitting/*/_*.c fitting/*/_*.so models/_*.c models/_*.so

# A virtual environment and, in it, one stamp for each thing installed; all are redone when pyproject.toml or
# what is compiled changes.
BUILT = pyproject.toml setup.py $(wildcard fitting/*/*.pyx fitting/*/*.pxd fitting/*/*.h models/*.pyx)

%/.python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "primfit needs Python 3.11 or newer, but $(PYTHON) is " + sys.version.split()[0] + ". Name a newer one: make PYTHON=python3.12 $(MAKECMDGOALS)")'
	@command -v $${CC:-cc} >/dev/null || { echo 'primfit needs a C compiler: on Debian and Ubuntu, apt install gcc libc6-dev python3-dev' >&2; exit 1; }
	@$(PYTHON) -c 'import ensurepip, venv' 2>/dev/null || { echo 'primfit needs the venv module of $(PYTHON): on Debian and Ubuntu, apt install python3-venv' >&2; exit 1; }
	@echo 'creating $*'
	@$(PYTHON) -m venv $*
	@touch $@

$(VENV)/.serving: $(BUILT) | $(VENV)/.python
	@echo 'installing primfit into $(VENV) (about a minute, once)'
	@$(VENV)/bin/python $(PIP_INSTALL) --editable .
	@touch $@

$(VENV)/.dev: $(BUILT) requirements/dev.txt | $(VENV)/.python
	@echo 'installing primfit and its development tools into $(VENV) (about two minutes, once)'
	@$(VENV)/bin/python $(PIP_INSTALL) --require-hashes --requirement requirements/dev.txt
	@$(VENV)/bin/python $(PIP_INSTALL) --no-deps --no-build-isolation --editable .
	@touch $(VENV)/.serving $@

$(VENV)/.fuzz: $(VENV)/.dev
	@$(VENV)/bin/python $(PIP_INSTALL) --no-build-isolation --editable '.[fuzz]'
	@touch $@

$(VENV)/.uv: | $(VENV)/.python
	@$(VENV)/bin/python $(PIP_INSTALL) uv
	@touch $@

$(VENV_TORCH)/.torch: $(BUILT) | $(VENV_TORCH)/.python
	@echo 'installing primfit and torch into $(VENV_TORCH) (a few minutes, once)'
	@$(VENV_TORCH)/bin/python $(PIP_INSTALL) --editable '.[dev,train]' '$(TORCH)'
	@touch $@

$(VENV_RAY)/.ray: $(BUILT) | $(VENV_RAY)/.python
	@echo 'installing primfit and Ray into $(VENV_RAY) (a few minutes, once)'
	@$(VENV_RAY)/bin/python $(PIP_INSTALL) --editable '.[bench,bulk,ray]' 'httpx>=0.27,<1' 'pytest>=8.3,<10'
	@touch $@

$(VENV)/.bench: $(BUILT) | $(VENV)/.python
	@echo 'installing primfit and matplotlib into $(VENV) (about a minute, once)'
	@$(VENV)/bin/python $(PIP_INSTALL) --editable '.[bench]'
	@touch $(VENV)/.serving $@

$(VENV_PEERS)/.peers: $(BUILT) benchmark/peers.txt | $(VENV_PEERS)/.python
	@echo 'installing primfit and the libraries of benchmark/peers.txt into $(VENV_PEERS) (a few minutes, once)'
	@$(VENV_PEERS)/bin/python $(PIP_INSTALL) --editable .
	@$(VENV_PEERS)/bin/python $(PIP_INSTALL) --no-deps --requirement benchmark/peers.txt
	@touch $@
