// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <exception>
#include <new>

#include "program.h"
#include "quench/error.h"

int main(int argc, char** argv) {
  try {
    return quench::program::run(argc, argv);
  } catch (const quench::Error& error) {
    std::fprintf(stderr, "quench: %s\n", error.what());
    return static_cast<int>(error.code());
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr, "quench: out of memory; use a lower --resolution or close other programs\n");
  } catch (const std::exception& error) {
    std::fprintf(stderr, "quench: unexpected: %s\n", error.what());
  }
  return static_cast<int>(quench::ErrorCode::failed);
}
