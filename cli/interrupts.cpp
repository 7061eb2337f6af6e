// SPDX-License-Identifier: Apache-2.0
#include "interrupts.h"

#include <pthread.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <climits>
#include <csignal>
#include <mutex>
#include <string_view>

#include "quench/io.h"

namespace quench::program {
namespace {

using namespace std::chrono_literals;

constexpr std::chrono::milliseconds kPatience = 700ms;
constexpr std::string_view kBlankLine = "\r                                                                      \r";
constexpr timespec kLook{0, 50'000'000};  // how often it is looked whether the time is up

std::mutex mutex;
Context* interrupted = nullptr;  // under the mutex
sigset_t watched;                // set before the thread starts

void say(std::string_view text) {
  if (write(STDERR_FILENO, text.data(), text.size()) < 0) return;  // nobody can be told
}

[[noreturn]] void end_by(int signal) {
  io::remove_temporary_files();
  sigset_t only;
  sigemptyset(&only);
  sigaddset(&only, signal);
  std::signal(signal, SIG_DFL);
  pthread_sigmask(SIG_UNBLOCK, &only, nullptr);
  std::raise(signal);
  _exit(128 + signal);
}

/// The next signal, or -1 when none comes for a while.
int next_signal() { return sigtimedwait(&watched, nullptr, &kLook); }

/// Until the program has had its time to end by itself.
void wait_for_the_end() {
  const auto start = std::chrono::steady_clock::now();
  for (;;) {
    if (const int signal = next_signal(); signal > 0) end_by(signal);
    const auto spent = std::chrono::steady_clock::now() - start;
    if (spent > kPatience) return;
  }
}

/// Neither allocates nor locks what others may hold: they may have stopped anywhere.
void* watch(void*) {
  int signal = 0;
  while (sigwait(&watched, &signal) != 0) {
  }
  {
    const std::lock_guard lock(mutex);
    if (interrupted) interrupted->cancel();
  }
  wait_for_the_end();
  io::Outputs outputs = io::stop_outputs();
  for (; outputs == io::Outputs::being_renamed; outputs = io::stop_outputs())
    if (const int again = next_signal(); again > 0) end_by(again);
  io::remove_temporary_files();
  const std::lock_guard lock(mutex);  // not given back: the session cannot end beside this
  if (!interrupted) _exit(static_cast<int>(ErrorCode::cancelled));  // it has ended, and the program says what it is
  if (isatty(STDERR_FILENO)) say(kBlankLine);                       // over the progress bar
  say(outputs == io::Outputs::untouched ? "quench: interrupted; nothing was written\n" : "quench: interrupted\n");
  _exit(static_cast<int>(ErrorCode::cancelled));
}

void start_watching() {
  sigemptyset(&watched);
  int count = 0;
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction now {};
    sigaction(signal, nullptr, &now);
    if (now.sa_handler == SIG_IGN) continue;  // nohup, and shells that start programs in the background
    sigaddset(&watched, signal);
    ++count;
  }
  if (count == 0) return;
  pthread_sigmask(SIG_BLOCK, &watched, nullptr);
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  pthread_attr_setdetachstate(&attributes, PTHREAD_CREATE_DETACHED);
  pthread_attr_setstacksize(&attributes, std::max<std::size_t>(std::size_t{1} << 18, PTHREAD_STACK_MIN));
  pthread_t thread;
  const int error = pthread_create(&thread, &attributes, watch, nullptr);
  pthread_attr_destroy(&attributes);
  if (error == 0) return;
  pthread_sigmask(SIG_UNBLOCK, &watched, nullptr);
  throw Error(ErrorCode::failed,
              "a thread cannot be started: out of memory, or too many processes; close other programs");
}

}  // namespace

Interrupts::Interrupts(Context& context) {
  {
    const std::lock_guard lock(mutex);
    interrupted = &context;
  }
  start_watching();
}

Interrupts::~Interrupts() {
  const std::lock_guard lock(mutex);
  interrupted = nullptr;
}

}  // namespace quench::program
