// SPDX-License-Identifier: Apache-2.0
#include <signal.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <random>

#include "program.h"

// The core in tasks: however they are divided, killed and repeated, the file is that of 'quench core'.

using namespace quench::testing_program;

namespace program_bricks_test {

using Words = std::vector<std::string>;

/// What schedulers set for an array of jobs.
void as_slurm() {
  setenv("SLURM_ARRAY_TASK_ID", "7", 1);
  setenv("SLURM_ARRAY_TASK_MIN", "3", 1);
  setenv("SLURM_ARRAY_TASK_STEP", "2", 1);
  setenv("SLURM_ARRAY_TASK_COUNT", "3", 1);
}
void as_aws() {
  setenv("AWS_BATCH_JOB_ARRAY_INDEX", "1", 1);
  setenv("AWS_BATCH_JOB_ARRAY_SIZE", "3", 1);
}
void as_kubernetes() {
  setenv("JOB_COMPLETION_INDEX", "0", 1);
  setenv("JOB_COMPLETIONS", "3", 1);
}
void as_incomplete() { setenv("JOB_COMPLETION_INDEX", "5", 1); }

class Bricks : public ProgramTest {
 protected:
  void SetUp() override {
    for (const char* name : {"SLURM_ARRAY_TASK_ID", "SLURM_ARRAY_TASK_COUNT", "AWS_BATCH_JOB_ARRAY_INDEX",
                             "AWS_BATCH_JOB_ARRAY_SIZE", "JOB_COMPLETION_INDEX", "JOB_COMPLETIONS"})
      unsetenv(name);
  }

  /// In two rounds with boxes of 8 voxels.
  void make_torus() { works({"sample", "torus", "--fineness", "0.2", "-o", "torus.ply"}); }
  Words torus(Words before, const Words& after) {
    before.insert(before.end(), {"torus.ply", "--resolution", "48"});
    before.insert(before.end(), after.begin(), after.end());
    return before;
  }
  void plan_torus(const std::string& work, const std::string& size = "8") {
    works(torus({"bricks", "plan"}, {"--size", size, "-o", work}));
  }
  nlohmann::json status(const std::string& work) {
    return nlohmann::json::parse(works({"bricks", "status", work, "--json"}).out);
  }
  void run_round(const std::string& work, std::size_t round) {
    works({"bricks", "run", work, "--round", std::to_string(round)});
  }
  void merge(const std::string& work, const std::string& output) {
    works({"bricks", "merge", work, "-o", output, "--overwrite"});
  }
  std::string part(std::size_t round, std::size_t brick) {
    std::string number = std::to_string(brick);
    return "work/round-" + std::to_string(round) + "/" + std::string(6 - number.size(), '0') + number + ".part";
  }
  void write(const std::string& name, const std::string& bytes) { folder.write(name, bytes); }
};

TEST_F(Bricks, TasksInAnyOrderAndOfAnyNumberMakeTheCore) {
  make_torus();
  works(torus({"core"}, {"-o", "core.vtp"}));
  std::mt19937 random(7);
  for (const std::size_t tasks : {1, 3, 10}) {
    const std::string work = "work" + std::to_string(tasks);
    plan_torus(work);
    ASSERT_EQ(status(work)["rounds"].size(), 2u);
    for (std::size_t round = 1; round <= 2; ++round) {
      std::vector<std::size_t> order;
      for (std::size_t i = 0; i < tasks; ++i) order.push_back(i);
      std::ranges::shuffle(order, random);
      for (const std::size_t i : order)
        works({"bricks", "run", work, "--round", std::to_string(round), "--task",
               std::to_string(i) + "/" + std::to_string(tasks), "--threads", std::to_string(1 + i % 2)});
    }
    for (const auto& round : status(work)["rounds"]) {
      EXPECT_EQ(round["done"], round["bricks"]);
      EXPECT_GT(round["peak_bytes"], 0);
      EXPECT_GT(round["bytes_read"], 0);
      EXPECT_GT(round["bytes_written"], 0);
    }
    EXPECT_FALSE(status(work)["merged"]);
    merge(work, "merged.vtp");
    EXPECT_TRUE(status(work)["merged"]);
    EXPECT_TRUE(bytes("merged.vtp") == bytes("core.vtp")) << tasks << " tasks";
  }
}

// Tasks need nothing but the folder, which may be elsewhere; a report has the sections of that of 'quench core'.
TEST_F(Bricks, TheFolderIsAllThatIsNeeded) {
  make_torus();
  works(torus({"core"}, {"-o", "core.vtp", "--json", "core.json"}));
  plan_torus("first");
  std::filesystem::remove(folder / "torus.ply");
  std::filesystem::rename(folder / "first", folder / "work");
  works({"bricks", "run", "work"});
  works({"bricks", "merge", "work", "-o", "merged.vtp", "--json", "merged.json"});
  EXPECT_TRUE(bytes("merged.vtp") == bytes("core.vtp"));
  const auto one = nlohmann::json::parse(bytes("core.json")), bricks = nlohmann::json::parse(bytes("merged.json"));
  for (const char* section : {"input", "parameters", "shape", "core", "pruned", "surface"}) {
    nlohmann::json a = one.at(section), b = bricks.at(section);
    for (const char* memory : {"in_bricks", "predicted_bytes"}) {
      if (a.is_object()) a.erase(memory);
      if (b.is_object()) b.erase(memory);
    }
    EXPECT_EQ(a, b) << section;
  }
}

TEST_F(Bricks, RandomVolumesWithOptionsOfCore) {
  const std::vector<Words> options{{},
                                   {"--threshold", "120", "--surface", "voxels"},
                                   {"--threshold", "100", "--surface", "grey"},
                                   {"--label", "1", "--surface", "smooth"},
                                   {"--lambda", "1vox", "--spacing", "1,1,2"},
                                   {"--detail", "0", "--subdivide", "2", "--largest-component"},
                                   {"--lambda", "1.5vox", "--lambda-rule", "ball", "--fill-cavities"},
                                   {"--detail", "3vox"}};
  std::mt19937 random(11);
  for (std::size_t i = 0; i < options.size(); ++i) {
    const bool grey = !options[i].empty() && options[i][0] == "--threshold";
    std::string samples;
    const int n = 22;
    double c[4][4];
    for (auto& ball : c)
      for (double& x : ball) x = 3 + static_cast<double>(random() % 16);
    for (int z = 0; z < n; ++z)
      for (int y = 0; y < n; ++y)
        for (int x = 0; x < n; ++x) {
          double value = 0;
          for (const auto& b : c)
            value = std::max(value, 200 - 14 * std::sqrt((x - b[0]) * (x - b[0]) + (y - b[1]) * (y - b[1]) +
                                                         (z - b[2]) * (z - b[2])));
          value += static_cast<double>(random() % 20);
          samples += grey ? static_cast<char>(static_cast<unsigned char>(std::clamp(value, 0.0, 255.0)))
                          : static_cast<char>(value > 130 ? 1 : 0);
        }
    write("v.npy", npy(n, n, n, samples));
    Words core{"core", "v.npy", "-o", "core.vtp", "--overwrite"};
    Words plan{"bricks", "plan", "v.npy", "--size", std::to_string(8 + i), "-o", "work" + std::to_string(i)};
    core.insert(core.end(), options[i].begin(), options[i].end());
    plan.insert(plan.end(), options[i].begin(), options[i].end());
    works(core);
    works(plan);
    works({"bricks", "run", "work" + std::to_string(i)});
    merge("work" + std::to_string(i), "merged.vtp");
    EXPECT_TRUE(bytes("merged.vtp") == bytes("core.vtp")) << testing::PrintToString(options[i]);
  }
}

TEST_F(Bricks, KilledAndRepeatedTasks) {
  make_torus();
  works(torus({"core"}, {"-o", "core.vtp"}));
  plan_torus("work");
  for (const std::size_t brick : {1, 3, 6}) {
    std::filesystem::remove(folder / part(1, brick));
    Running task = start_and_listen({"bricks", "run", "work", "--round", "1"});
    task.until_it_says("brick " + std::to_string(brick) + " of");
    kill(task.child, SIGKILL);
    const int code = wait(task).code;
    EXPECT_TRUE(code == 128 + SIGKILL || code == 0) << code;  // or it was faster
  }
  write("work/round-1/.quench-0123456789abcdef.tmp", "what a killed task leaves");
  // Two at the same time.
  const std::vector<pid_t> both{start({"bricks", "run", "work", "--round", "1"}),
                                start({"bricks", "run", "work", "--round", "1"})};
  for (const pid_t task : both) EXPECT_EQ(wait(task).code, 0);
  EXPECT_GE(status("work")["rounds"][0]["unfinished_files"], 1);
  works({"bricks", "run", "work"});
  merge("work", "merged.vtp");
  EXPECT_TRUE(bytes("merged.vtp") == bytes("core.vtp"));
  const auto before = files();
  const Outcome again = works({"bricks", "run", "work"});
  EXPECT_NE(again.err.find(": 0 bricks done"), std::string::npos) << again.err;
  EXPECT_EQ(files(), before);
  plan_torus("work");  // as well
  EXPECT_EQ(files(), before);
}

TEST_F(Bricks, RefusesDamagedAndForeignFiles) {
  make_torus();
  plan_torus("work");
  run_round("work", 1);
  const std::string good = bytes(part(1, 0));
  const auto refuses_part = [&](const std::string& bytes_of_part, const char* what) {
    write(part(1, 0), bytes_of_part);
    refuses(3, {"000000.part", what, "run its round again"}, {"bricks", "run", "work", "--round", "2"});
  };
  std::string flipped = good;
  flipped[good.size() / 2] = static_cast<char>(flipped[good.size() / 2] ^ 1);
  refuses_part(flipped, "damaged");
  refuses_part(good.substr(0, good.size() / 2), "damaged");
  refuses_part("", "cut off");
  refuses_part("no part of anything, but long enough to be looked at as one", "not a part");
  refuses_part(bytes(part(1, 1)), "another place");
  std::filesystem::remove(folder / part(1, 0));
  refuses(1, {"1 of the", "round 1", "not done"}, {"bricks", "run", "work", "--round", "2"});
  refuses(1, {"round 2", "not done"}, {"bricks", "merge", "work", "-o", "merged.vtp"});

  const std::string runs = bytes("work/shape/000000.runs");
  write("work/shape/000000.runs", "x" + runs.substr(1));
  refuses(3, {"000000.runs", "damaged"}, {"bricks", "run", "work", "--round", "1", "--task", "0/1000"});
  write("work/shape/000000.runs", runs);
  const std::string mesh = bytes("work/surface.mesh");
  run_round("work", 1);
  write("work/surface.mesh", mesh.substr(1));
  refuses(3, {"surface.mesh", "damaged"}, {"bricks", "run", "work", "--round", "2"});
  write("work/surface.mesh", mesh);

  const std::string plan = bytes("work/plan.json");
  const auto refuses_plan = [&](const std::string& text, const char* what) {
    write("work/plan.json", text);
    refuses(3, {"plan.json", what}, {"bricks", "status", "work"});
    refuses(3, {"plan.json", what}, {"bricks", "run", "work"});
  };
  refuses_plan(plan.substr(0, plan.size() / 2), "damaged");
  refuses_plan("{}", "another version");
  std::string other = plan;
  other.replace(other.find(QUENCH_TEST_VERSION), std::string(QUENCH_TEST_VERSION).size(), "0.0.0");
  refuses_plan(other, "another version");
  other = plan;
  other.replace(other.find("\"rounds\""), 8, "\"sounds\"");
  refuses_plan(other, "damaged");
  std::filesystem::remove(folder / "work/plan.json");
  refuses(3, {"holds no plan"}, {"bricks", "run", "work"});
  refuses(3, {"holds no plan"}, {"bricks", "status", "nowhere"});
}

// Parts of one plan are not those of another with boxes at the same places.
TEST_F(Bricks, RefusesPartsOfAnotherPlan) {
  make_torus();
  plan_torus("work");
  works(torus({"bricks", "plan"}, {"--size", "12", "--detail", "3vox", "-o", "other"}));
  run_round("work", 1);
  run_round("other", 1);
  std::filesystem::copy_file(folder / "other/round-1/000002.part", folder / part(1, 2),
                             std::filesystem::copy_options::overwrite_existing);
  refuses(3, {"000002.part", "another plan"}, {"bricks", "run", "work", "--round", "2"});
}

TEST_F(Bricks, RefusesWhatCannotBe) {
  make_torus();
  refuses(2, {"below the threshold"}, torus({"bricks", "plan"}, {"--full", "-o", "work"}));
  refuses(2, {"lambda", "length"}, torus({"bricks", "plan"}, {"--lambda", "auto", "-o", "work"}));
  refuses(2, {"--size", "7"}, torus({"bricks", "plan"}, {"--size", "7", "-o", "work"}));
  refuses(2, {"--in-bricks"}, torus({"core", "--in-bricks"}, {"--full", "-o", "core.vtp"}));
  refuses(1, {"nowhere"}, torus({"core", "--in-bricks=nowhere"}, {"-o", "core.vtp"}));
  refuses(2, {"plan", "run", "merge", "status"}, {"bricks"});
  refuses(2, {"unknown command 'pln'", "'plan'"}, {"bricks", "pln"});
  refuses(2, {"--sise", "--size", "quench bricks plan --help"}, torus({"bricks", "plan"}, {"--sise", "9", "-o", "w"}));
  plan_torus("work");
  refuses(2, {"another plan"}, torus({"bricks", "plan"}, {"--size", "13", "-o", "work"}));
  refuses(2, {"--round", "3"}, {"bricks", "run", "work", "--round", "3"});
  refuses(2, {"--round", "0"}, {"bricks", "run", "work", "--round", "0"});
  refuses(2, {"--round", "2 tasks"}, {"bricks", "run", "work", "--task", "0/2"});
  for (const char* task : {"2/2", "1", "a/2", "0/0", "-1/2", "1/2/3"})
    refuses(2, {"--task", task}, {"bricks", "run", "work", "--round", "1", "--task", task});
  write("file", "");
  refuses(2, {"file", "not a folder"}, torus({"bricks", "plan"}, {"-o", "file"}));
  std::filesystem::create_directory(folder / "full");
  write("full/letter.txt", "mine");
  refuses(2, {"full", "letter.txt"}, torus({"bricks", "plan"}, {"-o", "full"}));
  refuses(1, {"no/work"}, torus({"bricks", "plan"}, {"-o", "no/work"}));
  refuses(2, {"merged.xyz"}, {"bricks", "merge", "work", "-o", "merged.xyz"});
}

TEST_F(Bricks, TasksOfSchedulers) {
  make_torus();
  plan_torus("work");
  const auto done_by = [&](void (*scheduler)()) {
    before_start = scheduler;
    works({"bricks", "run", "work", "--round", "1"});
    before_start = nullptr;
    return status("work")["rounds"][0]["done"].get<std::size_t>();
  };
  const std::size_t bricks = status("work")["rounds"][0]["bricks"];
  EXPECT_EQ(done_by(as_slurm), bricks / 3);  // 2 modulo 3
  EXPECT_EQ(done_by(as_aws), bricks / 3 + (bricks + 1) / 3);
  EXPECT_EQ(done_by(as_kubernetes), bricks);
  before_start = as_incomplete;
  refuses(2, {"JOB_COMPLETION_INDEX", "JOB_COMPLETIONS", "--task"}, {"bricks", "run", "work", "--round", "1"});
}

TEST_F(Bricks, AFullDiskIsSaid) {
  make_torus();
  plan_torus("work");
  const Outcome outcome = wait(start({"bricks", "run", "work", "--round", "1"}, 2000));
  EXPECT_EQ(outcome.code, 1) << outcome.err;
  EXPECT_NE(outcome.err.find("cannot write"), std::string::npos) << outcome.err;
  EXPECT_EQ(status("work")["rounds"][0]["unfinished_files"], 0);
  const Outcome in_bricks = wait(start(torus({"core", "--in-bricks"}, {"-o", "core.vtp"}), 2000));
  EXPECT_EQ(in_bricks.code, 1) << in_bricks.err;
  EXPECT_NE(in_bricks.err.find("cannot write"), std::string::npos) << in_bricks.err;
}

TEST_F(Bricks, OneMachineInBricks) {
  make_torus();
  works(torus({"core"}, {"-o", "core.vtp"}));
  std::filesystem::create_directory(folder / "there");
  std::filesystem::create_directory(folder / "parts");
  works(torus({"core", "--in-bricks"}, {"-o", "there/core.vtp"}));
  works(torus({"core", "--in-bricks=parts"}, {"-o", "other.vtp", "--json", "report.json"}));
  EXPECT_TRUE(bytes("there/core.vtp") == bytes("core.vtp"));
  EXPECT_TRUE(bytes("other.vtp") == bytes("core.vtp"));
  EXPECT_TRUE(nlohmann::json::parse(bytes("report.json"))["core"]["in_bricks"]);
  EXPECT_EQ(files().size(), 7u);  // nothing else is left
}

}  // namespace program_bricks_test
