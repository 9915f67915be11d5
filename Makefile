# make demo    the E62 at 650 r/min: tables on the terminal, plots and data in out/ (extra `view`)
# make test    the tests, without the longer ones (extras `all` and `dev`)
# make test-all    these and the longer ones: pages in a browser, clusters, campaigns
# make test-slow   the longer ones alone, of campaigns a seventh by the day
# make snapshots   the reviewed texts of tests/**/__snapshots__ anew; read the difference
# make docs    the site of docs/ in out/site; any warning is an error
# make check   lint, types, site and all tests
# make benchmark   the benchmark of this machine (some minutes), and its page in docs/
# make stress    a thousand random and extreme cases, each judged (minutes)
# make pictures    the pictures of the documents and the page of notation, made anew (some minutes; needs Chromium)
# make clean   removes .venv, out and what the tools leave behind

PYTHON ?= python3
PYTEST_ARGS ?= -n 2
DAY ?= $(shell expr $$(date +%s) / 86400)

VENV := .venv
BIN := $(VENV)/bin
VIEW := $(VENV)/.installed-view
DEV := $(VENV)/.installed-dev
SITE := $(VENV)/.installed-docs
SIMULATE := $(BIN)/nipper-pin simulate e62 --speed 650
# What is compiled is kept, whatever the user's other programs do: or each worker compiles all tests
# on each run, and every command that a test starts the whole package.
unexport PYTHONDONTWRITEBYTECODE

# hatchling builds the package; it comes from the lock like everything else, so pip need not make
# a second environment of unlocked packages to build in.
PIP_INSTALL := $(BIN)/python -m pip install -q --disable-pip-version-check -c constraints.txt

IMAGES := docs/images
FIGURES := $(BIN)/python scripts/maintain/figures
# Compiled once, before workers would do it at the same time, and anew where its sources change.
MACHINE_CODE := $(VENV)/.machine-code
COMPILED := $(wildcard nipper_pin/reduced/kernels/*.py nipper_pin/tolerances/*.py)
# Plots that `make pictures` draws as PNG files.
PLOTS := $(addprefix $(IMAGES)/,$(addsuffix .png,cycle_650 transition impulses phases speed_limit \
  front_e62 main_effects_duration_s level_lines_duration_s))

.PHONY: demo test test-slow test-all snapshots lint types docs check pictures benchmark stress clean
# Every target shares one environment, which only one pip may change at a time.
.NOTPARALLEL:
.DELETE_ON_ERROR:

demo: $(VIEW)
	$(SIMULATE) --out out/demo-transition
	$(SIMULATE) --window cycle --out out/demo-cycle
	$(BIN)/nipper-pin view --solution out/demo-cycle/solution.npz --html out/demo.html
	@echo "open out/demo.html in a browser: the nipper and its rebounds"

# In the order of their names: files of few tests, which may be long ones, are not left to the end.
test: $(MACHINE_CODE)
	$(BIN)/python -m pytest -m "not slow" $(PYTEST_ARGS) --dist loadfile --no-loadscope-reorder

test-slow: $(MACHINE_CODE)
	$(BIN)/python -m pytest -m slow --day $(DAY) $(PYTEST_ARGS) --dist loadfile

test-all: test
	$(BIN)/python -m pytest -m slow $(PYTEST_ARGS) --dist loadfile

snapshots: $(DEV)
	$(BIN)/python -m pytest -q --snapshot-update $$(grep -rlE 'import .*Words' --include='test_*.py' tests)

lint: $(DEV)
	$(BIN)/ruff check .

types: $(DEV)
	$(BIN)/mypy

docs: $(SITE)
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict

check: lint types docs test-all

benchmark: $(DEV)
	$(BIN)/python -m benchmarks run --out out/benchmark
	$(FIGURES)/write_benchmark_page.py out/benchmark
	$(FIGURES)/shrink_pictures.py $(IMAGES)/work_precision.png

stress: $(DEV)
	$(BIN)/python -m benchmarks stress

# All pictures of docs/images.
pictures: $(DEV)
	rm -rf out/pictures
	$(FIGURES)/draw_gallery.py docs
	$(BIN)/nipper-pin check e62 --drawing $(IMAGES)/mechanism.svg
	$(SIMULATE) --window cycle --out out/pictures/cycle
	cp out/pictures/cycle/motion.png $(IMAGES)/cycle_650.png
	cp out/pictures/cycle/transition.png out/pictures/cycle/impulses.png out/pictures/cycle/phases.png $(IMAGES)/
	$(BIN)/nipper-pin speed-limit --from 300 --to 2000 --speeds 1000 --plot $(IMAGES)/speed_limit.png
	$(BIN)/nipper-pin view --window transition --speed 650 --gif $(IMAGES)/rebounds.gif
	$(BIN)/python scripts/maintain/measure/measure_conditioning.py --out $(IMAGES)/conditioning.svg
	$(BIN)/nipper-pin optimise scripts/optimise_rebound.toml --format png --out out/pictures/front
	cp out/pictures/front/front.png $(IMAGES)/front_e62.png
	sed 's/count = 100_000/count = 10_000/' scripts/sweep_spring.toml > out/pictures/sweep.toml
	$(BIN)/nipper-pin sweep out/pictures/sweep.toml --out out/pictures/sweep
	$(BIN)/nipper-pin plot out/pictures/sweep --format png --out out/pictures/sweep_plots
	cp out/pictures/sweep_plots/*.png $(IMAGES)/
	$(FIGURES)/shrink_pictures.py $(PLOTS)
	$(BIN)/python scripts/maintain/in_browser/draw_view_pictures.py $(IMAGES)
	$(FIGURES)/write_quantity_page.py docs

$(VIEW): pyproject.toml constraints.txt
	@command -v "$(PYTHON)" >/dev/null || { \
	  echo "make: there is no '$(PYTHON)'; name a Python of 3.11 or later: make PYTHON=python3.12" >&2; \
	  exit 1; }
	@"$(PYTHON)" -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { \
	  echo "make: $$("$(PYTHON)" --version 2>&1) is too old or does not run;" \
	    "name a Python of 3.11 or later: make PYTHON=python3.12" >&2; \
	  exit 1; }
	@"$(PYTHON)" -c 'import venv, ensurepip' 2>/dev/null || { \
	  echo "make: '$(PYTHON)' cannot make environments; install its venv module" \
	    "(on Debian and Ubuntu the package python3-venv)" >&2; \
	  exit 1; }
	@echo "installing into $(VENV)"
	@"$(PYTHON)" -m venv $(VENV)
	@$(PIP_INSTALL) hatchling
	@$(PIP_INSTALL) --no-build-isolation -e '.[view]'
	@touch $@

$(DEV): $(VIEW)
	@echo "installing the tools for development into $(VENV)"
	@$(PIP_INSTALL) --no-build-isolation -e '.[dev]'
	@touch $@

$(MACHINE_CODE): $(DEV) $(COMPILED)
	$(BIN)/python tests/machine_code.py
	@touch $@

$(SITE): $(DEV)
	@echo "installing what builds the site into $(VENV)"
	@$(PIP_INSTALL) --no-build-isolation -e '.[docs]'
	@touch $@

clean:
	rm -rf $(VENV) out build dist .pytest_cache .mypy_cache .ruff_cache .hypothesis
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
