// SPDX-License-Identifier: Apache-2.0
// Whatever goes wrong while a command writes, and whenever: no half file, no lost file, one sentence.
#include <fmt/format.h>
#include <sys/stat.h>

#include <csignal>
#include <cstdlib>
#include <map>
#include <nlohmann/json.hpp>

#include "full_run.h"
#include "program.h"

using namespace quench::testing_program;

namespace program_faults_test {

constexpr const char* kOld = "precious";

struct Command {
  std::vector<std::string> arguments, outputs;
};

class Faults : public ProgramTest {
 protected:
  void SetUp() override {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    GTEST_SKIP() << "sanitizers have their own preloaded library";
#endif
    folder.write("box.npy", npy_box(9, 1, 1, 1));  // a picture of little
    folder.write("cube.off", cube_off());
    works({"core", "box.npy", "--lambda", "0", "-o", "core.vtp"});
    page_ = quench({"view", "absent.vtp"}).err.find("without its interactive page") == std::string::npos;
  }
  void TearDown() override {
    for (const char* name :
         {"LD_PRELOAD", "QUENCH_FAULT", "QUENCH_FAULT_AT", "QUENCH_FAULT_MARK", "QUENCH_NO_EXCHANGE"})
      unsetenv(name);
  }

  /// Every command that writes, with several outputs where it can.
  std::vector<Command> commands() const {
    std::vector<Command> list{
        {{"sample", "root", "--branches", "1", "--fineness", "0.1", "-o", "o.ply"}, {"o.ply", "o.json"}},
        {{"sample", "torus", "--resolution", "8", "-o", "o.nrrd"}, {"o.nrrd"}},
        {{"voxelize", "box.npy", "-o", "o.nrrd", "--json", "o.json"}, {"o.nrrd", "o.json"}},
        {{"voxelize", "box.npy", "-o", "o.zarr", "--json", "o.json"}, {"o.zarr", "o.json"}},
        {{"core", "cube.off", "--resolution", "4", "-o", "o.vtp", "--json", "o.json"}, {"o.vtp", "o.json"}},
        {{"burn", "core.vtp", "-o", "o.ply", "--json", "o.json"}, {"o.ply", "o.json"}},
        {{"skeleton", "core.vtp", "--swc", "o.swc", "--graphml", "o.graphml", "--csv", "o.csv", "-o", "o.vtp", "--json",
          "o.json"},
         {"o.swc", "o.graphml", "o.csv", "o.vtp", "o.json"}},
        {{"convert", "core.vtp", "o.ma"}, {"o.ma"}},
        {{"convert", "core.vtp", "o.obj"}, {"o.obj"}},
        {{"verify", "box.npy", "core.vtp", "--json", "o.json"}, {"o.json"}},
        {{"run", "box.npy", "-o", "."},
         {"core.vtp", "skeleton.vtp", "skeleton.swc", "branches.csv", "parts.csv", "report.json", "picture.png"}},
        {{"view", "core.vtp", "--png", "o.png", "--size", "64x48", "--json", "o.json"}, {"o.png", "o.json"}}};
    if (page_) {
      list.push_back({{"view", "core.vtp", "-o", "o.html", "--json", "o.json"}, {"o.html", "o.json"}});
      list.back().arguments.insert(list.back().arguments.end(), {"--max-triangles", "2000"});
      for (Command& command : list)
        if (command.arguments[0] == "run") command.outputs.push_back("view.html");
    }
    for (Command& command : list) command.arguments.push_back("--overwrite");
    return list;
  }

  /// What a command writes when nothing goes wrong.
  std::map<std::string, std::string> results(const Command& command) {
    works(command.arguments);
    std::map<std::string, std::string> all;
    for (const std::string& name : command.outputs) all[name] = content(name);
    return all;
  }

  /// What a file holds; of a folder the names and contents of all its files.
  std::string content(const std::string& name) const {
    if (!std::filesystem::is_directory(folder / name)) return bytes(name);
    std::string all;
    for (const auto& [file, held] : files())
      if (file.starts_with(name + '/')) all += file + '\n' + held + '\n';
    return all;
  }

  void make_old(const Command& command) {
    for (const std::string& name : command.outputs) {
      if (!name.ends_with(".zarr")) {
        folder.write(name, kOld);
        continue;
      }
      std::filesystem::remove_all(folder / name);
      std::filesystem::create_directory(folder / name);
      folder.write(name + "/.zgroup", kOld);
    }
  }

  bool is_old(const std::string& name) const {
    return content(name) == (name.ends_with(".zarr") ? name + "/.zgroup\n" + kOld + '\n' : kOld);
  }

  /// A report, without what differs from run to run.
  static nlohmann::json report_of(const std::string& content) {
    nlohmann::json report = nlohmann::json::parse(content, nullptr, false);
    for (const char* measured : {"seconds", "peak_bytes"})
      if (report.is_object()) report.erase(measured);
    if (report.is_object() && report.contains("core")) report["core"].erase("predicted_bytes");
    return report;
  }

  static bool is_whole(const std::string& name, const std::string& content, const std::string& expected) {
    if (!name.ends_with(".json")) return content == expected;
    const nlohmann::json report = report_of(content);
    return !report.is_discarded() && report == report_of(expected) && content.back() == '\n';
  }

  /// Runs the command with a fault at every call in turn, until it is past the last one, and hands each outcome to
  /// `check`, with the name of the call and the number of outputs that were replaced.
  template <class Check>
  void sweep(const std::string& fault, const Check& check) {
    std::vector<Command> list = commands();
    // Most of a run is its picture. Where the program ends at the call, it is one more file, as that of `view` is.
    if ((fault == "kill" || fault == "interrupt twice") && !quench::full_run())
      for (Command& command : list)
        if (std::erase(command.outputs, "picture.png") > 0) command.arguments.push_back("--no-picture");
    sweep(fault, list, check);
  }
  template <class Check>
  void sweep(const std::string& fault, const std::vector<Command>& list, const Check& check) {
    for (const Command& command : list) {
      const auto expected = results(command);
      const std::string mark = (streams / "mark").string();
      int at = 1;
      for (;; ++at) {
        SCOPED_TRACE(fmt::format("{} at call {} of {}", fault, at, testing::PrintToString(command.arguments)));
        ASSERT_LT(at, 500);
        make_old(command);
        std::filesystem::remove(mark);
        setenv("QUENCH_FAULT", fault.c_str(), 1);
        setenv("QUENCH_FAULT_AT", std::to_string(at).c_str(), 1);
        setenv("QUENCH_FAULT_MARK", mark.c_str(), 1);
        setenv("LD_PRELOAD", QUENCH_FAULTS_LIBRARY, 1);
        const Outcome outcome = quench(command.arguments);
        unsetenv("LD_PRELOAD");
        const std::string call = bytes_of(mark);
        if (call.empty()) {
          EXPECT_EQ(outcome.code, 0) << outcome.err;
          break;
        }
        std::size_t replaced = 0;
        for (const std::string& name : command.outputs) {
          if (is_old(name)) continue;
          ++replaced;
          EXPECT_TRUE(is_whole(name, content(name), expected.at(name))) << "half a file: " << name;
        }
        std::size_t temporaries = 0;
        for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
          const std::string name = entry.path().filename().string();
          if (!name.ends_with(".tmp")) continue;
          ++temporaries;
          EXPECT_TRUE(name.starts_with(".quench-")) << name;
          std::filesystem::remove_all(entry.path());
        }
        check(outcome, call, replaced, command.outputs.size(), temporaries);
        if (HasFailure()) return;
      }
      EXPECT_GE(at, 4) << "nothing was written, or not through the preloaded calls";
      if (command.arguments[0] == "run")  // it replaced what other commands read
        works({"core", "box.npy", "--lambda", "0", "-o", "core.vtp", "--overwrite"});
    }
  }

  static void expect_one_sentence(const Outcome& outcome) {
    const std::size_t begin = outcome.err.find("quench: ");
    ASSERT_NE(begin, std::string::npos) << outcome.err;
    EXPECT_EQ(outcome.err.find('\n', begin), outcome.err.size() - 1) << outcome.err;
  }

  bool page_ = false;
};

TEST_F(Faults, AFullDiskAtEveryCall) {
  sweep("full", [](const Outcome& outcome, const std::string& call, std::size_t replaced, std::size_t,
                   std::size_t temporaries) {
    EXPECT_EQ(outcome.code, 1);
    expect_one_sentence(outcome);
    EXPECT_NE(outcome.err.find("cannot write '"), std::string::npos) << outcome.err;
    if (call != "rename" && call != "flush folder") {
      EXPECT_EQ(replaced, 0u) << "an output was replaced though another could not be written";
    }
    EXPECT_EQ(temporaries, 0u);
  });
}

TEST_F(Faults, AnInterruptAtEveryCall) {
  sweep("interrupt", [](const Outcome& outcome, const std::string&, std::size_t replaced, std::size_t outputs,
                        std::size_t temporaries) {
    EXPECT_TRUE(outcome.code == 0 || outcome.code == 130) << outcome.code;
    EXPECT_EQ(replaced, outcome.code == 0 ? outputs : 0u);
    EXPECT_EQ(temporaries, 0u);
  });
}

TEST_F(Faults, ASecondInterruptAtEveryCall) {
  sweep("interrupt twice", [](const Outcome& outcome, const std::string& call, std::size_t replaced, std::size_t,
                              std::size_t temporaries) {
    EXPECT_EQ(outcome.code, 128 + SIGINT);
    if (call != "rename" && call != "flush folder") {
      EXPECT_EQ(replaced, 0u);
    }
    EXPECT_EQ(temporaries, 0u);
  });
}

TEST_F(Faults, KilledAtEveryCall) {
  sweep("kill", [](const Outcome& outcome, const std::string& call, std::size_t replaced, std::size_t, std::size_t) {
    EXPECT_EQ(outcome.code, 128 + SIGKILL);
    if (call != "rename" && call != "flush folder") {
      EXPECT_EQ(replaced, 0u);
    }
  });
}

// Of a folder that is replaced in two steps, and that is put back where the second one fails.
TEST_F(Faults, AFileSystemThatCannotExchangeNames) {
  setenv("QUENCH_NO_EXCHANGE", "1", 1);
  std::vector<Command> zarr = commands();
  std::erase_if(zarr, [](const Command& command) { return command.outputs[0] != "o.zarr"; });
  ASSERT_EQ(zarr.size(), 1u);
  int renamings = 0;
  sweep("once", zarr,
        [&](const Outcome& outcome, const std::string& call, std::size_t replaced, std::size_t outputs,
            std::size_t temporaries) {
          renamings += call == "rename";
          const bool unnoticed = call == "rename" && outcome.code == 0;  // the name of what is removed anyway
          EXPECT_EQ(outcome.code, unnoticed ? 0 : 1);
          if (call != "rename" && call != "flush folder") {
            EXPECT_EQ(replaced, 0u);
          }
          if (unnoticed) {
            EXPECT_EQ(replaced, outputs);
          }
          EXPECT_EQ(temporaries, 0u);
        });
  EXPECT_EQ(renamings, 4) << "three of the folder, one of the report";
}

// --- limits of the system and of the command line -----------------------------------------------------------------

rlim_t address_space = 0;

TEST_F(Faults, OutOfMemoryIsASentence) {
  works({"sample", "bumpy-sphere", "--fineness", "0.3", "-o", "s.ply"});
  works({"core", "s.ply", "--resolution", "48", "--lambda", "0", "-o", "axis.vtp"});
  before_start = [] {
    const rlimit limit{address_space, address_space};
    if (setrlimit(RLIMIT_AS, &limit) != 0) _exit(127);
  };
  int refused = 0;
  for (const std::vector<std::string>& command : std::vector<std::vector<std::string>>{
           {"core", "s.ply", "--resolution", "128", "--memory-limit", "100G", "-o", "o.vtp", "--overwrite"},
           {"skeleton", "axis.vtp", "-o", "o.vtp", "--overwrite"}})
    for (rlim_t megabytes = 60;; megabytes += 20) {  // from too little for its libraries to enough
      SCOPED_TRACE(fmt::format("{} MB: {}", megabytes, testing::PrintToString(command)));
      ASSERT_LT(megabytes, 4000u);
      folder.write("o.vtp", kOld);
      address_space = megabytes << 20;
      const auto before = files();
      const Outcome outcome = quench(command);
      if (outcome.code == 0) break;
      if (outcome.code == 127) continue;
      ++refused;
      EXPECT_EQ(outcome.code, 1) << outcome.err;
      expect_one_sentence(outcome);
      EXPECT_NE(outcome.err.find("memory"), std::string::npos) << outcome.err;
      EXPECT_EQ(files(), before);
    }
  EXPECT_GT(refused, 0);
}

TEST_F(Faults, MemoryIsPredicted) {
  const auto refused = [&](const std::vector<std::string>& command, const std::string& word) {
    refuses(1, {"of memory", "--memory-limit", word}, command);
  };
  refused({"sample", "root", "--branches", "50000", "--memory-limit", "1G", "-o", "o.ply"}, "--branches");
  refused({"sample", "torus", "--fineness", "0.1", "--resolution", "8192", "--memory-limit", "20M", "-o", "o.nrrd"},
          "8192");
  refused({"convert", "core.vtp", "o.ma", "--memory-limit", "1K"}, "'core.vtp'");
  refused({"info", "core.vtp", "--memory-limit", "1K"}, "'core.vtp'");
  refused({"burn", "core.vtp", "-o", "o.vtp", "--memory-limit", "1K"}, "'core.vtp'");
  refused({"skeleton", "core.vtp", "-o", "o.vtp", "--memory-limit", "1K"}, "'core.vtp'");
  refused({"verify", "box.npy", "core.vtp", "--memory-limit", "1K"}, "'core.vtp'");
  if (page_) refused({"view", "core.vtp", "-o", "o.html", "--memory-limit", "1K"}, "'core.vtp'");
  refuses(2, {"--fineness", "4,294,967,294"},
          {"sample", "root", "--branches", "100000", "--fineness", "16", "-o", "o.ply"});
  // The headers of volumes may promise more than their files have bytes: a .sof file of 200 bytes is 513^3 voxels.
  std::string octree = std::string("\0\2\0\0", 4);
  for (int level = 0; level < 9; ++level) octree += '\0';
  for (int leaf = 0; leaf < 8; ++leaf) octree += std::string("\2\xF0", 2);
  for (int level = 0; level < 8; ++level)
    for (int child = 0; child < 7; ++child) octree += std::string("\1\1", 2);
  folder.write("large.sof", octree);
  refuses(1, {"'large.sof'", "145 MB", "100 MB"}, {"core", "large.sof", "--memory-limit", "100M", "-o", "o.vtp"});
}

TEST_F(Faults, NobodyReadsStdout) {
  before_start = [] {
    int ends[2];
    if (pipe(ends) != 0 || dup2(ends[1], 1) < 0) _exit(127);
    close(ends[0]);
    close(ends[1]);
  };
  for (const std::vector<std::string>& command :
       std::vector<std::vector<std::string>>{{"info", "core.vtp"},
                                             {"verify", "box.npy", "core.vtp"},
                                             {"core", "box.npy", "-o", "o.vtp", "--json", "-"}}) {
    const Outcome outcome = quench(command);
    EXPECT_EQ(outcome.code, 1);
    EXPECT_TRUE(outcome.err.ends_with("quench: cannot write to stdout: Broken pipe\n")) << outcome.err;
  }
  EXPECT_TRUE(bytes("o.vtp").ends_with("</VTKFile>\n")) << "the result is lost with the reader of its report";
}

TEST_F(Faults, NobodyReadsStderr) {
  before_start = [] {
    int ends[2];
    if (pipe(ends) != 0 || dup2(ends[1], 2) < 0) _exit(127);
    close(ends[0]);
    close(ends[1]);
  };
  EXPECT_EQ(quench({"core", "box.npy", "-o", "o.vtp"}).code, 0);
  EXPECT_TRUE(bytes("o.vtp").ends_with("</VTKFile>\n"));
}

TEST_F(Faults, OutputsThatCannotBe) {
  std::filesystem::create_directory(folder / "dir");
  std::filesystem::create_hard_link(folder / "core.vtp", folder / "hard.vtp");
  std::filesystem::create_symlink(folder / "core.vtp", folder / "soft.vtp");
  for (const Command& command : commands()) {
    if (command.arguments[0] == "run") continue;
    for (const std::string& name : command.outputs) {
      const auto with = [&](const std::string& other) {
        std::vector<std::string> arguments = command.arguments;
        std::replace(arguments.begin(), arguments.end(), name, other);
        return arguments;
      };
      const std::string extension = std::filesystem::path(name).extension();
      std::filesystem::create_directories(folder / ("dir" + extension));
      folder.write("dir" + extension + "/file", kOld);
      if (std::find(command.arguments.begin(), command.arguments.end(), name) == command.arguments.end()) continue;
      refuses(2, {"folder"}, with("dir" + extension));
      refuses(1, {"does not exist"}, with("no/such" + extension));
      if (std::find(command.arguments.begin(), command.arguments.end(), "core.vtp") == command.arguments.end())
        continue;
      for (const char* same : {"core.vtp", "./core.vtp", "hard.vtp", "soft.vtp"})
        refuses(2, {"input itself"}, with(same));
    }
  }
}

TEST_F(Faults, AFolderWithoutPermission) {
  std::filesystem::create_directory(folder / "closed");
  chmod((folder / "closed").c_str(), 0555);
  chmod(folder.path().c_str(), 0755);
  before_start = [] {  // root may write everywhere
    if (geteuid() == 0 && (setgid(65534) != 0 || setuid(65534) != 0)) _exit(127);
  };
  if (quench({"--version"}).code != 0) GTEST_SKIP() << "another user cannot run the program";
  refuses(1, {"cannot write 'closed/o.vtp'", "not writable"}, {"core", "box.npy", "-o", "closed/o.vtp"});
  refuses(1, {"cannot write to 'closed/new'", "not writable"}, {"run", "box.npy", "-o", "closed/new"});
}

}  // namespace program_faults_test
