# SPDX-License-Identifier: Apache-2.0
# make demo       install packages, build the program, run the main job on a built-in shape
# make test       install packages, build and run the tests (at most 15 minutes on 2 cores)
# make test-full  also: address, undefined-behaviour and thread sanitizers, all real data at resolution 512
# make install    the program, its manual pages and completion, the library and the documentation into PREFIX (/usr/local)
# make soak       random shapes and options through the program for SOAK_SECONDS (600), from seed SOAK_SEED (the time)
# make fuzz       every own reader fuzzed with Clang for FUZZ_SECONDS (60) each
# make packages   Debian packages in build/release/packages; make tarball: a program that runs on other Linux systems
# make test-packages  lintian, and both tried in fresh systems of this and another Debian release; as root
# make test-cluster  tasks through SLURM, Snakemake and Dask, and processes of MPI, on this machine; as root
# make test-plugins  the plug-ins in ParaView, Blender and the other programs they are for, gigabytes of packages
# make docs       install packages for it, build the documentation as a site in build/site
# make bench      time and memory per boundary vertex
# make format     clang-format over the sources
JOBS ?= $(shell nproc)
BUILD := build/release

FUZZ_SECONDS ?= 60

.PHONY: demo install test test-full test-cluster test-plugins packages tarball test-packages soak fuzz docs bench build format clean
demo: deps
	@echo "Building the program and its page only, some minutes on two processors ('make test' builds the rest) ..."
	cmake --preset release
	cmake --build $(BUILD) -j $(JOBS) --target quench_program
	@echo "Computing the medial axis, skeleton and page of a built-in shape ..."
	@rm -rf demo && mkdir demo
	$(BUILD)/quench sample fin-on-board -o demo/fin-on-board.ply
	$(BUILD)/quench run demo/fin-on-board.ply -o demo/fin-on-board
	$(BUILD)/quench verify demo/fin-on-board.ply demo/fin-on-board/core.vtp
	@echo
	@echo "Open demo/fin-on-board/view.html in a browser (without npm there is none: core.vtp and skeleton.vtp open in ParaView);"
	@echo "the figures are in demo/fin-on-board/report.json."

.PHONY: deps
deps:
	@scripts/install-deps

build:
	cmake --preset release
	cmake --build $(BUILD) -j $(JOBS)

PREFIX ?= /usr/local
install:
	cmake --preset release
	cmake --build $(BUILD) -j $(JOBS) --target quench quench_program
	cmake --install $(BUILD) --prefix $(PREFIX)

test: deps
	@$(MAKE) --no-print-directory build
	ctest --test-dir $(BUILD) -j $(JOBS) --output-on-failure --timeout 600

test-full: test
	QUENCH_TEST_FULL=1 ctest --test-dir $(BUILD) -j 1 --output-on-failure --timeout 7200
	cmake --preset asan && cmake --build build/asan -j $(JOBS)
	ctest --test-dir build/asan -j $(JOBS) --output-on-failure --timeout 3600
	scripts/tsan-tbb
	cmake --preset tsan && cmake --build build/tsan -j $(JOBS)
	ctest --test-dir build/tsan -j $(JOBS) --output-on-failure --timeout 3600

packages:
	@scripts/install-deps --packages
	cmake --preset release
	cmake --build $(BUILD) -j $(JOBS) --target quench quench_program $$(grep -q '^build quench_python:' $(BUILD)/build.ninja && echo quench_python)
	scripts/make-packages $(BUILD)

tarball:
	@scripts/install-deps --packages
	cmake --preset release
	cmake --build $(BUILD) -j $(JOBS) --target quench_program
	scripts/make-tarball $(BUILD)

test-packages: packages tarball
	cmake --build $(BUILD) -j $(JOBS) --target read_volumes
	scripts/test-packages $(BUILD)

test-cluster:
	@scripts/install-deps --cluster
	cmake --preset release -DQUENCH_MPI=ON
	cmake --build $(BUILD) -j $(JOBS) --target quench_program quench_mpi
	QUENCH_BUILD=$(BUILD) tests/cluster/slurm_here /usr/bin/python3 -B -m pytest -v tests/cluster

test-plugins:
	@scripts/install-deps --plugins
	cmake --preset release
	cmake --build $(BUILD) -j $(JOBS) --target quench_program quench_python
	QUENCH_BUILD=$(BUILD) scripts/test-plugins

SOAK_SECONDS ?= 600
SOAK_SEED ?= $(shell date +%s)
soak: build
	QUENCH_SOAK_SECONDS=$(SOAK_SECONDS) QUENCH_SOAK_SEED=$(SOAK_SEED) $(BUILD)/tests/cli_tests --gtest_filter=ProgramPipeline.*
fuzz:
	cmake --preset fuzz
	cmake --build --preset fuzz -j $(JOBS)
	fuzz/run build/fuzz $(FUZZ_SECONDS)

docs:
	@scripts/install-deps --docs
	scripts/make-docs

bench: build
	bench/run $(BUILD)

format:
	clang-format -i include/quench/*.h $$(find src -name "*.h" -o -name "*.cpp") cli/*.h cli/*.cpp mpi/*.cpp tests/*/*.h tests/*/*.cpp fuzz/*.h fuzz/*.cpp bench/*.cpp python/src/*.h python/src/*.cpp

clean:
	rm -rf build demo
