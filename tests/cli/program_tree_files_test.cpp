// SPDX-License-Identifier: Apache-2.0
// Trees of files in `quench info` and `quench convert`; sparse voxel lists.
#include <cstdio>

#include "data.h"
#include "program.h"
#include "quench/geometry.h"

namespace quench::testing_program {
namespace program_tree_files_test {

constexpr const char* kSwc = "1 1 0 0 0 2 -1\n2 3 3 0 0 1 1\n3 3 6 0 0 1 2\n4 3 3 4 0 1 2\n";

class ProgramTreeFilesTest : public ProgramTest {};

TEST_F(ProgramTreeFilesTest, InfoSaysWhatIsInATree) {
  folder.write("a.swc", kSwc);
  const Outcome swc = quench({"info", "a.swc"});
  EXPECT_EQ(swc.code, 0) << swc.err;
  for (const char* line : {"kind: tree\n", "nodes: 4\n", "tips: 2\n", "forks: 1\n", "length: 10.0\n", "somas: 1\n"})
    EXPECT_NE(swc.out.find(line), std::string::npos) << line << swc.out;
  EXPECT_EQ(quench({"convert", "a.swc", "-o", "a.rsml"}).code, 0);
  const Outcome rsml = quench({"info", "a.rsml"});
  for (const char* line : {"axes: 2\n", "tips: 2\n", "length: 10.0\n", "axes_per_level: [1,1]\n"})
    EXPECT_NE(rsml.out.find(line), std::string::npos) << line << rsml.out;
}

TEST_F(ProgramTreeFilesTest, TreesAreConverted) {
  folder.write("a.swc", kSwc);
  for (const char* name : {"b.rsml", "b.mtg", "b.vtp", "b.graphml", "b.swc"})
    EXPECT_EQ(quench({"convert", "a.swc", name}).code, 0) << name;
  EXPECT_EQ(quench({"convert", "b.rsml", "-o", "c.swc"}).code, 0);
  for (const char* sample : {"2 3 3 0 0 1 1\n", " 3 3 4 0 1 2\n", " 3 6 0 0 1 2\n"})
    EXPECT_NE(bytes_of(folder / "c.swc").find(sample), std::string::npos) << sample << bytes_of(folder / "c.swc");
  EXPECT_EQ(quench({"convert", "a.swc", "b.ply"}).code, 2);
  EXPECT_EQ(quench({"convert", "a.swc", "a.swc", "--overwrite"}).code, 2);
  EXPECT_EQ(quench({"convert", "b.vtp", "d.rsml"}).code, 2);  // lines, not a tree
  folder.write("bad.swc", "1 3 0 0 0 1 2\n2 3 0 0 0 1 1\n");
  const Outcome bad = quench({"info", "bad.swc"});
  EXPECT_EQ(bad.code, 3);
  EXPECT_NE(bad.err.find("circle"), std::string::npos) << bad.err;
}

TEST_F(ProgramTreeFilesTest, RealVoxelLists) {
  REQUIRE_DATA("volumes/roots_out");
  struct List {
    const char* name;
    const char* dims;
    Vec3 origin;
    const char* voxels;
  };
  for (const List& list :
       {List{"ZmIHPp2355d06_efloro_2015-10-21_08-56-21_rootwork.out", "[25,19,25]", {7.35, 9.3, 0}, "1: 2221\n"},
        List{"ZmIHPp2360d06_efloro_2015-10-21_08-56-22_rootwork.out", "[51,49,170]", {1.5, 5.7, 0.3}, "1: 6959\n"},
        List{
            "ZmIHPp2442d06_efloro_2015-10-21_12-40-25_rootwork.out", "[128,142,296]", {4.35, 1.95, 2.85}, "1: 10818\n"},
        List{
            "ZmIHPp2136d06_efloro_2015-10-28_16-43-01_rootwork.out", "[83,78,296]", {2.7, 13.65, 0.9}, "1: 11692\n"}}) {
    const Outcome info = quench({"info", (data_file("volumes/roots_out") / list.name).string()});
    EXPECT_EQ(info.code, 0) << info.err;
    for (const std::string part : {"spacing: [0.15,0.15,0.15]\n", "units: mm\n", "type: uint8\n"})
      EXPECT_NE(info.out.find(part), std::string::npos) << part << info.out;
    for (const char* part : {list.dims, list.voxels})
      EXPECT_NE(info.out.find(part), std::string::npos) << part << info.out;
    const std::size_t at = info.out.find("origin: ");
    ASSERT_NE(at, std::string::npos) << info.out;
    double x = 0, y = 0, z = 0;
    ASSERT_EQ(std::sscanf(info.out.c_str() + at, "origin: [%lf,%lf,%lf]", &x, &y, &z), 3) << info.out;
    EXPECT_LE((Vec3(x, y, z) - list.origin).norm(), 1e-12) << info.out;
  }
}

}  // namespace program_tree_files_test
}  // namespace quench::testing_program
