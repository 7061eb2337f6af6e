// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>

#include "program.h"

// What the program says it will need is what it needs, and not much more.

using namespace quench::testing_program;

namespace {

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

// A curved surface, flat walls, and a body full of holes. On one thread the peak is the same in every run; on two it
// depends on what they do at the same time.
TEST_F(Memory, IsPredictedForACore) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers take memory of their own";
#endif
  works({"sample", "bumpy-sphere", "--fineness", "0.3", "-o", "sphere.ply"});
  works({"sample", "box", "-o", "box.ply"});
  works({"sample", "bead-pack", "--fineness", "0.5", "-o", "beads.ply"});
  const struct {
    const char *file, *resolution;
  } shapes[] = {{"sphere.ply", "360"}, {"box.ply", "450"}, {"beads.ply", "128"}};
  for (const auto& [file, resolution] : shapes)
    for (const char* threads : {"1", "2"}) {
      const double found = ratio(file, resolution, threads);
      const bool alone = std::string(threads) == "1";
      EXPECT_GE(found, alone ? 1.0 : 0.95) << file << ", threads " << threads;
      EXPECT_LE(found, alone ? 1.15 : 1.3) << file << ", threads " << threads;
    }
}

}  // namespace
