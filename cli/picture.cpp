// SPDX-License-Identifier: Apache-2.0
#include "picture.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <ostream>
#include <string_view>
#include <thread>
#include <vector>

#include "quench/io.h"

extern char** environ;

namespace quench::program {
namespace {

namespace fs = std::filesystem;

constexpr auto kPatience = std::chrono::seconds(180);

bool is_program(const fs::path& file) {
  std::error_code ignored;
  return fs::is_regular_file(file, ignored) && access(file.c_str(), X_OK) == 0;
}

fs::path on_path(const std::string& name) {
  if (name.find('/') != std::string::npos) return is_program(name) ? fs::path(name) : fs::path();
  const char* const path = std::getenv("PATH");
  const std::string folders = path ? path : "";
  for (std::size_t begin = 0; begin <= folders.size();) {
    const std::size_t end = std::min(folders.find(':', begin), folders.size());
    const fs::path file = fs::path(folders.substr(begin, end - begin)) / name;
    if (end > begin && is_program(file)) return file;
    begin = end + 1;
  }
  return {};
}

// A path as a file address: everything but unreserved characters is written as its bytes.
std::string address_of(const fs::path& file) {
  std::string address = "file://";
  for (const char c : fs::absolute(file).string()) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                       std::string_view("/-._~").find(c) != std::string_view::npos;
    address += plain ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return address;
}

/// Runs a program without a shell, silent; ends it with all it started when it takes too long or the user stops.
/// Whether it ended by itself, well.
bool run(std::vector<std::string> words, Session& session) {
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t files;
  posix_spawnattr_t attributes;
  posix_spawn_file_actions_init(&files);
  posix_spawnattr_init(&attributes);
  posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addopen(&files, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  sigset_t ignored_here;
  sigemptyset(&ignored_here);
  sigaddset(&ignored_here, SIGPIPE);
  sigaddset(&ignored_here, SIGXFSZ);
  posix_spawnattr_setsigdefault(&attributes, &ignored_here);
  sigset_t none_blocked;
  sigemptyset(&none_blocked);
  posix_spawnattr_setsigmask(&attributes, &none_blocked);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETSIGMASK);
  posix_spawnattr_setpgroup(&attributes, 0);
  pid_t child = 0;
  const int error = posix_spawn(&child, argv[0], &files, &attributes, argv.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  posix_spawnattr_destroy(&attributes);
  if (error != 0)
    throw Error(ErrorCode::failed, fmt::format("'{}' cannot be started: {}", words[0], std::strerror(error)));
  const auto start = std::chrono::steady_clock::now();
  int status = 0;
  for (;;) {
    const pid_t ended = waitpid(child, &status, WNOHANG);
    if (ended != 0) {
      kill(-child, SIGKILL);  // helpers that stayed behind
      return ended == child && WIFEXITED(status) && WEXITSTATUS(status) == 0;
    }
    const bool late = std::chrono::steady_clock::now() - start > kPatience;
    if (late || session.context.cancelled()) {
      kill(-child, SIGKILL);
      waitpid(child, &status, 0);
      checkpoint(&session.context, "picture", 0);  // throws when the user stopped
      return false;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
}

std::string bytes_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace

TemporaryFolder::TemporaryFolder() {
  const char* const given = std::getenv("TMPDIR");
  const fs::path folder = given && *given ? given : "/tmp";
  std::string name = (folder / "quench-picture-XXXXXX").string();
  if (!mkdtemp(name.data()))
    throw Error(
        ErrorCode::failed,
        fmt::format("--png needs room for temporary files, and the folder '{}' cannot be used for them: {}; set "
                    "TMPDIR to a folder that can be written",
                    folder.string(), std::strerror(errno)));
  path = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  fs::remove_all(path, ignored);
}

fs::path find_chromium() {
  if (const char* const given = std::getenv("QUENCH_CHROMIUM"); given && *given) {
    const fs::path found = on_path(given);
    if (!found.empty()) return found;
    throw Error(
        ErrorCode::failed,
        fmt::format("QUENCH_CHROMIUM is '{}', which is not a program that can be run; name Chromium or Google Chrome",
                    given));
  }
  for (const char* name : {"chromium", "chromium-browser", "google-chrome", "google-chrome-stable"})
    if (const fs::path found = on_path(name); !found.empty()) return found;
  throw Error(
      ErrorCode::failed,
      "--png needs Chromium or Google Chrome, and none is on the PATH; install it, or name it in QUENCH_CHROMIUM");
}

void take_picture(const fs::path& chromium, const fs::path& page, const fs::path& png, const Picture& picture,
                  Session& session) {
  const TemporaryFolder folder;
  const fs::path shot = folder.path / "picture.png";
  const bool ended =
      run({chromium.string(), "--headless", "--no-sandbox", "--disable-quic", "--no-first-run",
           "--disable-background-networking", "--disable-component-update", "--disable-sync", "--disable-extensions",
           "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--hide-scrollbars",
           "--force-device-scale-factor=1", "--virtual-time-budget=60000",
           fmt::format("--window-size={},{}", picture.width, picture.height),
           "--user-data-dir=" + (folder.path / "profile").string(), "--screenshot=" + shot.string(),
           address_of(page) + "#" + picture.state},
          session);
  const std::string bytes = bytes_of(shot);
  const auto number = [&](std::size_t at) {
    std::uint32_t n = 0;
    for (std::size_t i = 0; i < 4; ++i) n = n << 8 | static_cast<unsigned char>(bytes[at + i]);
    return n;
  };
  if (!ended || bytes.size() < 100 || !bytes.starts_with("\x89PNG") ||
      number(16) != static_cast<std::uint32_t>(picture.width) ||
      number(20) != static_cast<std::uint32_t>(picture.height))
    throw Error(ErrorCode::failed, fmt::format("'{}' did not draw the page; name another Chromium or Google Chrome in "
                                               "QUENCH_CHROMIUM, or open the page written by -o in a browser",
                                               chromium.string()));
  io::write_atomically(png, [&](std::ostream& out) { out << bytes; });
}

}  // namespace quench::program
