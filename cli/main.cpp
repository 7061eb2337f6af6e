// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <exception>
#include <new>
#include <string>
#include <string_view>

#include "printable.h"
#include "program.h"
#include "quench/error.h"

namespace {

// A caller may close stdin, stdout or stderr; the first files opened would take their numbers, and messages would be
// written into them.
void keep_standard_streams() {
  for (int fd : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (fcntl(fd, F_GETFD) == -1 && open("/dev/null", O_RDWR) != fd) return;
}

void complain(const std::string& sentence) {
  std::fprintf(stderr, "quench: %s\n", quench::program::printable(sentence).c_str());
}

}  // namespace

int main(int argc, char** argv) {
  keep_standard_streams();
  std::signal(SIGXFSZ, SIG_IGN);  // a file over the size limit is then an error of the writer, which tidies up
  std::signal(SIGPIPE, SIG_IGN);  // as is a reader of stdout or stderr that has gone
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
