// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fcntl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <map>
#include <string>
#include <vector>

namespace quench::testing_program {

/// A process of the program that has loaded its libraries and forks one child per run (cli/faults/start_once.c): a run
/// costs a tenth of the start of a new process. QUENCH_TEST_FULL=1: every run is a new process.
class ProgramStarter {
 public:
  /// The one for what LD_PRELOAD names now, or null where runs start new processes.
  static ProgramStarter* find() {
#if defined(QUENCH_START_LIBRARY) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
    if (std::getenv("QUENCH_TEST_FULL")) return nullptr;
    static std::map<std::string, ProgramStarter> all;
    const char* preloaded = std::getenv("LD_PRELOAD");
    const auto [place, fresh] = all.try_emplace(preloaded ? preloaded : "");
    if (fresh) place->second.begin(place->first);
    return place->second.socket_ >= 0 ? &place->second : nullptr;
#else
    return nullptr;
#endif
  }

  /// Runs main() with these arguments (the name of the program first) in a child; -1 where it cannot be.
  pid_t start(const std::vector<std::string>& arguments, const std::string& folder,
              const std::array<int, 3>& streams) const {
    Request request{0, 0, static_cast<std::uint32_t>(arguments.size()), 0};
    std::string text = folder + '\0';
    for (const std::string& word : arguments) text += word + '\0';
    for (char** variable = environ; *variable; ++variable, ++request.variables) text += std::string(*variable) + '\0';
    request.bytes = static_cast<std::uint32_t>(text.size());
    union {
      char bytes[CMSG_SPACE(sizeof streams)] = {};
      cmsghdr aligned;
    } control;
    iovec part{&request, sizeof request};
    msghdr message{};
    message.msg_iov = &part;
    message.msg_iovlen = 1;
    message.msg_control = &control;
    message.msg_controllen = sizeof control;
    cmsghdr* held = CMSG_FIRSTHDR(&message);
    held->cmsg_level = SOL_SOCKET;
    held->cmsg_type = SCM_RIGHTS;
    held->cmsg_len = CMSG_LEN(sizeof streams);
    std::memcpy(CMSG_DATA(held), streams.data(), sizeof streams);
    if (sendmsg(socket_, &message, MSG_NOSIGNAL) != static_cast<ssize_t>(sizeof request)) return -1;
    for (std::size_t at = 0; at < text.size();) {
      const ssize_t sent = send(socket_, text.data() + at, text.size() - at, MSG_NOSIGNAL);
      if (sent <= 0) return -1;
      at += static_cast<std::size_t>(sent);
    }
    const pid_t child = reply();
    if (child > 0) children()[child] = this;
    return child;
  }

  /// Waits for a child of any starter; false if it is a child of this process.
  static bool wait(pid_t child, int& status) {
    const auto place = children().find(child);
    if (place == children().end()) return false;
    const Request request{child, 0, 0, 0};
    const bool asked = send(place->second->socket_, &request, sizeof request, MSG_NOSIGNAL) == sizeof request;
    status = asked ? place->second->reply() : -1;
    children().erase(place);
    return true;
  }

 private:
  struct Request {
    std::int32_t child;  ///< whose end is waited for; 0: starts one
    std::uint32_t bytes, arguments, variables;
  };

  static std::map<pid_t, const ProgramStarter*>& children() {
    static std::map<pid_t, const ProgramStarter*> all;
    return all;
  }

  std::int32_t reply() const {
    std::int32_t value = -1;
    return recv(socket_, &value, sizeof value, MSG_WAITALL) == sizeof value ? value : -1;
  }

#ifdef QUENCH_START_LIBRARY
  void begin(const std::string& preloaded) {
    int ends[2];
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) return;
    std::vector<std::string> words{"LD_PRELOAD=" QUENCH_START_LIBRARY + (preloaded.empty() ? "" : ':' + preloaded),
                                   "QUENCH_START_SOCKET=" + std::to_string(ends[1])};
    for (char** variable = environ; *variable; ++variable)
      if (!std::string_view(*variable).starts_with("LD_PRELOAD=")) words.emplace_back(*variable);
    std::vector<char*> variables;
    for (std::string& word : words) variables.push_back(word.data());
    variables.push_back(nullptr);
    std::string program = QUENCH_PROGRAM_PATH;
    char* argv[] = {program.data(), nullptr};
    const pid_t child = fork();
    if (child == 0) {
      if (fcntl(ends[1], F_SETFD, 0) != 0) _exit(127);
      execve(argv[0], argv, variables.data());
      _exit(127);
    }
    close(ends[1]);
    socket_ = ends[0];
  }
#endif

  int socket_ = -1;
};

}  // namespace quench::testing_program
