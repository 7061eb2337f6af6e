// SPDX-License-Identifier: Apache-2.0
#include <csignal>
#include <cstdlib>

#include "program.h"

// How the program ends when it is stopped, and what is left then.

using namespace quench::testing_program;

namespace program_interrupts_test {

// A core that takes many seconds.
class Interrupted : public ProgramTest {
 protected:
  const std::vector<std::string> slow{"core", "s.ply", "--resolution", "512",        "--memory-limit",
                                      "100G", "-o",    "out.vtp",      "--overwrite"};
  void SetUp() override {
    works({"sample", "bumpy-sphere", "-o", "s.ply", "--fineness", "0.3"});
    folder.write("out.vtp", "precious");
  }

  /// What is said and left when a signal comes while the core is computed.
  void ended_by(int signal) {
    const auto before = files();
    Running running = start_and_listen(slow);
    running.until_it_says("shape: ");
    kill(running.child, signal);
    const Outcome outcome = wait(running);
    EXPECT_EQ(outcome.code, 130);
    EXPECT_TRUE(outcome.err.ends_with("quench: interrupted; nothing was written\n")) << outcome.err;
    const std::size_t first = outcome.err.find("quench: ");
    EXPECT_EQ(outcome.err.find('\n', first), outcome.err.size() - 1) << "one line";
    EXPECT_EQ(files(), before);
  }
};

TEST_F(Interrupted, ByCtrlC) { ended_by(SIGINT); }
TEST_F(Interrupted, ByASignalToEnd) { ended_by(SIGTERM); }
TEST_F(Interrupted, ByAClosedTerminal) { ended_by(SIGHUP); }

TEST_F(Interrupted, ASecondTimeByTheSignal) {
  const auto before = files();
  const auto fifo = make_fifo("never.ply");
  const pid_t child = start({"core", "never.ply", "-o", "out.vtp", "--overwrite"});
  const int held = open_to_write(fifo);
  kill(child, SIGTERM);
  kill(child, SIGHUP);  // another one: two of a kind that wait to be taken are one
  const Outcome outcome = wait(child);
  close(held);
  EXPECT_TRUE(outcome.code == 128 + SIGTERM || outcome.code == 128 + SIGHUP) << outcome.code;
  std::filesystem::remove(fifo);
  EXPECT_EQ(files(), before);
}

TEST_F(Interrupted, Killed) {
  Running running = start_and_listen(slow);
  running.until_it_says("shape: ");
  kill(running.child, SIGKILL);
  EXPECT_EQ(wait(running).code, 128 + SIGKILL);
  EXPECT_EQ(bytes("out.vtp"), "precious");
  for (const auto& [name, content] : files())
    EXPECT_TRUE(name == "s.ply" || name == "out.vtp" || name.ends_with(".tmp")) << name;
}

// A signal that was ignored when the program was started (nohup) stays ignored.
TEST_F(Interrupted, NotByIgnoredSignals) {
  before_start = [] { std::signal(SIGHUP, SIG_IGN); };
  const std::string mesh = cube_off();
  const auto fifo = make_fifo("late.off");
  const pid_t child = start({"core", "late.off", "--resolution", "8", "-o", "o.vtp"});
  const int to = open_to_write(fifo);
  kill(child, SIGHUP);
  EXPECT_EQ(write(to, mesh.data(), mesh.size()), static_cast<ssize_t>(mesh.size()));
  close(to);
  EXPECT_EQ(wait(child).code, 0);
}

// --- files that do not answer ---------------------------------------------------------------------------------------

class Unanswered : public ProgramTest {
 protected:
  void SetUp() override {
    folder.write("cube.off", cube_off());
    works({"core", "cube.off", "--resolution", "8", "--lambda", "0", "-o", "core.vtp"});
  }
  void TearDown() override {
    for (const char* name : {"LD_PRELOAD", "QUENCH_DEAD_FILE", "QUENCH_FAULT_MARK"}) unsetenv(name);
  }

  void expect_interrupted(const Outcome& outcome, const std::vector<std::string>& arguments) {
    EXPECT_EQ(outcome.code, 130) << testing::PrintToString(arguments) << '\n' << outcome.err;
    EXPECT_TRUE(outcome.err.ends_with("quench: interrupted; nothing was written\n")) << outcome.err;
  }
};

// Somebody holds the other end and writes nothing: the program waits in its first read.
TEST_F(Unanswered, WhileItIsRead) {
  const auto fifo = make_fifo("never.ply");
  std::filesystem::create_symlink(fifo, folder / "never.vtp");
  std::filesystem::create_symlink(fifo, folder / "never.r");
  for (const std::vector<std::string>& arguments :
       std::vector<std::vector<std::string>>{{"core", "never.ply", "-o", "o.vtp"},
                                             {"run", "never.ply", "-o", "new"},
                                             {"info", "never.ply"},
                                             {"convert", "never.vtp", "o.ma"},
                                             {"verify", "cube.off", "never.vtp"},
                                             {"burn", "core.vtp", "--shape", "never.ply", "-o", "o.vtp"},
                                             {"burn", "core.vtp", "--radii", "never.r", "-o", "o.vtp"}})
    for (const int signal : {SIGINT, SIGTERM}) {
      const auto before = files();
      const pid_t child = start(arguments);
      const int held = open_to_write(fifo);
      kill(child, signal);
      expect_interrupted(wait(child), arguments);
      close(held);
      EXPECT_EQ(files(), before);
    }
}

// Nobody holds the other end: the program waits for the file to be opened. It has read another one before.
TEST_F(Unanswered, WhileItIsOpened) {
  const auto first = make_fifo("first.vtp");
  make_fifo("never.ply");
  const std::string axis = bytes("core.vtp");
  const std::vector<std::string> arguments{"burn", "first.vtp", "--shape", "never.ply", "-o", "o.vtp"};
  const pid_t child = start(arguments);
  const int to = open_to_write(first);
  std::signal(SIGPIPE, SIG_IGN);
  EXPECT_EQ(write(to, axis.data(), axis.size()), static_cast<ssize_t>(axis.size()));
  close(to);
  kill(child, SIGTERM);
  expect_interrupted(wait(child), arguments);
  EXPECT_FALSE(exists("o.vtp"));
}

// Nobody reads the output.
TEST_F(Unanswered, WhileAnOutputIsOpened) {
  make_fifo("o.vtp");
  const std::vector<std::string> arguments{"core", "cube.off", "--resolution", "8", "-o", "o.vtp", "--overwrite"};
  Running running = start_and_listen(arguments);
  running.until_it_says("detail ");
  kill(running.child, SIGTERM);
  expect_interrupted(wait(running), arguments);
}

// A file on a disk that has gone: nothing but SIGKILL ends the call that opens it.
TEST_F(Unanswered, OnADeadDisk) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers have their own preloaded library";
#endif
  const auto mark = make_fifo("mark");
  setenv("QUENCH_FAULT_MARK", mark.c_str(), 1);
  folder.write("dead.r", "");
  for (const char* name : {"dead.ply", "dead.npy", "dead.vol", "dead.sof", "dead.png", "dead.r"}) {
    folder.write(name, cube_off());
    setenv("QUENCH_DEAD_FILE", name, 1);
    setenv("LD_PRELOAD", QUENCH_FAULTS_LIBRARY, 1);
    std::vector<std::string> arguments{"core", name, "-o", "o.vtp"};
    if (std::string(name) == "dead.r") arguments = {"burn", "core.vtp", "--radii", name, "-o", "o.vtp"};
    const pid_t child = start(arguments);
    unsetenv("LD_PRELOAD");
    EXPECT_EQ(bytes_of(mark), "dead");  // it is about to wait
    kill(child, SIGTERM);
    expect_interrupted(wait(child), arguments);
    EXPECT_FALSE(exists("o.vtp"));
  }
}

}  // namespace program_interrupts_test
