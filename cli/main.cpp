// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <exception>
#include <new>
#include <string>
#include <string_view>

#include "base/platform/streams.h"
#include "printable.h"
#include "program.h"
#include "quench/error.h"

namespace {

void complain(const std::string& sentence) {
  std::fprintf(stderr, "quench: %s\n", quench::program::printable(sentence).c_str());
}

}  // namespace

int main(int argc, char** argv) {
  quench::base::keep_standard_streams();
  quench::base::let_writers_see_errors();
  try {
    return quench::program::run(argc, argv);
  } catch (const quench::Error& error) {
    const bool plain = std::string_view(error.what()) == "cancelled";
    complain(plain ? "interrupted; nothing was written" : error.what());
    return static_cast<int>(error.code());
  } catch (const std::bad_alloc&) {
    complain(
        "out of memory; give the program a smaller shape (for a mesh: a lower --resolution) or close other programs");
  } catch (const std::exception& error) {
    // What TBB says when the system has no memory or no room for another thread.
    if (std::string_view(error.what()).starts_with("pthread_create")) {
      complain(
          "a thread cannot be started: out of memory, or too many processes; use --threads 1 or close other programs");
      return static_cast<int>(quench::ErrorCode::failed);
    }
    complain(std::string("unexpected: ") + error.what());
  }
  return static_cast<int>(quench::ErrorCode::failed);
}
