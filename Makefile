# Everything a newcomer needs: `make demo`, `make test`. What a target needs, it installs.
.DEFAULT_GOAL := help
PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
READY  := $(VENV)/.ready
PIP    := $(BIN)/python -m pip install --quiet --quiet --disable-pip-version-check
UNPACK := $(BIN)/uv pip install --quiet --python $(BIN)/python --require-hashes -r requirements.lock  # a fifth of pip's work
COMPILE := .venv-lock/bin/uv pip compile --quiet --universal --python-version 3.11 --generate-hashes \
           --no-emit-index-url --no-header --no-annotate
CHROMIUM := command -v chromium >/dev/null || { \
	echo "installing Chromium with apt-get …"; \
	apt-get update -qq && apt-get install -y -qq chromium >/dev/null || { \
	echo "install the package chromium and try again"; exit 1; }; }
# A file's tests stay in one process: a study that they share is evaluated once. Twice as many processes as the two
# cores that are counted on: nearly half of the time a test waits for a service, a lease or a worker.
TESTS := $(BIN)/python -m pytest -n 4 --dist loadfile --no-loadscope-reorder
BESIDE := --no-print-directory -j 2  # types are one process for a minute
export OPENBLAS_NUM_THREADS ?= 1
unexport PYTHONDONTWRITEBYTECODE  # what is compiled is kept: every worker and every child would compile it again

SCREENSHOTS ?= screenshots
.PHONY: help install demo serve web web-dev openapi test thorough e2e screenshots check checked quick-tests every-test types compiled style layers page fuzz chaos load bench coverage tables plain blind same lock clean

help:  ## list the targets
	@grep -E '^[a-z0-9-]+:.*##' $(MAKEFILE_LIST) | sed 's/:.*##/\t/' | expand -t 12

$(READY): requirements.lock pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit("exogauge needs Python 3.11 to 3.14, for which pinocchio has packages; this is " + sys.version.split()[0] + ": make PYTHON=python3.14 …" if not (3, 11) <= sys.version_info[:2] <= (3, 14) else 0)'
	@echo "installing into $(VENV), which takes a minute or two and 2 GB …"
	@$(PYTHON) -m venv $(VENV)
	@sed -n '/^uv==/,/[^\\]$$/p' requirements.lock >$(VENV)/uv.lock && $(PIP) --require-hashes -r $(VENV)/uv.lock
	@$(UNPACK) || $(PIP) --no-compile --require-hashes -r requirements.lock  # pip's own settings name another registry
	@$(PIP) --no-deps --no-build-isolation --editable .
	@$(BIN)/python -m exogauge.loops
	@touch $(READY)

install: web  ## put exogauge and all it needs into .venv

demo: web  ## start the service, evaluate the sample study through HTTP, print the result
	$(BIN)/exogauge demo --realism ideal

serve: web  ## start the service on 127.0.0.1 with the same data as `make demo`
	$(BIN)/exogauge serve

web: $(READY)  ## build the web app into web/dist, if its source has changed
	@$(BIN)/python web/build_page.py

web-dev: $(READY)  ## the web app as its source is, reloaded on every change; `make serve` runs beside it
	$(BIN)/python web/build_page.py dev

openapi: $(READY)  ## write web/openapi.json, which the web app's types are made of
	$(BIN)/python -m exogauge.api.openapi_file web/openapi.json

test: checked  ## what `make check` does and the slow tests: all but those that drive a browser, which `make e2e` runs
	@$(MAKE) $(BESIDE) types every-test

e2e: web  ## drive the web app in Chromium; as root on Debian it installs Chromium if it is missing
	@$(CHROMIUM)
	$(BIN)/python -m pytest tests/e2e

screenshots: web  ## the same, keeping a picture of every page in the folder SCREENSHOTS
	@$(CHROMIUM)
	EXOGAUGE_TEST_SCREENSHOTS=$(abspath $(SCREENSHOTS)) $(BIN)/python -m pytest tests/e2e

check: checked  ## style, types, import layers, migrations and the quick tests
	@$(MAKE) $(BESIDE) types quick-tests

checked: web
	@$(MAKE) --no-print-directory -j 2 compiled style layers page

quick-tests:
	$(TESTS) -m "not slow"

every-test:  # quick ones too: they are collected once, and share what the slow ones of their file evaluate
	$(TESTS) -m "not e2e and not thorough" --durations 12

thorough: web  ## before a release: whole samples as a laboratory records them, and what takes long beside a quicker test
	$(TESTS) -m "thorough and not e2e"

types:
	$(BIN)/mypy

compiled: .cache/collected

.cache/collected: $(READY)  # the tests, once: each of the processes that run them would compile all of them
	@mkdir -p .cache && $(BIN)/python -m pytest --collect-only --quiet >$@ || { tail -n 40 $@; rm $@; exit 1; }

style:
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .

layers:
	$(BIN)/lint-imports

page:
	$(BIN)/python web/build_page.py check

.venv-bench/.ready: tests/bench/requirements.lock  # figaroh, the rival, in an environment of its own
	$(PYTHON) -m venv .venv-bench
	.venv-bench/bin/python -m pip install --quiet --disable-pip-version-check --require-hashes -r $<
	touch $@

bench: $(READY) .venv-bench/.ready  ## speed and memory as ratios in one run
	$(BIN)/python -m tests.bench

SEEDS ?= 20
FIRST ?= 1

coverage: $(READY)  ## how often stated intervals hold, on fresh samples as a laboratory records them: SEEDS=20 FIRST=1 KEPT=folder PICTURE=file.svg
	$(BIN)/python -m tests.calibration --seeds $(SEEDS) --first $(FIRST) --kept $(or $(KEPT),.coverage-kept) $(if $(PICTURE),--picture $(PICTURE))

STUDIES ?= 300
REQUESTS ?= 100

fuzz: web  ## studies with slips, damaged files, odd requests: STUDIES=300 REQUESTS=100, others every time
	EXOGAUGE_TEST_STUDIES=$(STUDIES) EXOGAUGE_TEST_REQUESTS=$(REQUESTS) $(BIN)/python -m pytest -n 2 tests/fuzz tests/plausibility/test_share.py tests/logs/test_reading.py tests/studies/test_device_fuzz.py tests/api/test_fuzz.py

RUNS ?= 50

chaos: $(READY)  ## kill -9 of the whole service at random moments, on both databases: RUNS=50 SEED=1 DATABASE=both BLOBS=folder|s3
	$(BIN)/python -m tests.chaos --runs $(RUNS) --seed $(SEED) --database $(or $(DATABASE),both) --blobs $(or $(BLOBS),folder)

STUDIES_STORED ?= 10000

load: $(READY)  ## what a request costs with 16 clients, 10⁴ studies and an evaluation running, on both databases: DATABASE=both; SOAK=3600: what grows in an hour
	$(if $(SOAK),$(BIN)/python -m tests.load.soak --seconds $(SOAK),$(BIN)/python -m tests.load --studies $(STUDIES_STORED) --database $(or $(DATABASE),both))

tables: $(READY)  ## the tables of docs/effects.md and docs/criteria.md
	$(BIN)/python -m tests.effects.tables
	$(BIN)/python -m tests.criteria.tables

SEEDS ?= 0:40

plain: $(READY)  ## studies in which nothing is missing, at every default: SEEDS=0:40 (docs/plain.md)
	$(BIN)/python -m tests.plain --seeds $(SEEDS)

CASES ?= 200
SEED  ?= 1
BLIND ?= exogauge-data/blind-$(SEED)-$(CASES)

blind: $(READY)  ## how often a hidden effect is named: CASES=200 SEED=1, in the folder BLIND
	@test -e $(BLIND)/seal.txt || $(BIN)/exogauge blind make $(BLIND) --seed $(SEED) --cases $(CASES)
	$(BIN)/exogauge blind run $(BLIND) || test $$? = 1  # 1: a case failed, and counts as silent
	$(BIN)/exogauge blind score $(BLIND) --json $(BLIND)/score.json

BASE ?= main
ONLY ?= sample,real,blind
RTOL ?= 1e-9
KEPT ?= exogauge-data/gate

same: $(READY)  ## do two trees give the same numbers? BASE=REVISION, ONLY=sample,blind:0:10,real, RTOL=1e-9
	$(BIN)/python -m tests.gate $(BASE) --only $(ONLY) --rtol $(RTOL) --kept $(KEPT)

lock:  ## resolve pyproject.toml anew into requirements.lock (hashes, no addresses)
	$(PYTHON) -m venv .venv-lock
	.venv-lock/bin/python -m pip install --quiet uv
	$(COMPILE) --extra build --extra test --extra check --extra sample --extra telemetry pyproject.toml -o requirements.lock
	$(COMPILE) --extra build --extra telemetry --constraint requirements.lock pyproject.toml -o docker/requirements.lock

clean:  ## remove the environment and caches
	rm -rf .venv .venv-* web/node_modules web/dist .cache .pytest_cache .mypy_cache .ruff_cache
