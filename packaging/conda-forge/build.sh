#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
set -euxo pipefail
# shellcheck disable=SC2086  # CMAKE_ARGS are several
cmake -S . -B build -G Ninja ${CMAKE_ARGS:-} -DCMAKE_BUILD_TYPE=Release -DCMAKE_INSTALL_PREFIX="$PREFIX" \
  -DCMAKE_INSTALL_LIBDIR=lib -DQUENCH_TESTS=OFF -DQUENCH_BENCH=OFF -DQUENCH_WERROR=OFF -DQUENCH_PYTHON=ON \
  -DPython3_EXECUTABLE="$PYTHON" -DQUENCH_PYTHON_DIR="$SP_DIR" -DQUENCH_FONT="$SRC_DIR/dejavu/ttf/DejaVuSans.ttf"
cmake --build build -j "${CPU_COUNT:-1}" --target quench quench_program quench_python
cmake --install build
cmake --install build --component python
