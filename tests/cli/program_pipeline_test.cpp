// SPDX-License-Identifier: Apache-2.0
// Random shapes, random options, random numbers of threads through the whole program; every result must pass `verify`
// and be the same for another number of threads. Fixed seeds; `make soak` goes on from another one for a given time:
//   QUENCH_SOAK_SECONDS=600 QUENCH_SOAK_SEED=1 cli_tests --gtest_filter=ProgramPipeline.*
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

#include "program.h"
#include "quench/io.h"
#include "random_shapes.h"

namespace quench::testing_program {
namespace program_pipeline_test {

class Choice {
 public:
  explicit Choice(std::uint64_t seed) : random_(seed * 0x9E3779B97F4A7C15ull + 7) {}
  std::size_t below(std::size_t n) { return static_cast<std::size_t>(random_() % n); }
  bool one_in(std::size_t n) { return below(n) == 0; }
  std::string of(const std::vector<std::string>& words) { return words[below(words.size())]; }

 private:
  std::mt19937_64 random_;
};

class ProgramPipeline : public ProgramTest {
 protected:
  // Writes a random shape and returns the words that name it for any command.
  std::vector<std::string> make_shape(Choice& choice, std::uint64_t seed) {
    std::vector<std::string> words;
    if (choice.one_in(3)) {
      const std::string name = choice.of({"ellipsoid", "torus", "box", "four-blobs", "plate-with-holes",
                                          "hollow-sphere", "fin-on-board", "root", "rough-plate"});
      works({"sample", name, "-o", "shape.ply", "--seed", std::to_string(seed), "--branches", "5", "--fineness", "0.1",
             "--quiet"});
      words = {"shape.ply", "--resolution", std::to_string(20 + choice.below(50))};
      if (choice.one_in(4)) words.insert(words.end(), {"--fill", "evenodd"});
      if (name == "root" && words.size() > 3) words.resize(3);  // its parts overlap: evenodd would cut them
    } else {
      const VoxelShape shape =
          testing_shapes::random_shape(seed, 5 + static_cast<int>(choice.below(12)), choice.one_in(3));
      io::write_volume(folder / "shape.nrrd", shape);
      words = {"shape.nrrd"};
      const Grid& grid = shape.grid();
      if (choice.one_in(6) && shape.voxel_count() < grid.dims[0] * grid.dims[1] * grid.dims[2])
        words.emplace_back("--invert");
    }
    if (choice.one_in(5)) words.emplace_back("--largest-component");
    if (choice.one_in(5)) words.emplace_back("--fill-cavities");
    if (choice.one_in(6)) words.insert(words.end(), {"--subdivide", "2"});
    return words;
  }

  static std::vector<std::string> make_options(Choice& choice) {
    std::vector<std::string> words;
    const auto add = [&](std::size_t chance, const char* option, const std::vector<std::string>& values) {
      if (choice.one_in(chance)) words.insert(words.end(), {option, choice.of(values)});
    };
    add(2, "--lambda", {"0", "0.5vox", "1vox", "0.71vox", "3vox", "0.02", "10%", "inf"});
    add(4, "--lambda-rule", {"ball", "coface"});
    add(3, "--omega", {"0.5vox", "2vox", "5%"});
    add(5, "--radius", {"auto", "exact"});  // linear radii are not those of a voxel core, and verify says so
    add(2, "--theta2", {"0", "1vox", "3vox", "0.1", "inf"});
    add(2, "--theta1", {"0", "1vox", "0.1", "inf"});
    add(3, "--smooth", {"0", "1", "40"});
    add(3, "--resample", {"1vox", "0.03"});
    add(3, "--tips", {"pruned", "full"});
    return words;
  }

  void try_seed(std::uint64_t seed) {
    for (const auto& entry : std::filesystem::directory_iterator(folder.path()))
      std::filesystem::remove_all(entry.path());
    Choice choice(seed);
    const std::vector<std::string> shape = make_shape(choice, seed);
    const std::vector<std::string> options = make_options(choice);
    const std::string threads[2]{std::to_string(1 + choice.below(4)), std::to_string(1 + choice.below(4))};
    std::string line;
    for (const auto* words : {&shape, &options})
      for (const std::string& word : *words) line += word + " ";
    SCOPED_TRACE("seed " + std::to_string(seed) + ": " + line + "--threads " + threads[0] + " and " + threads[1]);
    for (const int run : {0, 1}) {
      std::vector<std::string> words{"run",     "-o",          run == 0 ? "a" : "b", "--no-view",
                                     "--quiet", "--overwrite", "--threads",          threads[run]};
      words.insert(words.end(), shape.begin(), shape.end());
      words.insert(words.end(), options.begin(), options.end());
      // Pictures, which take most of the time, are not compared.
      if (run == 1 || seed % 5 != 0) words.emplace_back("--no-picture");
      const Outcome outcome = quench(words);
      ASSERT_EQ(outcome.code, 0) << outcome.err;
    }
    for (const char* name : {"core.vtp", "skeleton.vtp", "skeleton.swc", "branches.csv", "parts.csv"}) {
      ASSERT_EQ(exists(std::string("a/") + name), exists(std::string("b/") + name)) << name;
      EXPECT_EQ(bytes(std::string("a/") + name), bytes(std::string("b/") + name)) << name;
    }
    std::vector<std::string> words{"verify", "--quiet"};
    words.insert(words.end(), shape.begin(), shape.end());
    words.insert(words.end(), {"a/core.vtp", "a/skeleton.vtp"});
    const Outcome proof = quench(words);
    ASSERT_EQ(proof.code, 0) << proof.out << proof.err;
  }
};

TEST_F(ProgramPipeline, RandomShapesAndOptionsAreVerified) {
  const char* seconds = std::getenv("QUENCH_SOAK_SECONDS");
  const char* first = std::getenv("QUENCH_SOAK_SEED");
  const std::uint64_t begin = first != nullptr ? std::strtoull(first, nullptr, 10) : 1;
  if (seconds == nullptr) {
    for (std::uint64_t seed = begin; seed < begin + 30; ++seed) try_seed(seed);
    return;
  }
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(std::strtoll(seconds, nullptr, 10));
  std::uint64_t seed = begin;
  for (; std::chrono::steady_clock::now() < end; ++seed) try_seed(seed);
  std::printf("%llu random pipelines from seed %llu\n", static_cast<unsigned long long>(seed - begin),
              static_cast<unsigned long long>(begin));
}

}  // namespace program_pipeline_test
}  // namespace quench::testing_program
