// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "program_starter.h"
#include "temporary_folder.h"

/// Runs the real program in a folder of its own and looks at what it says, returns and leaves behind.
namespace quench::testing_program {

/// A program that runs and whose stderr is listened to.
struct Running {
  pid_t child = -1;
  int err = -1;  ///< descriptor
  std::string heard;

  /// Returns when the program has said this.
  void until_it_says(const std::string& text) {
    while (heard.find(text) == std::string::npos)
      if (!listen()) FAIL() << "it ended without '" << text << "':\n" << heard;
  }
  bool listen() {
    char block[4096];
    const ssize_t got = read(err, block, sizeof block);
    if (got > 0) heard.append(block, static_cast<std::size_t>(got));
    return got > 0;
  }
};

struct Outcome {
  int code = -1;  ///< exit code, or 128 + the signal that ended it
  std::string out, err;
};

inline std::string bytes_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

class ProgramTest : public testing::Test {
 protected:
  TemporaryFolder folder;
  TemporaryFolder streams;           // stdout and stderr: not among the files the program leaves
  void (*before_start)() = nullptr;  // called in the child right before it becomes the program

  /// Starts `quench arguments...` in `folder`.
  pid_t start(const std::vector<std::string>& arguments, rlim_t largest_file = RLIM_INFINITY) {
    std::vector<std::string> words{QUENCH_PROGRAM_PATH};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    const std::string out = (streams / "out").string(), err = (streams / "err").string(), cwd = folder.path().string();
    const int in_fd = open("/dev/null", O_RDONLY | O_CLOEXEC);
    const int out_fd = open(out.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    const int err_fd = err_to_ >= 0 ? err_to_ : open(err.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    const rlimit limit{largest_file, largest_file};
    ProgramStarter* starter = before_start || largest_file != RLIM_INFINITY ? nullptr : ProgramStarter::find();
    const pid_t child = starter ? starter->start(words, cwd, {in_fd, out_fd, err_fd}) : fork();
    if (child != 0) {
      for (const int fd : {in_fd, out_fd, err_fd})
        if (fd >= 0 && fd != err_to_) close(fd);
      return child;
    }
    // Between fork and exec only what is safe in a signal handler.
    if (chdir(cwd.c_str()) != 0 || dup2(in_fd, 0) < 0 || dup2(out_fd, 1) < 0 || dup2(err_fd, 2) < 0) _exit(127);
    if (before_start) before_start();
    if (largest_file != RLIM_INFINITY && setrlimit(RLIMIT_FSIZE, &limit) != 0) _exit(127);
    execv(argv[0], argv.data());
    _exit(127);
  }

  /// The same, to be listened to.
  Running start_and_listen(const std::vector<std::string>& arguments) {
    int ends[2];
    EXPECT_EQ(pipe2(ends, O_CLOEXEC), 0);
    err_to_ = ends[1];
    const pid_t child = start(arguments);
    err_to_ = -1;
    close(ends[1]);
    return {child, ends[0], {}};
  }

  Outcome wait(Running& running) {
    while (running.listen()) {
    }
    close(running.err);
    Outcome outcome = wait(running.child);
    outcome.err = running.heard;
    return outcome;
  }

  /// A pipe with a name: what opens it to read waits until somebody opens it to write, and the other way round.
  std::filesystem::path make_fifo(const std::string& name) {
    EXPECT_EQ(mkfifo((folder / name).c_str(), 0600), 0);
    return folder / name;
  }
  /// Opens a FIFO to write, as soon as somebody reads it.
  static int open_to_write(const std::filesystem::path& fifo) { return open(fifo.c_str(), O_WRONLY | O_CLOEXEC); }

  Outcome wait(pid_t child) {
    int status = 0;
    if (!ProgramStarter::wait(child, status)) {
      EXPECT_EQ(waitpid(child, &status, 0), child);
    }
    Outcome outcome;
    outcome.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    outcome.out = bytes_of(streams / "out");
    outcome.err = bytes_of(streams / "err");
    return outcome;
  }

  Outcome quench(const std::vector<std::string>& arguments) { return wait(start(arguments)); }

  /// Runs what must succeed.
  Outcome works(const std::vector<std::string>& arguments) {
    const Outcome outcome = quench(arguments);
    EXPECT_EQ(outcome.code, 0) << testing::PrintToString(arguments) << '\n' << outcome.err;
    EXPECT_EQ(outcome.err.find('\r'), std::string::npos) << "a progress bar in a file";
    return outcome;
  }

  /// Runs what must be refused with this code, in one line that has all of `words`, leaving every file as it was.
  void refuses(int code, const std::vector<std::string>& words, const std::vector<std::string>& arguments) {
    const auto before = files();
    const Outcome outcome = quench(arguments);
    const std::string what = testing::PrintToString(arguments) + "\n" + outcome.err;
    EXPECT_EQ(outcome.code, code) << what;
    EXPECT_EQ(outcome.out, "") << what;
    std::vector<std::string> complaints;
    for (std::size_t begin = 0, end = 0; (end = outcome.err.find('\n', begin)) != std::string::npos; begin = end + 1) {
      const std::string line = outcome.err.substr(begin, end - begin);
      if (line.starts_with("quench: "))
        complaints.push_back(line);
      else
        EXPECT_TRUE(line.starts_with("shape: ") || line.starts_with("note: ") || line.starts_with("lambda ") ||
                    line.find(": done in ") != line.npos || line.find('%') != line.npos)
            << "a stray line: " << line;
    }
    ASSERT_EQ(complaints.size(), 1u) << what;
    EXPECT_TRUE(outcome.err.ends_with(complaints[0] + "\n")) << what;
    for (const std::string& word : words)
      EXPECT_NE(complaints[0].find(word), std::string::npos) << "no '" << word << "' in " << what;
    EXPECT_EQ(complaints[0].find("unexpected"), std::string::npos) << what;
    EXPECT_EQ(files(), before) << what;
  }

  /// Names and contents of all files in the folder; a temporary file of an interrupted run would be among them.
  std::vector<std::pair<std::string, std::string>> files() const {
    std::vector<std::pair<std::string, std::string>> list;
    std::error_code ignored;  // of a link that leads to itself
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder.path()))
      list.emplace_back(entry.path().lexically_relative(folder.path()).string(),
                        entry.is_regular_file(ignored) ? bytes_of(entry.path()) : "");
    std::sort(list.begin(), list.end());
    return list;
  }
  bool exists(const std::string& name) const { return std::filesystem::exists(folder / name); }
  std::string bytes(const std::string& name) const { return bytes_of(folder / name); }

 private:
  int err_to_ = -1;  // stderr of the next program that is started
};

/// An NPY file of bytes; nx runs fastest.
inline std::string npy(int nx, int ny, int nz, const std::string& samples, const std::string& type = "|u1") {
  const std::string sides = std::to_string(nz) + ", " + std::to_string(ny) + ", " + std::to_string(nx);
  std::string header = "{'descr': '" + type + "', 'fortran_order': False, 'shape': (" + sides + "), }";
  header.resize((header.size() + 11) / 64 * 64 + 53, ' ');  // magic, header and newline: a multiple of 64
  header += '\n';
  const std::string length{static_cast<char>(header.size() & 0xFF), static_cast<char>(header.size() >> 8)};
  return "\x93NUMPY" + std::string("\x01\x00", 2) + length + header + samples;
}

/// A box of ones in zeros.
inline std::string npy_box(int nx, int ny, int nz, int margin) {
  std::string samples;
  const auto inside = [&](int i, int n) { return i >= margin && i < n + margin; };
  for (int z = 0; z < nz + 2 * margin; ++z)
    for (int y = 0; y < ny + 2 * margin; ++y)
      for (int x = 0; x < nx + 2 * margin; ++x)
        samples += inside(x, nx) && inside(y, ny) && inside(z, nz) ? '\1' : '\0';
  return npy(nx + 2 * margin, ny + 2 * margin, nz + 2 * margin, samples);
}

/// A cube as OFF; one face can be left out, one coordinate replaced.
inline std::string cube_off(bool open = false, const std::string& coordinate = "1") {
  std::string text = "OFF\n8 " + std::to_string(open ? 11 : 12) +
                     " 0\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 0 1\n1 0 1\n0 1 1\n1 1 " + coordinate + "\n";
  text += "3 0 2 1\n3 1 2 3\n3 4 5 6\n3 5 7 6\n3 0 1 4\n3 1 5 4\n3 2 6 3\n3 3 6 7\n3 0 4 2\n3 2 4 6\n3 1 3 5\n";
  return open ? text : text + "3 3 7 5\n";
}

}  // namespace quench::testing_program
