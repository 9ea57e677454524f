# REMODEL planner: every command sets up what it needs. `make help` lists them.
SHELL := /bin/bash
.SHELLFLAGS := -euo pipefail -c
.DEFAULT_GOAL := help
.PHONY: help build demo cabinet harness console film cabinets test test-all install docker generate behaviors unit physics variants rostest lint xml bench-engine bench-planner bench-synthesis bench-console bench-sim bench-vision bench-learning bench-scale docs evaluate-abilities bench-rehearsal schedules chaos campaign clean

# The workspace's own Python first, whatever else the shell has on its path; no other workspace.
export PATH := $(CURDIR)/.venv/bin:/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin
unexport PYTHONPATH PYTHONHOME ROS_PACKAGE_PATH CMAKE_PREFIX_PATH ROS_MASTER_URI VIRTUAL_ENV

demo film: WIRES ?= 6
cabinet: WIRES ?= 52
cabinet: DESIGN ?= $(CABINET)
harness: WIRES ?= 12
SEED ?= 1
# The simulated drivers that a robot's file names, in place of the cell with the skills in its process.
DRIVERS = $(if $(ROBOT),robot:=$(ROBOT) drivers:=true)
CABINET := /usr/share/qelectrotech/examples/tableau_domestique.qet
HARNESS := src/remodel_tasks/examples/harness.yml
PREFIX ?= install
SOURCED := set +u; . devel/setup.sh; set -u;
RESULTS := build/test_results
# quick: what `make test` runs; all: the tests marked slow, too.
TIER ?= quick
# A folder of PACKAGE, wherever below src/ it is.
package_folder = $(or $(wildcard src/$(PACKAGE)/$(1) src/flexbe/$(PACKAGE)/$(1)),$(error no package '$(PACKAGE)' with a folder $(1)))
# Not again for the parts of `make test`, which has built.
BUILD = $(if $(BUILT),,build)

help: ## List the commands
	@grep -hE '^[a-z-]+:.*##' Makefile | sed -E 's/:.*## /\t/' | expand -t 20

.venv/.ready: tools/setup.sh tools/apt-packages.txt requirements.txt requirements-dev.txt
	@tools/setup.sh

build: .venv/.ready ## Set up the machine and build the workspace
	@tools/build.sh
	@case " $(MAKECMDGOALS) " in *" build "*) \
	  echo "Next: make demo, or, to run nodes by hand: source devel/setup.bash";; esac

install: .venv/.ready ## Install the workspace, to run without these sources (PREFIX=/opt/remodel)
	@tools/install.sh $(abspath $(PREFIX))
	@echo "Next: source $(abspath $(PREFIX))/setup.bash; roslaunch remodel_sim cell.launch"

docker: ## Make a container image of Debian 12 with the built workspace, by docker, podman or buildah
	@tool=$$(command -v docker || command -v podman || command -v buildah) || \
	  { echo "make docker: install docker, podman or buildah" >&2; exit 1; }; \
	  $$tool build --tag remodel --file Containerfile .
	@echo "Next: docker run -it --rm --network host remodel make demo"

demo: build ## Wire the first wires of a real cabinet in the simulated cell (WIRES=6 SEED=1; ROBOT=simulated_cabinet: over its drivers' topics); report in out/demo/report.html
	@$(SOURCED) tools/wire_board.sh demo $(CABINET) $(WIRES) '' seed:=$(SEED) $(DRIVERS)

cabinet: build ## Wire all wires of that cabinet, or of yours (WIRES=12 SEED=1 DESIGN=FILE CELL=large_cabinet); report in out/cabinet/report.html
	@$(SOURCED) tools/wire_board.sh cabinet "$(DESIGN)" $(WIRES) '' seed:=$(SEED) $(if $(CELL),cell:=$(CELL)) $(DRIVERS)

harness: build ## Build a harness on a formboard by two robots (WIRES=12 SEED=1); report in out/harness/report.html
	@$(SOURCED) tools/wire_board.sh harness $(HARNESS) $(WIRES) harness_formboard cell:=two_arms_formboard seed:=$(SEED)

console: build ## Start the operator console; one of its buttons starts everything else here, with a sample order
	@$(SOURCED) rosrun remodel_console console

film: build ## Record the demo as the moving picture of the README, docs/demo.webp
	@$(SOURCED) tools/wire_board.sh demo $(CABINET) $(WIRES) '' record:=$(CURDIR)/out/demo/film
	@tools/film.py out/demo/film docs/demo.webp

test: build ## Set up, then lint, unit tests and ROS tests: every rule and every seam once; ends with a count
	@$(SOURCED) tools/run_tests.py

test-all: build ## The same with the tests marked slow: whole wires, campaigns, installs, fuzz; recorded in docs/figures/test-all.jsonl
	@$(SOURCED) tools/run_tests.py --all

generate: .venv/.ready ## Write what is generated from the tables of abilities, error codes and faults
	@tools/generate.py

behaviors: build ## Synthesize the charts of remodel_behaviors again
	@$(SOURCED) rosrun flexbe_synthesizer synthesize src/remodel_behaviors/charts/*.xml

unit: $(BUILD) ## Tests that need no ROS master (PACKAGE=remodel_sim, TIER=all)
	@$(SOURCED) pytest --numprocesses auto --dist loadfile --no-loadscope-reorder --junit-xml=$(RESULTS)/unit.xml \
	  --hypothesis-profile=$(TIER) $(if $(filter quick,$(TIER)),-m "not slow") $(if $(PACKAGE),$(call package_folder,test/unit))

physics: build ## Run the physical tests of the cell (BENCH="-k lay_wire", BENCH="--disturbed -k lay_wire": as in make variants)
	@$(SOURCED) tools/physics.py $(BENCH)

variants: $(BUILD) ## Run the physical tests of make test as other processors calculate, and begun 1e-9 beside; part of test-all
	@$(SOURCED) tools/physics.py --disturbed --jobs 2 --results $(RESULTS)/variants.xml -m "physics and not slow"

rostest: $(BUILD) ## Tests of running nodes, each file on a roscore of its own (PACKAGE=remodel_console, TIER=all)
	@$(SOURCED) ctest --test-dir build --parallel 4 --output-on-failure --no-tests=error \
	  $(if $(filter quick,$(TIER)),--label-exclude slow) $(if $(PACKAGE),--tests-regex '^_ctest_$(PACKAGE)_ros')

lint: .venv/.ready xml ## Style, types of the pure cores, and XML
	@ruff format --check .
	@ruff check .
	@mypy --exclude '/ros/' src/*/src/*/core src/remodel_run/src/remodel_run src/remodel_work/src/remodel_work src/remodel_vision/src/remodel_vision src/remodel_skills/src/remodel_skills src/remodel_pddl/src/remodel_pddl src/remodel_cable_tree/src/remodel_cable_tree/problem.py src/remodel_robot/src/remodel_robot/calibration.py src/remodel_supervision/src/remodel_supervision/supervisors src/flexbe/flexbe_core/src/flexbe_core/engine

xml: .venv/.ready # part of lint, and of a commit
	@find src '(' -name '*.xml' -o -name '*.launch' -o -name '*.xsd' -o -path '*/rostest/*.test' ')' -print0 | \
	  xargs -0 python3 -c 'import sys; from lxml import etree; [etree.parse(file) for file in sys.argv[1:]]'

bench-engine: build build/bench-venv/.ready ## Measure the engine, with peers; figures in docs/figures/engine.jsonl
	@$(SOURCED) benchmarks/engine/run.py --peer build/bench-venv/bin/python --figures docs/figures/engine.jsonl

schedules: build ## Simulate schedules of kills, stalls and commands (BENCH="--count 10000 --seed 0")
	@$(SOURCED) PYTHONPATH="src/remodel_supervision/test:$$PYTHONPATH" python3 -m schedules $(BENCH)

chaos: build ## Disturb running orders at random moments (BENCH="--faults 100 --seed 77 --postgresql")
	@$(SOURCED) benchmarks/supervision/chaos.py $(BENCH)

campaign: build ## Cause every kind of fault, 20 runs each, two policies (BENCH="--kinds slipped --runs 3")
	@$(SOURCED) benchmarks/supervision/campaign.py $(BENCH)

bench-scale: build ## Resume, memory and database size of a run of 5,000 tasks (BENCH="--tasks 500")
	@$(SOURCED) benchmarks/supervision/scale.py $(BENCH)

bench-planner: build build/bench-venv/.ready ## Measure the planner beside GTPyhop and Fast Downward, against its targets (BENCH="--sizes 10 30")
	@$(SOURCED) benchmarks/planner/panels.py --peers build/bench-venv/bin/python $(BENCH)

bench-learning: build ## First-pass yield with learned and with frozen parameters, and the guard rail
	@$(SOURCED) benchmarks/learning/first_pass_yield.py $(BENCH)

bench-rehearsal: build ## Judge forecasts of rehearsals on seeds that they have not seen (BENCH="DESIGN --wires 6 --workers 2")
	@$(SOURCED) benchmarks/rehearsal/judge.py $(BENCH)

bench-synthesis: build ## CPU time of the synthesis by size of the chart, in docs/figures/synthesis.jsonl; 10,000 random charts on the engine (BENCH="--seed 7 --trace")
	@$(SOURCED) benchmarks/synthesis/sizes.py --figures docs/figures/synthesis.jsonl
	@$(SOURCED) PYTHONPATH="src/flexbe_synthesizer/test:$$PYTHONPATH" python3 -m random_charts --count 10000 $(BENCH)

bench-sim: build build/bench-venv/.ready ## Measure the simulated wire against theory, beside MuJoCo and Newton; figures in docs/figures/sim.jsonl
	@$(SOURCED) benchmarks/sim/wire.py --peers build/bench-venv/bin/python --figures docs/figures/sim.jsonl

cabinets: build ## Import strangers' designs, and place six wires of each of ten of them in the simulated cell (BENCH="--wires 0", "FILE --seed 7")
	@$(SOURCED) benchmarks/sim/cabinets.py $(BENCH)

bench-vision: build ## Measure detecting cables and locating components on rendered scenes (BENCH="--scenes 6")
	@$(SOURCED) benchmarks/vision/cables.py $(BENCH)
	@$(SOURCED) benchmarks/vision/components.py labels $(BENCH)
	@$(SOURCED) benchmarks/vision/components.py devices $(BENCH)

evaluate-abilities: build ## Measure the abilities over seeds, against their targets (BENCH="--seeds 0-99 --jobs 2")
	@$(SOURCED) benchmarks/sim/abilities.py $(BENCH)

bench-console: build ## Load of the console at 50 transitions a second, 5 minutes, in docs/figures/console.jsonl (BENCH="--seconds 30")
	@$(SOURCED) benchmarks/console/load.py --figures docs/figures/console.jsonl $(BENCH)

docs: build/docs-venv/.ready ## Build the site of the documentation: build/site/index.html
	@NO_MKDOCS_2_WARNING=1 build/docs-venv/bin/mkdocs build --strict --quiet
	@echo "site: build/site/index.html; with search: python3 -m http.server --directory build/site"

build/docs-venv/.ready: requirements-docs.txt
	@/usr/bin/python3 -m venv build/docs-venv
	@build/docs-venv/bin/pip install -qq --disable-pip-version-check -r $<
	@touch $@

build/bench-venv/.ready: requirements-bench.txt | build
	@/usr/bin/python3 -m venv build/bench-venv
	@build/bench-venv/bin/pip install -qq --disable-pip-version-check -r $<
	@touch $@

clean: ## Remove what was built; keeps .venv
	@rm -rf build devel install out src/CMakeLists.txt
