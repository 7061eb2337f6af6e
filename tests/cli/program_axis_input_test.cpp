// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <sys/stat.h>

#include <cmath>
#include <cstdlib>
#include <functional>
#include <limits>

#include "program.h"
#include "quench/io.h"

// Axes with numbers nothing can be computed with, and files without an end.

using namespace quench::testing_program;
using quench::DataArray;
using quench::Record;

namespace program_axis_input_test {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

class AxisInput : public ProgramTest {
 protected:
  void SetUp() override {
    folder.write("box.npy", npy_box(5, 4, 3, 1));
    works({"core", "box.npy", "--lambda", "0", "-o", "core.vtp"});
    core_ = quench::io::read_record(folder / "core.vtp");
  }

  void write_changed(const std::string& name, const std::function<void(Record&)>& change) {
    Record data = core_;
    change(data);
    quench::io::write_record(folder / name, data);
  }
  void write_with_field(const std::string& name, const DataArray& field) {
    write_changed(name, [&](Record& data) {
      std::erase_if(data.field_data, [&](const DataArray& array) { return array.name == field.name; });
      data.field_data.push_back(field);
    });
  }

  const std::vector<std::vector<std::string>> commands{
      {"burn", "bad.vtp", "-o", "o.vtp"},
      {"burn", "bad.vtp", "-o", "o.ply"},
      {"skeleton", "bad.vtp", "--swc", "o.swc", "-o", "o.vtp"},
  };
  Record core_;
};

TEST_F(AxisInput, RadiiAndCoordinatesBeyondWhatCanBeSquared) {
  for (const double large : {1e308, 1e200, 1.1e150, kInfinite, -1.0, std::nan("")}) {
    write_changed("bad.vtp", [&](Record& data) {
      for (DataArray& array : data.point_data)
        if (array.name == "radius") std::get<std::vector<double>>(array.values)[3] = large;
    });
    for (const auto& command : commands) refuses(3, {"'bad.vtp'", "vertex 3", fmt::format("{}", large)}, command);
  }
  for (const double large : {1e308, -1e200}) {
    write_changed("bad.vtp", [&](Record& data) { data.points[3][1] = large; });
    for (const auto& command : commands)
      refuses(3, {"'bad.vtp'", "vertex 3", fmt::format("{}", std::abs(large))}, command);
  }
  write_changed("radii.r", [](Record&) {});
  std::string radii = bytes("radii.r");
  radii.replace(radii.rfind(' ') + 1, std::string::npos, "1e308\n");
  folder.write("radii.r", radii);
  refuses(3, {"'core.vtp'", "1e+308"}, {"burn", "core.vtp", "--radii", "radii.r", "-o", "o.vtp"});
}

// Whatever a file says beside its cells is used only when it can be; an option nobody gave is not blamed.
TEST_F(AxisInput, FieldsThatCannotBe) {
  const std::vector<DataArray> fields{
      {"omega", 1, std::vector<double>{kInfinite}},           {"omega", 1, std::vector<double>{0}},
      {"omega", 1, std::vector<std::string>{"0.1"}},          {"longest_side", 1, std::vector<double>{-5}},
      {"longest_side", 1, std::vector<double>{std::nan("")}}, {"spacing", 3, std::vector<double>{1, kInfinite, 1}},
      {"spacing", 1, std::vector<std::int64_t>{1, 1}},        {"lambda", 1, std::vector<double>{-1}},
      {"propagation", 1, std::vector<std::string>{"by air"}}, {"radius_rule", 1, std::vector<double>{1}},
  };
  for (const DataArray& field : fields) {
    write_with_field("bad.vtp", field);
    for (const std::vector<std::string>& command : {commands[0], commands[2]}) {
      std::vector<std::string> words = command;
      words.emplace_back("--overwrite");
      const Outcome outcome = works(words);
      EXPECT_NE(outcome.err.find("note: the field '" + field.name + "' of 'bad.vtp' is "), std::string::npos)
          << outcome.err;
      const std::string result = bytes("o.vtp");
      EXPECT_EQ(result.find(">inf"), std::string::npos);
    }
  }
}

// What a result says of its shape is checked as options are, and the file is named.
TEST_F(AxisInput, ParametersThatCannotBe) {
  for (const char* parameter :
       {"\"resolution\":0", "\"resolution\":\"8\"", "\"fill\":\"odd\"", "\"spacing\":\"1,2,\"", "\"spacing\":\"-1\"",
        "\"dimension\":4", "\"channel\":\"hue\"", "\"subdivide\":4294967297", "\"subdivide\":0", "\"min_component\":-1",
        "\"invert\":1", "\"label\":0.5"}) {
    write_with_field("bad.vtp", {"parameters", 1, std::vector<std::string>{fmt::format("{{{}}}", parameter)}});
    const std::string name = std::string(parameter).substr(1, std::string(parameter).find('"', 1) - 1);
    refuses(3, {"'bad.vtp'", "'parameters'", name + " = "}, {"verify", "box.npy", "bad.vtp"});
  }
  write_with_field("good.vtp", {"parameters", 1, std::vector<std::string>{"{\"resolution\":8,\"fill\":\"auto\"}"}});
  works({"verify", "box.npy", "good.vtp"});
}

TEST_F(AxisInput, FilesWithoutAnEnd) {
  if (!std::filesystem::exists("/dev/zero")) GTEST_SKIP() << "there is no /dev/zero";
  for (const char* name : {"zero.ply", "zero.vtp", "zero.r", "zero.obj"})
    ASSERT_EQ(mkfifo((folder / name).c_str(), 0600), 0);
  const std::string limit = "100M";
  for (const std::vector<std::string>& command : std::vector<std::vector<std::string>>{
           {"burn", "core.vtp", "--radii", "zero.r", "-o", "o.vtp", "--memory-limit", limit},
           {"convert", "core.vtp", "o.ma", "--radii", "zero.r", "--memory-limit", limit},
           {"burn", "zero.vtp", "-o", "o.vtp", "--memory-limit", limit},
           {"burn", "core.vtp", "--shape", "zero.ply", "-o", "o.vtp", "--memory-limit", limit},
           {"core", "zero.obj", "-o", "o.vtp", "--memory-limit", limit},
           {"info", "zero.ply", "--memory-limit", limit}}) {
    for (const std::string& word : command)  // a writer that ends with its reader
      if (word.starts_with("zero.")) {
        const std::string fifo = (folder / word).string();
        ASSERT_EQ(std::system(("cat /dev/zero > '" + fifo + "' 2>/dev/null &").c_str()), 0);
      }
    refuses(1, {"'zero.", "100 MB", "memory", "ends"}, command);
  }
  std::filesystem::create_symlink("/dev/zero", folder / "device.ply");
  refuses(3, {"'device.ply' is a device"}, {"info", "device.ply"});
}

}  // namespace program_axis_input_test
