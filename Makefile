# `make demo` and `make test` set up everything they need in .venv first.
# Another interpreter: make PYTHON=python3.12 test

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready
RUN := $(BIN)/strandcli

DOCS := .venv-docs

.PHONY: all bounds coverage threads wheel unwritable faults kills dask plan-figures demo fuzz test test-long test-oldest lint types check docs figures figures-of-docs gallery changelog claims study bench stress golden golden-update check-against-mitsuba check-against-blender clean help

help:
	@echo "make demo       render the default preset to out/demo: PNG frames and a GIF"
	@echo "make test       run the tests"
	@echo "make test-long  run the tests that `make test` leaves out, for they repeat at length what others show"
	@echo "make test-oldest   kernels with the oldest Numba that is supported, in an environment of its own"
	@echo "make all        what a release has to pass: check, oldest Numba, wheel installed elsewhere, no home, coverage, bounds, docs"
	@echo "make check      lint, types and tests, as CI does"
	@echo "make coverage   lines of drivers that tests run without Numba's compiler"
	@echo "make bounds     every index in every kernel looked at, in small scenes of all presets; minutes"
	@echo "make wheel      a wheel with the kernels of all presets, or of PACKED=minimal: out/wheel"
	@echo "make kernel-costs   which kernels each preset needs and how long they compile, for the progress line; ten minutes"
	@echo "make threads    pictures of all presets with 1, 2, 3 and 4 threads have the same bits"
	@echo "make docs       the documentation as a site: out/docs/index.html"
	@echo "make figures    every figure of the thesis on one sheet: out/figures/sheet.png"
	@echo "make gallery    the presets large and fine: out/gallery, some minutes"
	@echo "make claims     what the thesis claims, measured on this machine"
	@echo "make study      every solver against exact solutions: out/study"
	@echo "make figures-of-docs   measure the figures of README and docs/ again, on a machine that does nothing else; an hour"
	@echo "make bench      time every stage of a frame"
	@echo "make stress     the whole stability matrix of both solvers, some 38,000 cases"
	@echo "make check-against-mitsuba   the same strands by a path tracer, in an environment of its own; best beside libllvm19"
	@echo "make check-against-blender   .abc and .usd in Blender and back, in an environment of its own; 400 MB, Python 3.11 or 3.13"
	@echo "make faults     every place where a command writes fails once in every way; some minutes"
	@echo "make kills      200 renders killed at random moments, 20 ended by SIGTERM; some minutes"
	@echo "make dask       workers of real Dask clusters, one of them killed, in an environment of its own"
	@echo "make plan-figures   memory and time as planned beside those that runs take; some minutes"
	@echo "make fuzz       read damaged files of all that strandcli reads, 100,000 of each format and kind; hours"
	@echo "make golden     compare small pictures of all presets with tests/golden"

demo: $(READY)
	$(RUN) render hair -o out/demo --animate gif --overwrite
	@echo "See out/demo/frame_0001.png and out/demo/animation.gif"

# bytecode is kept, though the environment forbid it as images for containers do: the tests start a hundred processes,
# and each would compile all of Numba's Python again, two seconds
test: $(READY)
	PYTHONDONTWRITEBYTECODE= $(BIN)/python -m pytest $(or $(ARGS),-n 2 --dist loadfile)

test-long: $(READY)
	PYTHONDONTWRITEBYTECODE= $(BIN)/python -m pytest -m long $(or $(ARGS),-n 2 --dist loadfile)

OLDEST := .venv-oldest
OLDEST_NUMBA := $(shell sed -n 's/.*"numba>=\([0-9.]*\)".*/\1/p' pyproject.toml)

test-oldest: $(OLDEST)/.ready
	PYTHONDONTWRITEBYTECODE= $(OLDEST)/bin/python -m pytest -q tests/jit/test_cache.py tests/jit/test_service.py
	PYTHONDONTWRITEBYTECODE= $(OLDEST)/bin/strandcli golden check tests/golden headline minimal

$(OLDEST)/.ready: pyproject.toml
	$(PYTHON) -m venv $(OLDEST)
	$(OLDEST)/bin/python -m pip install --quiet --upgrade pip
	$(OLDEST)/bin/python -m pip install --quiet --no-compile --group kernels --editable . "numba==$(OLDEST_NUMBA).0"
	@touch $@

lint: $(READY)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check --quiet .

types: $(READY)
	$(BIN)/mypy

check: lint types test

all: export STRANDCLI_TEST_EXAMPLES = 100
all: lint types test test-long test-oldest coverage bounds threads wheel unwritable docs

WHEEL := out/wheel
PACKED ?= all
CPU := $(if $(filter x86_64,$(shell uname -m)),x86-64-v3,generic)

# built with the kernels of presets, installed into an empty environment, and drawing from there without compiling
wheel: $(READY)
	rm -rf $(WHEEL)
	$(RUN) warmup $(PACKED) --cpu $(CPU) --pack $(WHEEL)/kernels.pack
	STRANDCLI_PACK=$(WHEEL)/kernels.pack $(BIN)/python -m pip wheel --quiet --no-deps --wheel-dir $(WHEEL) .
	$(PYTHON) -m venv $(WHEEL)/venv
	$(WHEEL)/venv/bin/python -m pip install --quiet $(WHEEL)/*.whl
	cd $(WHEEL) && STRANDCLI_CACHE_DIR=cache venv/bin/strandcli render minimal -f 1-2 -o frames
	test -z "$$(find $(WHEEL)/cache -name '*.kernel')"
	cd $(WHEEL) && STRANDCLI_CACHE_DIR=cache venv/bin/strandcli doctor

kernel-costs: $(READY)
	$(BIN)/python tests/kernel_costs.py $(COSTS)

# a home that is no folder: kernels are kept nowhere, and the run goes on
unwritable: $(READY)
	HOME=/dev/null XDG_CACHE_HOME=/dev/null/cache $(RUN) render minimal -f 1 --size 64x48 --strands 100 -o out/unwritable --overwrite

# drivers that read, check and write, without Numba's compiler: what they need of it they would not pass. Kernels are
# LLVM's, and do not run without it
WITHOUT_JIT := tests/scene tests/output tests/cameras tests/run/test_named_files.py tests/run/test_plan.py \
  tests/run/test_plan_memory.py tests/cli/test_plan_contact.py \
  tests/cli/test_look.py::test_ffmpeg_is_handed_every_frame_for_its_time
WITH_JIT := output/test_layers.py cameras/test_film.py cameras/test_usd_cameras.py cameras/test_usd_commands.py \
  output/test_files.py::test_a_second_run_is_refused_in_one_line_before_anything_is_computed \
  run/test_named_files.py::test_the_key_of_a_file_stands_before_what_is_wrong_with_it \
  run/test_plan.py::test_a_frame_has_no_more_segments_than_planned
COVERED := 'strandcli/scene/*,strandcli/output/*,strandcli/cameras/*'

MEASURED := .venv-coverage

coverage: $(MEASURED)/.ready
	NUMBA_DISABLE_JIT=1 $(MEASURED)/bin/python -m coverage run --source=strandcli -m pytest -q $(WITHOUT_JIT) \
	  $(foreach one,$(WITH_JIT),--deselect=tests/$(one))
	$(MEASURED)/bin/python -m coverage report --include=$(COVERED) --skip-covered --fail-under=90

$(MEASURED)/.ready: pyproject.toml
	$(PYTHON) -m venv $(MEASURED)
	$(MEASURED)/bin/python -m pip install --quiet --upgrade pip
	$(MEASURED)/bin/python -m pip install --quiet --group coverage --editable .
	@touch $@

# every index of every kernel is looked at; minutes of compiling, for a cache of its own
bounds: $(READY)
	STRANDCLI_BOUNDS_CACHE=out/bounds $(BIN)/python tests/bounds.py

threads: $(READY)
	STRANDCLI_TEST_THREADS=4 $(BIN)/python -m pytest -q tests/run/test_threads.py -k presets

docs: $(DOCS)/.ready
	$(DOCS)/bin/python -m sphinx --fail-on-warning --keep-going --quiet --builder html docs out/docs
	@echo "See out/docs/index.html"

$(DOCS)/.ready: pyproject.toml
	$(PYTHON) -m venv $(DOCS)
	$(DOCS)/bin/python -m pip install --quiet --upgrade pip
	$(DOCS)/bin/python -m pip install --quiet --group docs
	@touch $@

FIGURES = $(patsubst presets/%.yaml,%,$(sort $(wildcard presets/figures/*.yaml)))

figures: $(READY)
	@for name in $(FIGURES); do \
	  $(RUN) render $$name -o out/$$name --overwrite --quiet || exit $$?; echo "$$name"; \
	done
	$(RUN) sheet $(foreach name,$(FIGURES),out/$(name)) -o out/figures/sheet.png --columns 2 --width 900 --overwrite

GALLERY = hair-10 portrait-1 ponytail-20 fur-36 grass-12 fox-1 curly-1 bob-1 brush-12 rope-30 curls-12

gallery: $(READY)
	@for shot in $(GALLERY); do \
	  $(RUN) render $${shot%-*} -f $${shot#*-} --size 1600x1200 -o out/gallery/$${shot%-*} \
	    --overwrite --quiet || exit $$?; echo "out/gallery/$${shot%-*}"; \
	done

changelog:
	$(PYTHON) changes/fold.py $(VERSION)

figures-of-docs: $(CHECK)/.ready
	$(CHECK)/bin/python docs/figures.py measure $(ONLY)

claims: $(READY)
	$(RUN) claims -o out/claims --overwrite

study: $(READY)
	$(RUN) study --reference all -o out/study --overwrite

bench: $(READY)
	$(RUN) bench --strands 10000

stress: $(READY)
	$(RUN) stress

fuzz: $(READY)
	PYTHONDONTWRITEBYTECODE= $(BIN)/python tests/fuzz.py $(or $(FUZZ),100000)

faults: $(READY)
	STRANDCLI_TEST_FAULTS=all $(BIN)/python -m pytest -q tests/faults

kills: $(READY)
	PYTHONDONTWRITEBYTECODE= $(BIN)/python tests/kills.py

plan-figures: $(READY)
	$(BIN)/python tests/plan_figures.py $(CASES)

DASK := .venv-dask

dask: $(DASK)/.ready
	PYTHONDONTWRITEBYTECODE= $(DASK)/bin/python -m pytest tests/dask_cluster

$(DASK)/.ready: pyproject.toml
	$(PYTHON) -m venv $(DASK)
	$(DASK)/bin/python -m pip install --quiet --upgrade pip
	$(DASK)/bin/python -m pip install --quiet --no-compile --group kernels --editable .[dask]
	@touch $@

golden: $(READY)
	$(RUN) golden check tests/golden

golden-update: $(READY)
	$(RUN) golden update tests/golden
	$(RUN) golden update strandcli/doctor/golden

CHECK := .venv-check

check-against-mitsuba: $(CHECK)/.ready
	$(CHECK)/bin/python -m pytest -s tests/study/test_mitsuba.py

$(CHECK)/.ready: pyproject.toml
	$(PYTHON) -m venv $(CHECK)
	$(CHECK)/bin/python -m pip install --quiet --upgrade pip
	$(CHECK)/bin/python -m pip install --quiet --group dev --editable .[check]
	@touch $@

BLENDER := .venv-blender

check-against-blender: $(BLENDER)/.ready
	$(BLENDER)/bin/python -m pytest tests/exchange/test_blender.py

$(BLENDER)/.ready: pyproject.toml
	$(PYTHON) -m venv $(BLENDER)
	$(BLENDER)/bin/python -m pip install --quiet --upgrade pip
	$(BLENDER)/bin/python -m pip install --quiet --group dev --group blender --editable .
	@touch $@

$(READY): pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	  { echo "strandcli needs Python 3.11 or newer: make PYTHON=python3.12 $(MAKECMDGOALS)"; exit 1; }
	@$(PYTHON) -c 'import ensurepip, venv' 2>/dev/null || \
	  { echo "Python's venv module is missing: sudo apt-get install python3-venv"; exit 1; }
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --upgrade pip
	$(BIN)/python -m pip install --quiet --no-compile --group dev --editable .
	@touch $@

clean:
	rm -rf $(VENV) $(OLDEST) $(CHECK) $(BLENDER) $(DASK) $(DOCS) out build dist
