# Two commands set everything up: `make demo` and `make test`. Both need Python >= 3.11 only.
# They install what requirements.lock names; with `LOCK=`, the newest that pyproject.toml allows.

PYTHON ?= python3
VENV   ?= .venv
LOCK   ?= requirements.lock
BIN    := $(VENV)/bin
PIP    := $(BIN)/python -m pip install --quiet --no-build-isolation

comma  := ,
LOCKED := $(if $(LOCK),--require-hashes --no-deps,--upgrade --upgrade-strategy eager)
PINS   := $(if $(LOCK),build/pins.txt)
PINNED := $(if $(LOCK),PIP_CONSTRAINT=$(CURDIR)/$(PINS) PIP_BUILD_CONSTRAINT=$(CURDIR)/$(PINS))
TOOLS  := build$(if $(filter never,$(PIRATE_SM_BUILD)),,$(comma)machine-code)

export PIP_DISABLE_PIP_VERSION_CHECK := 1

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.PHONY: help demo gallery wheel update test test-thorough test-cluster test-pty test-browser test-firmware test-built test-wheel check format golden docs pictures schemas vscode bench seeds kills resume bends soak defects loops upright align maps belief robots campaigns space twin learning mistakes mutants physics vision thesis clean

help:
	@echo "make demo    the bend mission in the simulator, slow enough to watch"
	@echo "make gallery ten scenes at full speed, and runs/demo/index.html with their reports"
	@echo "make test    style, types, layers and tests"
	@echo "make test-thorough  every mission, guide and scene to its end, and more examples of each property"
	@echo "make test-browser  a report's page in the Chromium that is installed"
	@echo "make test-firmware  the firmware of the controller: its parts, and what is flashed in a simulated controller"
	@echo "make test-cluster  campaigns on a Dask cluster of processes, some of which are killed"
	@echo "make test-built  the simulator's machine code, and the package as it is installed"
	@echo "make test-wheel  the wheel in dist/ in an empty environment: a mission, its report, a scene"
	@echo "make test-pty the conformance suite, the firmware, the guide to a real robot and ten tasks at the console in real time, over pseudo-terminals"
	@echo "make bench   what people wait for, beside its goals and an earlier commit"
	@echo "make seeds   the bend in many pipes, up to 1,000 seeds each"
	@echo "make campaigns  what campaigns cost: two workers beside one, the client, memory; and one that is disturbed beside one left alone"
	@echo "make space   how often each fitting of a round pipe is passed, by 100 seeds each"
	@echo "make belief  missions that claim a distance or a place, with any defects in any pipe, judged by the truth"
	@echo "make robots  the bend with robots of other motors, springs and friction"
	@echo "make maps    how far maps of driven pipes are from these, by 10 seeds each"
	@echo "make align   how level a part comes that is turned by the accelerometer, from twelve rolls, and the mission level"
	@echo "make upright up and down an upright pipe, clamped as friction asks for and by a fixed torque, over a bad line and without"
	@echo "make twin    the numbers of simulated robots, found in ten-minute recordings of them"
	@echo "make learning an agent that learns the bend, refusals in random play, and steps per second"
	@echo "make physics MuJoCo beside the kinematic simulator, its speed, and the bend in many pipes"
	@echo "make thesis  the thesis's experiments again, every verdict into docs/explanation/thesis.json and its page"
	@echo "make vision  what a synthetic camera sees of the bend, its speed, and the calibration of a lens"
	@echo "make defects every known defect of the robot, in several missions"
	@echo "make soak    100,000 commands over a bad link to the emulated bay, in virtual time"
	@echo "make kills   the bend in real time, and something dies at a random moment of it"
	@echo "make resume  missions cut off at random moments on the emulated bay, and resumed"
	@echo "make loops   velocity and torque loops over a bad link to the emulated bay"
	@echo "make bends   the bend in real time, and nothing goes wrong"
	@echo "make mistakes 650 mistakes in files, to be reported on their line, and odd but correct files; also in an editor"
	@echo "make mutants 250 small faults in the code, to be found by the tests (an hour)"
	@echo "make golden  the golden traces, help texts and pictures of screens anew, after a change that is meant"
	@echo "make docs    the documentation site, in build/site, with warnings as errors"
	@echo "make pictures the documents' pictures of pages in Chromium, of Neovim and of cameras anew"
	@echo "make schemas the JSON Schemas anew, after a change of models or of a robot"
	@echo "make vscode  the extension for Visual Studio Code, build/pirate-sm.vsix; it needs npm"
	@echo "make format  every Python file in the one style"
	@echo "make update  requirements.lock with the newest of everything, and the tests with it"
	@echo "make wheel   the wheel for this kind of machine, and the source archive, in dist/"
	@echo "make clean   the tree without environments and caches"

demo: $(VENV)/.ready-sim
	$(BIN)/pirate-run sequences/mitre_bend.yaml --backend sim --speed 4

gallery: $(VENV)/.ready-dev
	$(BIN)/pirate demo --all

# Where an environment forbids to store compiled modules, each of the tests' 200 processes would
# compile the package again.
test: check
	PYTHONDONTWRITEBYTECODE= $(BIN)/python -m pytest -n auto --maxprocesses 4 --dist worksteal

# What the default tests take a few of: every shipped mission, every guide and scene to its end, what
# takes about a second, and more examples of each property.
test-thorough: $(VENV)/.ready-dev
	PYTHONDONTWRITEBYTECODE= HYPOTHESIS_PROFILE=thorough $(BIN)/python -m pytest -n auto --maxprocesses 4 \
	    --dist worksteal -m "(thorough or hypothesis) and not slow and not browser and not firmware"

# It needs g++; what is flashed is built and run where avr-g++ and simavr are. `make test-thorough` has its
# parts and the build too, so the build of this project leaves them out here, and takes a quarter of the rides.
FIRMWARE ?= firmware or thorough
test-firmware: $(VENV)/.ready-dev
	$(BIN)/python -m pytest -n auto --maxprocesses 4 --dist worksteal -m "$(FIRMWARE)" tests/firmware

test-browser: $(VENV)/.ready-browser
	$(BIN)/python -m pytest -m browser tests/browser

# The archive and the wheel of this machine; they need PIRATE_SM_BUILD=always to hold its kernel.
wheel: $(VENV)/.tools-$(TOOLS)
	$(BIN)/python -m pip wheel --quiet --no-deps --no-build-isolation --wheel-dir dist .
	$(BIN)/python -c "from hatchling.build import build_sdist; print(build_sdist('dist'))"

check: $(VENV)/.ready-dev
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy
	$(BIN)/lint-imports

test-pty: $(VENV)/.ready-dev
	$(BIN)/python -m pytest -m "slow and not firmware" tests/conformance tests/firmware tests/test_how_to.py tests/console/test_ten_tasks.py

test-cluster: $(VENV)/.ready-dev
	$(BIN)/python -m pytest -m slow tests/unit/lab/campaign

test-built: $(VENV)/.ready-dev $(PINS)
	$(PINNED) $(BIN)/python -m pytest -m slow tests/unit/simulation/machine_code tests/installation

# Nothing of the source tree is used: neither its modules nor its environment.
test-wheel: $(PINS)
	rm -rf build/installed
	$(PYTHON) -m venv build/installed
	$(PINNED) build/installed/bin/python -m pip install --quiet dist/*.whl
	cd build/installed && bin/pirate-run mitre_bend --quiet --record bend.mcap
	cd build/installed && bin/pirate report bend.mcap
	cd build/installed && bin/pirate demo tee

format: $(VENV)/.ready-dev
	$(BIN)/ruff check --fix
	$(BIN)/ruff format

golden: $(VENV)/.ready-dev
	GOLDEN=write $(BIN)/python -m pytest --quiet -m "not slow and not browser" tests/golden
	GOLDEN=write $(BIN)/python -m pytest --quiet -k documents tests/console tests/unit/cli tests/unit/views/showing
	GOLDEN=write $(BIN)/python -m pytest --quiet -k draws tests/test_tutorial.py

docs: $(VENV)/.ready-docs
	NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build --quiet --strict
	$(BIN)/python -m website.built_site build/site

pictures: $(VENV)/.ready-pictures
	$(BIN)/python -m website.pictures

schemas: $(VENV)/.ready-dev
	for kind in mission pipe profile chart profile_extension chart_extension camera panel campaign scene twin; do \
	    $(BIN)/pirate schema $$kind > schemas/$$kind.schema.json || exit; done
	for robot in hardware_profiles/*/; do \
	    $(BIN)/pirate schema mission --robot $$robot > $${robot}mission.schema.json || exit; done

# Nothing of what is fetched is run but the packer.
vscode:
	@mkdir -p build
	cd editors/vscode && cp ../../LICENSE . && npm ci --ignore-scripts --no-audit --no-fund && npm run --silent pack

bench: $(VENV)/.ready-bench
	$(BIN)/python -m benchmarks.bench

seeds: $(VENV)/.ready-campaign
	$(BIN)/pirate campaign campaigns/bend.yaml --resume

upright: $(VENV)/.ready-sim
	$(BIN)/python -m benchmarks.upright

belief: $(VENV)/.ready-sim
	$(BIN)/python -m benchmarks.belief

robots: $(VENV)/.ready-sim
	$(BIN)/python -m benchmarks.robots

maps: $(VENV)/.ready-sim
	$(BIN)/python -m benchmarks.maps

space: $(VENV)/.ready-sim
	$(BIN)/python -m benchmarks.space

align: $(VENV)/.ready-sim
	$(BIN)/python -m benchmarks.align

twin: $(VENV)/.ready-sim
	$(BIN)/python -m benchmarks.twin
	$(BIN)/python -m benchmarks.twin --predict --first 200 --seeds 3 --times 4 --robots 19

learning: $(VENV)/.ready-learning
	$(BIN)/python -m benchmarks.learning
	$(BIN)/python -m pytest -m slow tests/unit/lab/learning

physics: $(VENV)/.ready-physics
	$(BIN)/python -m benchmarks.physics
	$(BIN)/python -m benchmarks.physics_properties
	$(BIN)/pirate campaign campaigns/bend_physics.yaml --resume
	$(BIN)/python -m benchmarks.physics_agreement

# The command exits with 1 where a value is contradicted, which the page tells.
thesis: $(VENV)/.ready-dev
	mkdir -p build
	$(BIN)/pirate experiment all --format json > build/thesis.json || test $$? = 1
	mv build/thesis.json docs/explanation/thesis.json
	GOLDEN=write $(BIN)/python -m pytest --quiet tests/golden/test_thesis_page.py

vision: $(VENV)/.ready-vision
	$(BIN)/python -m benchmarks.vision

defects: $(VENV)/.ready-campaign
	$(BIN)/pirate campaign campaigns/defects.yaml --resume
	$(BIN)/pirate campaign campaigns/joint_defects.yaml --resume
	$(BIN)/pirate campaign campaigns/late_values.yaml --resume

campaigns: $(VENV)/.ready-campaign
	$(BIN)/python -m benchmarks.campaigns
	$(BIN)/python -m benchmarks.campaign_kills

soak: $(VENV)/.ready-soak
	$(BIN)/python -m benchmarks.soak

kills: $(VENV)/.ready-soak
	$(BIN)/python -m benchmarks.kills

resume: $(VENV)/.ready-soak
	$(BIN)/python -m benchmarks.resume

bends: $(VENV)/.ready-soak
	$(BIN)/python -m benchmarks.bends

loops: $(VENV)/.ready-soak
	$(BIN)/python -m benchmarks.loops

mistakes: $(VENV)/.ready-dev
	$(BIN)/python -m benchmarks.mistakes
	$(BIN)/python -m pytest -n auto --maxprocesses 4 --dist worksteal -m slow tests/unit/views/editor

mutants: $(VENV)/.ready-mutants
	$(BIN)/python -m benchmarks.mutants

clean:
	rm -rf $(VENV) build dist .hypothesis .import_linter_cache .mypy_cache .pytest_cache .ruff_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
	find pirate_sm -name functions.library -delete -o -name not_built.txt -delete

update: $(VENV)/.created
	$(BIN)/python locked.py requirements.lock lock > $(VENV)/lock.txt
	$(PIP) --require-hashes --no-deps -r $(VENV)/lock.txt
	$(BIN)/uv pip compile --quiet --no-config --upgrade --universal --all-extras --group build --group machine-code \
	    --group lock --generate-hashes --no-header --no-emit-index-url -o $(VENV)/newest.lock pyproject.toml
	mv $(VENV)/newest.lock requirements.lock
	$(MAKE) test

# For environments that pip makes itself, which it compares with no hashes.
build/pins.txt: $(LOCK)
	@mkdir -p build
	@sed -e '/--hash=/d' -e 's/ *\\$$//' $(LOCK) > $@

# One environment; each set of extras is installed once, and again when pyproject.toml or the lock
# changes. The simulator's machine code is built with it, by tools that are locked too. The extra
# `jit` serves trees whose sources have changed.
$(VENV)/.ready-sim: EXTRAS := jit
$(VENV)/.ready-dev: EXTRAS := dev,docs,jit,campaign,falsify,sensitivity,physics,gym,serial,live,vision,lsp,page
$(VENV)/.ready-physics: EXTRAS := jit,physics,campaign,fit
$(VENV)/.ready-campaign: EXTRAS := jit,campaign
$(VENV)/.ready-learning: EXTRAS := dev,jit,gym
$(VENV)/.ready-browser: EXTRAS := browser,dev,jit,page
$(VENV)/.ready-docs: EXTRAS := docs,jit,gym
$(VENV)/.ready-pictures: EXTRAS := browser,campaign,jit,lsp,vision
$(VENV)/.ready-bench: EXTRAS := bench,jit,campaign,gym
$(VENV)/.ready-vision: EXTRAS := jit,vision
$(VENV)/.ready-soak: EXTRAS := jit,serial
$(VENV)/.ready-mutants: EXTRAS := mutants,dev,docs,jit,campaign,falsify,sensitivity,physics,serial,live,vision,lsp,page

$(VENV)/.ready-%: pyproject.toml hatch_build.py $(LOCK) | $(VENV)/.tools-$(TOOLS)
	@echo "Installing pirate_sm with its extras [$(EXTRAS)] into $(VENV) (takes a minute, once) ..."
	@$(BIN)/python locked.py '$(LOCK)' $(EXTRAS) > $@.txt
	@$(PIP) $(LOCKED) -r $@.txt
	@$(PIP) --no-deps -e .
	@touch $@

$(VENV)/.tools-%: pyproject.toml $(LOCK) locked.py | $(VENV)/.created
	@$(BIN)/python locked.py '$(LOCK)' $* > $@.txt
	@$(PIP) $(LOCKED) -r $@.txt
	@touch $@

$(VENV)/.created:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' \
	    || { echo "$(PYTHON) is not Python >= 3.11; name one: make PYTHON=python3.12" >&2; exit 2; }
	@echo "Creating a Python environment in $(VENV) ..."
	@$(PYTHON) -m venv $(VENV)
	@touch $@
