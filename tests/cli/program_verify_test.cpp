// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <string>
#include <vector>

#include "plane_shapes.h"
#include "program.h"
#include "quench/io.h"
#include "random_shapes.h"

// What verify computes again with the program's own stages.

using namespace quench::testing_program;
using quench::DataArray;
using quench::Record;

namespace program_verify_test {

const std::vector<std::string> kMeasures{"core_erosion_thickness", "relative_erosion_thickness"};

class Verifying : public ProgramTest {
 protected:
  std::string core_of(const std::vector<std::string>& shape, const std::vector<std::string>& options) {
    std::vector<std::string> words{"core"};
    words.insert(words.end(), shape.begin(), shape.end());
    words.insert(words.end(), options.begin(), options.end());
    words.insert(words.end(),
                 {"--measures", fmt::format("{},{}", kMeasures[0], kMeasures[1]), "-o", "core.vtp", "--overwrite"});
    return works(words).err;
  }

  /// A value of a measure that is a little less, where no other is above it.
  void damage(const std::string& measure, bool of_points, std::size_t at) {
    Record data = quench::io::read_record(folder / "core.vtp");
    for (DataArray& array : of_points ? data.point_data : data.cell_data)
      if (array.name == measure) {
        std::vector<double> numbers = array.numbers();
        numbers[at % numbers.size()] += numbers[at % numbers.size()] < 0.5 ? 1e-6 : -1e-6;
        array.values = std::move(numbers);
      }
    quench::io::write_record(folder / "bad.vtp", data);
  }
};

TEST_F(Verifying, WholeCoresAreBurnedAgain) {
  works({"sample", "fin-on-board", "-o", "mesh.ply"});
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    quench::io::write_volume(folder / "shape.nrrd",
                             seed % 3 == 2 ? quench::testing_planes::random_plane_shape(seed, 12)
                                           : quench::testing_shapes::random_shape(seed, 8, seed % 2 == 0));
    std::vector<std::string> shape{"shape.nrrd"};
    if (seed % 3 == 2) shape.insert(shape.end(), {"--dimension", "2"});
    if (seed % 3 == 1) shape = {"mesh.ply", "--resolution", "14"};  // fitted
    for (const std::vector<std::string>& whole :
         {std::vector<std::string>{"--full"}, {"--lambda", "0"}, {"--full", "--prune-by", "scale_axis=1.2"}}) {
      core_of(shape, whole);
      const std::vector<std::string> good{"verify", shape[0], "core.vtp"}, bad{"verify", shape[0], "bad.vtp"};
      const std::string said = works(good).out;
      for (const char* name : {"core", "relative"})
        EXPECT_NE(said.find(fmt::format("ok   {} erosion thickness: that of ", name)), said.npos) << said;
      EXPECT_NE(said.find(" cells is what burning the core again gives"), said.npos) << said;
      EXPECT_EQ(said.find("the whole core is not burned again"), said.npos) << said;
      for (const bool relative : {false, true}) {
        const bool of_points = relative == (whole.size() == 1);
        damage(kMeasures[relative], of_points, 7 * seed + 3);
        const Outcome outcome = quench(bad);
        EXPECT_EQ(outcome.code, 4) << seed << relative << of_points;
        const std::string check = relative ? "relative erosion thickness" : "core erosion thickness";
        EXPECT_NE(outcome.out.find("FAIL " + check), std::string::npos) << outcome.out;
      }
    }
  }
}

// What a pruning has left is not the whole core: only bounds, and verify says so.
TEST_F(Verifying, OfPruningsOnlyBounds) {
  folder.write("box.npy", npy_box(9, 7, 5, 1));
  core_of({"box.npy"}, {"--lambda", "2vox"});
  const std::string said = works({"verify", "box.npy", "core.vtp"}).out;
  EXPECT_NE(said.find("the whole core is not burned again"), said.npos) << said;
}

}  // namespace program_verify_test
