// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>

#include "full_run.h"
#include "program.h"

// What the program says it will need is what it needs, and not much more.

using namespace quench::testing_program;

namespace program_memory_test {

class Memory : public ProgramTest {
 protected:
  /// The prediction over the peak; both of the whole process.
  double ratio(const std::string& file, const std::string& resolution, const std::string& threads) {
    works({"core", file, "--resolution", resolution, "--threads", threads, "-o", "o.vtp", "--json", "r.json",
           "--overwrite", "--quiet"});
    const nlohmann::json report = nlohmann::json::parse(bytes("r.json"));
    EXPECT_GT(report["shape"]["sites"].get<int>(), 500'000) << "too small to tell";
    return report["core"]["predicted_bytes"].get<double>() / report["peak_bytes"].get<double>();
  }
};

struct LargeSample {
  const char *name, *fineness, *resolution;
};

class MemoryOfSamples : public Memory, public testing::WithParamInterface<LargeSample> {};

// On one thread the peak is the same in every run; on two it depends on what they do at the same time.
TEST_P(MemoryOfSamples, IsPredictedForACore) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers take memory of their own";
#endif
  const auto& [name, fineness, resolution] = GetParam();
  before_start = [] {};  // a new process
  works({"sample", name, "--fineness", fineness, "-o", "sample.ply"});
  const bool flat = std::string(name) == "box";
  for (const char* threads : {"1", "2"}) {
    const bool alone = std::string(threads) == "1";
    if (!alone && !flat && !quench::full_run()) continue;
    const double found = ratio("sample.ply", resolution, threads);
    EXPECT_GE(found, alone ? 1.0 : 0.95) << "threads " << threads;
    EXPECT_LE(found, alone ? 1.15 : 1.3) << "threads " << threads;
  }
}

// A curved surface, flat walls, and a body full of holes.
INSTANTIATE_TEST_SUITE_P(Large, MemoryOfSamples,
                         testing::Values(LargeSample{"bumpy-sphere", "0.3", "340"}, LargeSample{"box", "1", "415"},
                                         LargeSample{"bead-pack", "0.15", "110"}),
                         [](const auto& of) {
                           std::string name = of.param.name;
                           std::erase(name, '-');
                           return name;
                         });

}  // namespace program_memory_test
