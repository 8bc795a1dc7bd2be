# Everything a newcomer needs: `make demo`, `make test-quick`, `make test`. The rest is for working on the project.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
TREES := $(patsubst %/__init__.py,%,$(wildcard */__init__.py))
PYX := $(shell find $(TREES) -name '*.pyx')
NATIVE := $(PYX) $(shell find $(TREES) -path '*/native/*' \( -name '*.[ch]' -o -name '*.def' \) -not -path '*/build/*')

# Bytecode beside the sources: where Python may not write it (PYTHONDONTWRITEBYTECODE), each start of hil would compile them.
BYTECODE = $(if $(PYTHONDONTWRITEBYTECODE),$(BIN)/python -m compileall -q -j 0 -x /tests/ $(TREES),:)

.PHONY: demo kit release abi test test-quick test-thorough test-native wheels test-load test-system test-pyserial test-web web web-check web-types lint site reference keywords deb test-deb test-container test-hosts soak soak-load soak-mixed kills fuzz bench bench-docs clean install-service uninstall-service

demo: $(VENV)/.base
	@$(BIN)/hil serve examples/demo.yaml

test: $(VENV)/.dev
	@echo "The tests: ten minutes on two cores. \`make test-quick\` has a part of them: a minute."
	@$(BYTECODE)
	@$(MAKE) --no-print-directory test-native
	@$(SIDE_BY_SIDE) -n 5 -m "not thorough" --reruns 1  # more workers than CPUs: most tests wait

# The longer ones, which make no part of the others: a quarter of an hour on two cores.
test-thorough: $(VENV)/.dev
	@$(BYTECODE)
	@$(SIDE_BY_SIDE) -n 4 -m thorough

# Those beside the code, without those that are marked as long.
test-quick: $(VENV)/.dev
	@echo "The quick tests: about a minute on two cores."
	@$(SIDE_BY_SIDE) -n $$(nproc) -m "not long and not thorough" $(TREES)

# Each worker imports all tests, which pytest rewrites first: what the first has made of them, the others read.
SIDE_BY_SIDE = PYTHONDONTWRITEBYTECODE= $(BIN)/python -m pytest -q --dist loadfile --no-loadscope-reorder

# The page of the web door, built into the door's folder: commit what it writes. Needs Node 20.
web: web/node_modules
	cd web && npm run -s build

# Types of what the door tells: commit what it writes.
web-types: $(VENV)/.base
	$(BIN)/python write_web_types.py

# The page's lint and unit tests, and whether what is built is what the sources make. Needs Node 20.
web-check: web/node_modules
	cd web && npm -s run lint
	cd web && npm -s test
	out=$$(mktemp -d) && trap 'rm -rf "$$out"' EXIT && cd web && HIL_WEB_OUT="$$out" npm run -s build && diff -r "$$out" ../bridges/web/static

web/node_modules: web/package-lock.json
	@command -v npm >/dev/null || { echo "npm is missing: sudo apt install nodejs npm"; exit 1; }
	cd web && npm ci --no-audit --no-fund
	@touch $@

# The page in Chromium, at doors of benches that run: three minutes. Needs Chromium: sudo apt install chromium.
# What an older Node than 20 installs is not tried: accessibility is skipped. What fails is tried once more, alone; the last line says what
# passed so, and more than three in a hundred of the tests fail the whole.
test-web: $(VENV)/.dev
	@! $(HAS_NODE) || $(MAKE) -s --no-print-directory web/node_modules
	@$(BIN)/python tests/browser/run_twice.py tests/browser/browser_*.py

HAS_NODE = { command -v npm && node -e 'process.exit(Number(process.versions.node.split(".")[0]) < 20 ? 1 : 0)'; } >/dev/null 2>&1

# The C alone: no Python, under the address, undefined-behaviour and thread sanitizers.
test-native:
	@$(MAKE) -s --no-print-directory -j $$(nproc) -C hil/core/native/tests

lint: $(VENV)/.dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/python check_prose.py

# The pages as a site in build/site, with search; each link in it leads somewhere. Half a minute.
site: $(VENV)/.dev
	@$(BIN)/python write_site.py

# What the wheel has for others than Python: where each looks for it below PREFIX/share.
SHARED := man/man1/hil.1 bash-completion/completions/hil.bash zsh/site-functions/_hil fish/vendor_completions.d/hil.fish

# hil with its test kit for another project: a wheel in dist, or VENV=FOLDER installs it in that venv. Taken from .venv's build.
kit:
	@$(MAKE) -s --no-print-directory VENV=.venv .venv/.base
	@packaging/kit .venv $(if $(filter-out .venv,$(VENV)),"$(VENV)")

# What a release consists of, in dist/release, with the text of its page and checksums.
release:
	@$(PYTHON) packaging/release.py

# Wheels as users get them, one for each CPython here: built, installed without a compiler, the main job run from each.
wheels:
	packaging/build-wheels

# Floods, deaf clients, no file left: what others on the bench notice of it, beside a bench without. Two minutes.
test-load: $(VENV)/.dev
	$(BIN)/python -m pytest -q tests/load_e2e.py

# What Cython and Python know of the native core's face, from its table and headers.
abi: $(VENV)/.base
	$(BIN)/python write_abi.py

# docs/reference.md, docs/commands.md, the man page and the shells' completions, from the tables in the code.
reference: $(VENV)/.base
	$(BIN)/hil reference > docs/reference.md
	$(BIN)/hil reference --man > docs/hil.1
	$(BIN)/hil reference --commands > docs/commands.md
	$(BIN)/hil completion bash > completions/hil.bash
	$(BIN)/hil completion zsh > completions/_hil
	$(BIN)/hil completion fish > completions/hil.fish

# docs/robot-keywords.md, from what Robot Framework's libdoc finds in hil.robot.
keywords: $(VENV)/.dev
	$(BIN)/python -m hil.robot.keyword_page > docs/robot-keywords.md

# dist/hil_*.deb, with all that hil imports; for the Debian release of this machine.
deb:
	packaging/deb/build

# The package in a Debian tree of its own: installed without a network, used, upgraded, removed, purged. As root.
test-deb: $(VENV)/.dev
	$(BIN)/python -m pytest -q -p no:cacheprovider -rs tests/packaging/deb_in_a_tree.py

# The container's image, built and run without any rights; clients from outside. As root.
test-container: $(VENV)/.dev
	$(BIN)/python -m pytest -q -p no:cacheprovider -rs tests/packaging/container_alone.py

# Benches, routers and users on computers of their own: network namespaces on a switch whose links are slow, lose frames
# and are cut. As root: about five minutes. What this machine cannot do is skipped.
test-hosts: $(VENV)/.dev
	$(BIN)/python -m pytest -q -p no:cacheprovider -rsx tests/hosts/lab_*.py

# The service in booted systems: Debian in a container (systemd-nspawn), and in QEMU with a real-time kernel. As root; what
# this machine cannot do is skipped. CUTS=300 is the long mode of the power cuts.
test-system: $(VENV)/.dev
	HIL_POWER_CUTS=$(or $(CUTS),60) $(BIN)/python -m pytest -q -p no:cacheprovider -rs tests/system/boot_*.py hil/testing/seeds/tests/boot_farm.py

# pyserial's own tests, of its source package, at a port of a bench and at a bare pty. A minute, and a download.
test-pyserial: $(VENV)/.dev
	$(BIN)/python tests/system/pyserial_own_tests.py

# hil in a venv of its own, and the systemd units. DESTDIR is for packages: nothing is started then.
# Where homes are, ProtectHome= of the units shows nothing: systemd.exec(5).
PREFIX ?= /usr/local
FOR_ALL = umask 022; env -u PYTHONPATH -u PYTHONHOME
install-service:
	@case "$$($(PYTHON) -c 'import sys; print(sys.base_prefix)')" in /home/*|/root/*) \
	  echo "$(PYTHON) is below a home, which a service does not see: PYTHON=/usr/bin/python3 make install-service"; exit 1;; esac
	@$(if $(WHEEL),,$(PYTHON) packaging/build_venv.py --check)
	@umask 022; mkdir -p $(DESTDIR)$(PREFIX)/lib 2>/dev/null && [ -w $(DESTDIR)$(PREFIX)/lib ] || { \
	  echo "hil: not installed, $(DESTDIR)$(PREFIX)/lib cannot be written: sudo make install-service, or name a PREFIX"; exit 1; }
	@echo "[1/3] a venv in $(DESTDIR)$(PREFIX)/lib/hil"
	@$(FOR_ALL) $(PYTHON) -m venv --clear $(DESTDIR)$(PREFIX)/lib/hil
	@echo "[2/3] hil$(if $(WHEEL),, and its C: what \`make demo\` has compiled for this Python is taken), and the packages that it needs"
	@$(FOR_ALL) PIP_USER=0 $(DESTDIR)$(PREFIX)/lib/hil/bin/pip install -q --disable-pip-version-check --prefer-binary $(or $(WHEEL),.)
	@grep -Il '^#!$(DESTDIR)' $(DESTDIR)$(PREFIX)/lib/hil/bin/* | xargs sed -i '1s|^#!$(DESTDIR)|#!|'
	@echo "[3/3] the command $(PREFIX)/bin/hil, its man page and completions, the units of systemd"
	@umask 022; install -d $(DESTDIR)$(PREFIX)/bin
	@ln -sfn $(PREFIX)/lib/hil/bin/hil $(DESTDIR)$(PREFIX)/bin/hil
	@umask 022; for file in $(SHARED); do \
	  install -d "$(DESTDIR)$(PREFIX)/share/$${file%/*}"; \
	  ln -sfn $(PREFIX)/lib/hil/share/$$file $(DESTDIR)$(PREFIX)/share/$$file; done
	@umask 022; PREFIX=$(PREFIX) DESTDIR=$(DESTDIR) $(DESTDIR)$(PREFIX)/lib/hil/share/hil/systemd/install.sh
	@$(if $(DESTDIR),:,echo "Next: mkdir -p /etc/hil; $(PREFIX)/bin/hil init /etc/hil/bench.yaml; systemctl enable --now hil. More: $(PREFIX)/bin/hil docs service")

uninstall-service:
	PREFIX=$(PREFIX) DESTDIR=$(DESTDIR) $(DESTDIR)$(PREFIX)/lib/hil/share/hil/systemd/install.sh --uninstall
	rm -rf $(DESTDIR)$(PREFIX)/lib/hil $(DESTDIR)$(PREFIX)/bin/hil $(addprefix $(DESTDIR)$(PREFIX)/share/,$(SHARED))

# A minute of real time beside load, replayed on the virtual clock.
soak: $(VENV)/.dev
	HIL_SOAK_S=60 $(BIN)/python -m pytest -q -s tests/test_e2e_replay.py

# Five minutes of packets, as many as the machine can: what of them stays in memory, page faults of the core.
# SOAK_S=3600 for an hour.
soak-load: $(VENV)/.dev
	$(BIN)/python benchmarks/soak.py $(or $(SOAK_S),300)

# Everything at once and at random, seed after seed, each with its replay: five minutes. SOAK_S=3600 for an hour.
soak-mixed: $(VENV)/.dev
	$(BIN)/python tests/soak_mixed.py $(or $(SOAK_S),300)

# Two thousand kills of a store, and two hundred of daemons, each in the middle of a write: half an hour.
kills: $(VENV)/.dev
	HIL_KILLS=2000 $(BIN)/python -m pytest -q -s hil/live/tests/test_nvm_store_kills.py
	HIL_KILLS=200 $(BIN)/python -m pytest -q -s tests/test_e2e_memory.py -k kills

# Ten million damaged streams of packets, as many Modbus requests and a tenth of it on a line (20 minutes), as many frames at a CANopen node (3 minutes), a million random dialogues with the SAC, 10,000 series of commands against the model of its motion,
# 100,000 requests at the control socket, 100,000 damaged logs and programs in G-code, a million dialogues with the Uno, 100,000 operations at a port in memory and at a pty,
# 250 benches with overlapping faults, a million programs for the ATmega328P beside simavr: two and a half hours.
# The suite has from a hundredth to a thousandth of it; FUZZ_SEED=n for other dialogues.
fuzz: $(VENV)/.dev
	HIL_FUZZ=10000000 HIL_FUZZ_SEED=$(or $(FUZZ_SEED),2) $(BIN)/python -m pytest -q device_profiles/sac/tests/test_packet.py -k fuzz
	HIL_FUZZ=1000000 HIL_FUZZ_SEED=$(or $(FUZZ_SEED),2) $(BIN)/python -m pytest -q bridges/modbus/protocol/tests/test_modbus_rtu.py -k fuzz
	HIL_FUZZ=10000000 HIL_FUZZ_SEED=$(or $(FUZZ_SEED),2) $(BIN)/python -m pytest -q bridges/modbus/protocol --ignore=bridges/modbus/protocol/tests/test_modbus_rtu.py -k fuzz
	HIL_FUZZ=10000000 HIL_FUZZ_SEED=$(or $(FUZZ_SEED),2) $(BIN)/python -m pytest -q bridges/modbus/door -k fuzz
	HIL_FUZZ=10000000 HIL_FUZZ_SEED=$(or $(FUZZ_SEED),2) $(BIN)/python -m pytest -q bridges/can/frames -k fuzz
	HIL_FUZZ=10000000 HIL_FUZZ_SEED=$(or $(FUZZ_SEED),2) $(BIN)/python -m pytest -q bridges/can/canopen/words -k fuzz
	HIL_FUZZ=10000 $(BIN)/python -m pytest -q bridges/can/bus -k fuzz
	HIL_FUZZ=10000000 HIL_FUZZ_SEED=$(or $(FUZZ_SEED),2) $(BIN)/python -m pytest -q virtual_ports/usb -k fuzz
	HIL_FUZZ=10000000 HIL_FUZZ_SEED=$(or $(FUZZ_SEED),2) $(BIN)/python -m pytest -q bridges/can/canopen/node -k fuzz
	HIL_FUZZ=1000000 HIL_FUZZ_SEED=$(or $(FUZZ_SEED),2) $(BIN)/python -m pytest -q device_profiles/sac/tests/test_sac_fuzz.py
	HIL_FUZZ=1000 HIL_FUZZ_SEED=$(or $(FUZZ_SEED),2) $(BIN)/python -m pytest -q device_profiles/sac/tests/test_sac_lines.py
	HIL_FUZZ=2000 HIL_FUZZ_SEED=$(or $(FUZZ_SEED),2) $(BIN)/python -m pytest -q hil/toolpath/tests/test_toolpath_fuzz.py
	HIL_FUZZ=10000 $(BIN)/python -m pytest -q device_profiles/sac/tests/test_motion_model.py
	HIL_FUZZ=1000 $(BIN)/python -m pytest -q hil/master/sans_io
	HIL_FUZZ=100000 HIL_FUZZ_SEED=$(or $(FUZZ_SEED),2) $(BIN)/python -m pytest -q device_profiles/walter/tests/test_walter_fuzz.py
	HIL_FUZZ=100000 HIL_FUZZ_SEED=$(or $(FUZZ_SEED),2) $(BIN)/python -m pytest -q hil/operations/tests/test_control_fuzz.py
	HIL_FUZZ=100000 HIL_FUZZ_SEED=$(or $(FUZZ_SEED),2) $(BIN)/python -m pytest -q hil/compose/tests/test_replay_fuzz.py
	HIL_FUZZ=100000 HIL_FUZZ_SEED=$(or $(FUZZ_SEED),2) $(BIN)/python -m pytest -q hil/gcode
	HIL_FUZZ=1000000 HIL_FUZZ_SEED=$(or $(FUZZ_SEED),2) $(BIN)/python -m pytest -q device_profiles/uno -k fuzz
	HIL_FUZZ=100000 $(BIN)/python -m pytest -q hil/testing/serial_ports/tests/test_serial_equals_pty.py
	HIL_FUZZ=250 $(BIN)/python -m pytest -q hil/testing/tests/test_faults_overlap.py
	HIL_FUZZ=1000000 HIL_FUZZ_SEED=$(or $(FUZZ_SEED),2) $(BIN)/python -m pytest -q -s -rs hil/core/tests/test_avr_beside_simavr.py

# Figures with their references from the same run, and one table of all; docs/benchmarks.md explains them.
# BENCH=--quick is shorter. Ends with 1 if a goal is missed by more than the noise. bench-docs writes the table.
bench: $(VENV)/.dev
	@$(BIN)/python benchmarks/_table.py begin
	@failed=; for file in benchmarks/[a-z]*.py; do echo "-- $$file"; $(BIN)/python $$file $(BENCH) || failed="$$failed $$file"; done; \
	  $(BIN)/python benchmarks/_table.py end || missed=1; \
	  [ -z "$$failed" ] || { echo "did not do their work:$$failed"; exit 1; }; [ -z "$$missed" ]
bench-docs:
	@$(BIN)/python benchmarks/_table.py docs

clean:
	rm -rf $(VENV) build dist *.egg-info $(PYX:.pyx=.c)
	find $(TREES) -name '*.so' -delete
	$(MAKE) -s --no-print-directory -C hil/core/native/tests clean

# One build for all: `make test` adds packages to that of `make demo`, and the service, wheels of the kit and the Debian
# package take what it has compiled, where they are for the same Python.
BUILT_OF = pyproject.toml setup.py $(NATIVE)

$(VENV)/.base: $(BUILT_OF)
	@echo "Building hil in $(VENV): about 25 s on two idle cores; longer on busy ones or over a slow network."
	@$(call build,)
	@$(BYTECODE)
	@touch $@

$(VENV)/.dev: $(BUILT_OF)
	@echo "Building what the tests need in $(VENV): about 1 minute on two idle cores, with hil itself."
	@$(call build,$(IF_BUILT)) dev
	@$(BYTECODE)
	@touch $@ $(VENV)/.base

# Where hil itself is built already.
IF_BUILT = $(if $(shell $(MAKE) -q $(VENV)/.base 2>/dev/null && echo built),--packages)
build = $(if $(wildcard $(BIN)/pip),$(BIN)/python,$(PYTHON)) packaging/build_venv.py $(1) $(VENV)
