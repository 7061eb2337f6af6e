// SPDX-License-Identifier: Apache-2.0
#include <string>
#include <vector>

#include "program.h"
#include "quench/io.h"
#include "quench/record.h"

using namespace quench::testing_program;
using quench::find_array;
using quench::Record;

namespace program_units_test {

class Units : public ProgramTest {
 protected:
  std::string field(const std::string& name) const {
    const Record data = quench::io::read_record(folder / name);
    const auto* array = find_array(data.field_data, "units");
    return array ? std::get<std::vector<std::string>>(array->values).at(0) : "absent";
  }
  std::string text(const std::string& name) const { return bytes_of(folder / name); }
};

bool says(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST_F(Units, AreNamesAndScaleNothing) {
  works({"sample", "box", "-o", "box.ply"});
  works({"core", "box.ply", "--resolution", "12", "-o", "none.vtp"});
  works({"core", "box.ply", "--resolution", "12", "--units", "um", "-o", "um.vtp"});
  EXPECT_EQ(field("none.vtp"), "");
  EXPECT_EQ(field("um.vtp"), "um");
  const Record none = quench::io::read_record(folder / "none.vtp"), um = quench::io::read_record(folder / "um.vtp");
  EXPECT_EQ(none.points, um.points);
  EXPECT_EQ(find_array(none.point_data, "radius")->numbers(), find_array(um.point_data, "radius")->numbers());
}

TEST_F(Units, OfEveryStep) {
  works({"sample", "box", "-o", "box.ply"});
  works({"voxelize", "box.ply", "--resolution", "12", "--units", "\xc2\xb5m", "-o", "box.nrrd"});
  EXPECT_EQ(quench::io::read_volume(folder / "box.nrrd").coordinates.units, "\xc2\xb5m");
  const auto run = works({"run", "box.nrrd", "--units", "mm", "--no-view", "-o", "out"});
  EXPECT_TRUE(says(run.err, "has coordinates in \xc2\xb5m; they are called mm, as --units says, and not scaled"))
      << run.err;
  EXPECT_EQ(field("out/core.vtp"), "mm");
  EXPECT_TRUE(says(text("out/parts.csv"), "[mm")) << text("out/parts.csv");
  EXPECT_TRUE(says(text("out/report.json"), "\"units\": \"mm\""));
  works({"skeleton", "out/core.vtp", "--units", "cm", "--theta2", "inf", "--swc", "s.swc", "-o", "s.vtp"});
  EXPECT_EQ(field("s.vtp"), "cm");
  EXPECT_TRUE(says(text("s.swc"), "units: cm")) << text("s.swc");
  works({"parts", "out/skeleton.vtp", "--units", "in", "--csv", "parts.csv", "-o", "parts.vtp"});
  EXPECT_TRUE(says(text("parts.csv"), "[in"));
  works({"convert", "out/skeleton.vtp", "copy.vtp", "--units", "km"});
  EXPECT_EQ(field("copy.vtp"), "km");
  folder.write("t.swc", "1 3 0 0 0 1 -1\n2 3 0 0 5 1 1\n3 3 2 0 9 1 2\n4 3 -2 0 9 1 2\n");
  works({"tree", "t.swc", "--units", "nm", "--no-view", "--no-picture", "-o", "tree"});
  EXPECT_TRUE(says(text("tree/tree.rsml"), "<unit>nm</unit>")) << text("tree/tree.rsml");
  EXPECT_TRUE(says(text("tree/axes.csv"), "[nm]")) << text("tree/axes.csv");
}

TEST_F(Units, OfAMeshAreInItsReport) {
  works({"sample", "box", "-o", "box.ply"});
  works({"core", "box.ply", "--resolution", "12", "--units", "mm", "-o", "a.vtp", "--json", "a.json"});
  EXPECT_TRUE(says(text("a.json"), "\"units\": \"mm\""));
  works({"burn", "a.vtp", "-o", "b.vtp"});
  EXPECT_EQ(field("b.vtp"), "mm");
}

TEST_F(Units, RefusesWhatIsNoName) {
  works({"sample", "box", "-o", "box.ply"});
  for (const char* unit : {"0.5mm", "m m", "<mm>", "a,b", "\xff", "mm\n", "123456789012345678901234567890123"})
    refuses(2, {"--units", "is not the name of a unit"}, {"core", "box.ply", "--units", unit, "-o", "a.vtp"});
}

}  // namespace program_units_test
