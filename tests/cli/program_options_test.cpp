// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cstring>
#include <sstream>

#include "base/memory.h"
#include "program.h"

// What options may be, what sentences look like, and which outputs are refused before any work.

using namespace quench::testing_program;

namespace program_options_test {

struct Option {
  std::string name;  ///< "--output", "SHAPE"
  bool positional = false, value = false;
};

/// From the help text: a value follows the name of an option after one space.
std::vector<Option> options_in(const std::string& help) {
  std::vector<Option> list;
  std::istringstream lines(help);
  bool positionals = false;
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("  ")) positionals = line == "Positionals:";
    if (!line.starts_with("  ") || line.starts_with("   ")) continue;
    std::string name = line.substr(2, line.find(' ', 2) - 2);
    const std::size_t end = 2 + name.size();
    if (positionals) {
      list.push_back({name, true, true});
    } else if (name.starts_with('-') && name != "-h,--help") {
      const bool value = end + 1 < line.size() && line[end + 1] != ' ';
      if (const std::size_t comma = name.find(','); comma != std::string::npos) name = name.substr(comma + 1);
      list.push_back({name, false, value});
    }
  }
  return list;
}

class Options : public ProgramTest {
 protected:
  /// A command line of every command, without options; what it reads need not be there.
  static std::vector<std::vector<std::string>> command_lines() {
    return {{"run", "s.off", "-o", "out"},         {"sample", "box", "-o", "o.ply"},
            {"voxelize", "s.off", "-o", "o.nrrd"}, {"core", "s.off", "-o", "o.vtp"},
            {"burn", "a.vtp", "-o", "o.vtp"},      {"skeleton", "a.vtp", "-o", "o.vtp"},
            {"view", "a.vtp", "-o", "o.html"},     {"info", "a.vtp"},
            {"convert", "a.vtp", "o.ma"},          {"verify", "s.off", "a.vtp"},
            {"tree", "s.off", "-o", "out"},        {"batch", "s.off", "-o", "out"}};
  }
  /// Whether what a command writes is a folder.
  static bool makes_folder(const std::vector<std::string>& line) { return line.back() == "out"; }
  static std::vector<std::string> with(std::vector<std::string> words, const std::vector<std::string>& more) {
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
};

TEST_F(Options, EmptyValuesAreRefused) {
  std::size_t values = 0;
  for (const auto& line : command_lines()) {
    std::size_t positional = 0;
    for (const Option& option : options_in(works({line[0], "--help"}).out)) {
      if (option.positional) {
        std::vector<std::string> empty = line;
        empty.at(++positional).clear();
        const std::string name = option.name == "B" && line[0] == "convert" ? "--output" : option.name;  // the same
        refuses(2, {name + " is empty; give the name of a " + (name == "NAME" ? "sample" : "file")}, empty);
        continue;
      }
      const bool required = option.name == "--output" && line[0] != "view";
      const std::string text = !required            ? " has an empty value; give one or leave it out"
                               : makes_folder(line) ? " is empty; give the name of a folder"
                                                    : " is empty; give the name of a file";
      refuses(2, {option.name + text}, with(line, {option.name + "="}));
      if (!option.value) continue;
      ++values;
      // Those that are given already are only refused as given twice.
      refuses(2, {option.name + text}, required ? with({line[0], line[1]}, {"-o", ""}) : with(line, {option.name, ""}));
    }
    EXPECT_EQ(positional, line[0] == "convert" || line[0] == "verify" ? 2u : 1u) << line[0];
  }
  EXPECT_GT(values, 80u) << "the help text is read wrong";
}

TEST_F(Options, AnOptionIsNotTheValueOfAnother) {
  std::size_t values = 0;
  for (const auto& line : command_lines()) {
    for (const Option& option : options_in(works({line[0], "--help"}).out)) {
      if (option.positional || !option.value) continue;
      ++values;
      const std::string short_one = line[0] == "info" || line[0] == "verify" || line[0] == "convert" ? "-h" : "-o";
      for (const std::string& next : {option.name, std::string("--quiet"), short_one})
        refuses(2, {option.name + " needs a value ('" + next + "' is an option)"},
                with(line, {option.name, next, "1"}));
    }
  }
  EXPECT_GT(values, 80u);
  for (const char* next : {"--threads=1", "--quiet", "-h"})
    refuses(2, {std::string("--json needs a value ('") + next + "' is an option)"}, {"core", "s.off", "--json", next});
  refuses(2, {"--json needs a value ('--odd' begins as an option does)"}, {"core", "s.off", "--json", "--odd"});
  refuses(2, {"--json needs a value ('--' ends the options)"}, {"core", "s.off", "--json", "--", "o.vtp"});
  refuses(2, {"-o needs a value ('--quiet' is an option)"}, {"run", "s.off", "-o", "--quiet"});
  refuses(2, {"--nonsense", "no option"}, {"core", "s.off", "-o", "o.vtp", "--nonsense="});
  // What begins with a dash and is a value.
  folder.write("v.npy", npy_box(3, 4, 5, 1));
  EXPECT_TRUE(works({"core", "v.npy", "--threshold", "-1", "--output=--o.vtp", "--json", "-"}).out.starts_with("{"));
  EXPECT_TRUE(exists("--o.vtp"));
  works({"info", "--", "--o.vtp"});
}

TEST_F(Options, NumbersAreDecimalAndInRange) {
  const std::vector<std::string> integers{"--threads", "--label", "--min-component", "--subdivide",  "--smooth",
                                          "--samples", "--seed",  "--branches",      "--resolution", "--max-triangles"};
  const std::vector<std::string> reals{"--threshold", "--noise", "--fineness"};
  std::size_t found = 0;
  for (const auto& line : command_lines())
    for (const Option& option : options_in(works({line[0], "--help"}).out)) {
      const auto refuse = [&](const std::string& value) {
        const bool beyond = value == "1e400" && option.name == "--threshold";
        refuses(2, {option.name + " '" + value + "' is " + (beyond ? "beyond the range of numbers" : "not")},
                with(line, {option.name, value}));
      };
      const auto among = [&](const auto& list) {
        return std::find(list.begin(), list.end(), option.name) != list.end();
      };
      if (!among(integers) && !among(reals)) continue;
      ++found;
      for (const char* value : {"0x10", "abc", "+3", " 3", "1e400", "nan", "inf"}) refuse(value);
      if (option.name != "--threshold") refuse("1,5");  // there it is two thresholds
      if (!among(integers)) continue;
      for (const char* value : {"1.5", "1e3", "18446744073709551616", "-9223372036854775809"}) refuse(value);
    }
  EXPECT_GT(found, 40u);
  refuses(2, {"--label", "from -9223372036854775808 to 9223372036854775807"},
          {"core", "s.off", "-o", "o.vtp", "--label", "9223372036854775808"});
  refuses(2, {"--threshold '1e-400' is beyond the range of numbers (up to 1.8e308, down to 5e-324)"},
          {"core", "s.off", "-o", "o.vtp", "--threshold", "1e-400"});
  refuses(2, {"--threshold '1e309x' is not a number"}, {"core", "s.off", "-o", "o.vtp", "--threshold", "1e309x"});
  refuses(2, {"--threads '257' is not a whole number from 0 to 256"},
          {"core", "s.off", "-o", "o.vtp", "--threads", "257"});
  refuses(2, {"--seed", "from 0 to 18446744073709551615"}, {"sample", "root", "-o", "o.ply", "--seed", "-1"});
  refuses(2, {"--smooth '-3' is not a whole number from 0 to 10000"}, {"run", "s.off", "-o", "out", "--smooth", "-3"});
  refuses(2, {"--fill 'odd' is not one of nonzero, evenodd"}, {"core", "s.off", "-o", "o.vtp", "--fill", "odd"});
  refuses(2, {"--topology 'mine' is not one of mesh, voxels"}, {"core", "s.off", "-o", "o.vtp", "--topology", "mine"});
}

// Of a mesh: what was given, and what a result of a volume says.
TEST_F(Options, OptionsForVolumesThatAMeshIgnores) {
  folder.write("cube.off", cube_off());
  folder.write("v.npy", npy(1, 1, 3, "\1\2\3"));
  const auto notes = [&](const std::vector<std::string>& line) {
    const std::string err = quench(line).err;
    std::string list;
    for (std::size_t at = 0; (at = err.find("note: --", at)) != std::string::npos; ++at)
      list += err.substr(at, err.find('\n', at) - at) + "|";
    return list;
  };
  const std::vector<std::string> voxelize{"voxelize", "cube.off", "--resolution", "4", "-o", "o.nrrd", "--overwrite"};
  EXPECT_EQ(notes(voxelize), "");
  EXPECT_EQ(notes(with(voxelize, {"--invert"})), "note: --invert is for volumes and is ignored for a mesh|");
  EXPECT_EQ(notes(with(voxelize, {"--label", "1", "--spacing", "2"})),
            "note: --label, --spacing are for volumes and are ignored for a mesh|");
  works({"core", "v.npy", "--threshold", "2", "-o", "c.vtp"});
  const std::vector<std::string> verify{"verify", "cube.off", "c.vtp", "--resolution", "4"};
  EXPECT_EQ(notes(verify), "note: --threshold (recorded in 'c.vtp') is for volumes and is ignored for a mesh|");
  EXPECT_EQ(notes(with(verify, {"--threshold", "7"})), "note: --threshold is for volumes and is ignored for a mesh|");
}

// Four blobs, which fall apart at this resolution.
TEST_F(Options, TheTopologyOfTheMeshIsReportedAndTakenFromTheResult) {
  works({"sample", "four-blobs", "--fineness", "0.2", "-o", "b.ply"});
  const std::vector<std::string> core{"core", "b.ply", "--resolution", "24", "-o", "c.vtp", "--overwrite"};
  const auto said = quench(with(core, {"--json", "r.json"})).err;
  EXPECT_NE(said.find("for the topology of the mesh: 4 components, 0 cavities and 0 tunnels before, 1 component"),
            std::string::npos)
      << said;
  const std::string report = bytes_of(folder / "r.json");
  for (const char* text : {"\"rule\": \"mesh\"", "\"betti_before\"", "\"added\"", "\"solid_betti\""})
    EXPECT_NE(report.find(text), std::string::npos) << text;
  const std::vector<std::string> verify{"verify", "b.ply", "c.vtp"};
  EXPECT_NE(works(verify).out.find("ok   Betti numbers of the mesh: 1, 0, 0"), std::string::npos);
  works(with(core, {"--topology", "voxels"}));
  EXPECT_NE(works(verify).out.find("-    Betti numbers of the mesh: not checked"), std::string::npos);
  EXPECT_EQ(quench(with(verify, {"--topology", "mesh"})).code, 4);  // of another shape
}

template <class T>
std::string samples(std::initializer_list<T> values) {
  std::string text(values.size() * sizeof(T), '\0');
  std::memcpy(text.data(), values.begin(), text.size());
  return text;
}

TEST_F(Options, LargeWholeThresholdsAreExact) {
  constexpr std::int64_t odd = (std::int64_t{1} << 53) + 1;  // no double
  folder.write("i.npy", npy(1, 1, 3, samples<std::int64_t>({odd - 1, odd, -odd}), "<i8"));
  folder.write("u.npy", npy(1, 1, 2, samples<std::uint64_t>({~std::uint64_t{0}, ~std::uint64_t{0} - 1}), "<u8"));
  folder.write("o.npy", npy(1, 1, 2, "\x08\x0a"));
  const auto voxels = [&](const char* file, const char* option, const std::string& value) {
    works({"voxelize", file, option, value, "-o", "o.nrrd", "--json", "o.json", "--overwrite"});
    const std::string report = bytes("o.json");
    const std::size_t at = report.find("\"voxels\": ");
    return std::stoi(report.substr(at + 10));
  };
  EXPECT_EQ(voxels("i.npy", "--threshold", std::to_string(odd)), 1);
  EXPECT_EQ(voxels("i.npy", "--threshold", std::to_string(odd - 1)), 2);
  EXPECT_EQ(voxels("i.npy", "--threshold", std::to_string(-odd)), 3);
  EXPECT_EQ(voxels("i.npy", "--threshold", std::to_string(1 - odd)), 2);
  for (const char* above : {"9007199254740992.5", "9007199254740992.000000000000000000001", "9.0071992547409921e15",
                            "900719925474099300e-2", "0.00009007199254740993E+20"})
    EXPECT_EQ(voxels("i.npy", "--threshold", above), 1) << above;
  for (const char* at : {"9007199254740992.0", "9.007199254740992e15", "9007199254740991.5", "900719925474099100.1e-2"})
    EXPECT_EQ(voxels("i.npy", "--threshold", at), 2) << at;
  for (const char* below : {"-9007199254740993.5", "-9007199254740993.0", "-9.1e15"})
    EXPECT_EQ(voxels("i.npy", "--threshold", below), 3) << below;
  EXPECT_EQ(voxels("i.npy", "--threshold", "-9007199254740992.5"), 2);
  EXPECT_EQ(voxels("u.npy", "--threshold", "18446744073709551614.5"), 1);
  EXPECT_EQ(voxels("u.npy", "--threshold", "1.8446744073709551614e19"), 2);
  refuses(3, {"'u.npy'"}, {"voxelize", "u.npy", "--threshold", "18446744073709551615.5", "-o", "no.nrrd"});
  EXPECT_EQ(voxels("u.npy", "--threshold", "18446744073709551615"), 1);
  EXPECT_EQ(voxels("u.npy", "--threshold", "18446744073709551614"), 2);
  EXPECT_EQ(voxels("o.npy", "--label", "010"), 1);  // ten
  refuses(3, {"'o.npy'", "value 16"}, {"voxelize", "o.npy", "--label", "0016", "-o", "no.nrrd"});
  works({"core", "i.npy", "--threshold", std::to_string(odd), "-o", "i.vtp"});
  works({"verify", "i.npy", "i.vtp"});  // the threshold in the file is exact, too
}

void expect_printable(const Outcome& outcome) {
  for (const std::string* text : {&outcome.out, &outcome.err})
    for (std::size_t i = 0; i < text->size(); ++i) {
      const auto c = static_cast<unsigned char>((*text)[i]);
      EXPECT_TRUE(c == '\n' || (c >= ' ' && c < 0x7F)) << "byte " << int{c} << " in " << testing::PrintToString(*text);
    }
}

// Newline, escape, delete, a C1 control in UTF-8, half a character, a change of the writing direction.
TEST_F(Options, SentencesArePrintable) {
  const std::string odd = "a\nb\x1b[31m\x7f\xc2\x9b\xe2\x82\xe2\x80\xae";
  const std::string shown = "a\\nb\\x1b[31m\\x7f\\u009b\\xe2\\x82\\u202e";
  folder.write(odd + ".npy", npy_box(3, 4, 5, 1));
  folder.write(odd + ".ply",
               "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty "
               "float z\nproperty float q\x1b\nend_header\n0 0 0 1\n");
  const auto said = [&](const Outcome& outcome, int code) {
    EXPECT_EQ(outcome.code, code) << outcome.err;
    expect_printable(outcome);
    EXPECT_NE((outcome.out + outcome.err).find(shown), std::string::npos) << outcome.out << outcome.err;
  };
  said(quench({"core", odd + ".npy", "-o", odd + ".vtp", "--verbose"}), 0);
  said(quench({"burn", odd + ".vtp", "-o", odd + "b.vtp"}), 0);
  said(quench({"skeleton", odd + "b.vtp", "-o", odd + "c.vtp", "--swc", odd + ".swc"}), 0);
  said(quench({"verify", odd + ".npy", odd + ".vtp"}), 0);
  said(quench({"run", odd + ".npy", "-o", odd}), 0);
  said(quench({"convert", odd + ".vtp", odd + ".ma"}), 0);
  for (const char* extension : {".npy", ".ply", ".vtp"}) said(quench({"info", odd + extension}), 0);
  said(quench({"info", "no" + odd}), 1);
  said(quench({odd}), 2);
  said(quench({"core", odd + ".npy", odd, "-o", "o.vtp"}), 2);
  said(quench({"core", odd + ".npy", "-o", "no" + odd + "/o.vtp"}), 1);
  for (const char* option : {"--fill", "--label", "--lambda", "--spacing", "--memory-limit", "--lambda-rule"})
    said(quench({"core", odd + ".npy", "-o", "o.vtp", option, odd}), 2);
  std::filesystem::rename(folder / (odd + ".npy"), folder / (odd + ".docx"));
  said(quench({"info", odd + ".docx"}), 3);
  expect_printable(quench({"info", "a.vtp\n",
                           "\x1b"
                           "x"}));
}

TEST_F(Options, OutputsAreCheckedBeforeTheWork) {
  for (const char* name : {"s.off", "a.vtp"}) folder.write(name, "not even read");
  folder.write("file", "");
  std::filesystem::create_directories(folder / "out/core.vtp");
  const std::string long_name(300, 'x');
  for (auto line : command_lines()) {
    if (line[0] == "info") continue;
    const bool folder_made = makes_folder(line);
    const std::size_t at = line[0] == "convert" ? 2 : 3;
    if (line[0] == "verify") line = with(line, {"--json", "o.json"});
    std::string& output = line[line[0] == "verify" ? 4 : at];
    const std::string extension = std::filesystem::path(output).extension(), name = output;
    if (!folder_made) {
      refuses(1, {"'no'", "does not exist", "create it"}, (output = "no/" + name, line));
      refuses(1, {"'file'", "not a folder"}, (output = "file/" + name, line));
    }
    refuses(2, {"too long"}, (output = long_name + extension, line));
    output = name;
    const std::string help = works({line[0], "--help"}).out;
    for (const Option& option : options_in(help)) {
      if (!option.value || (option.name != "--json" && option.name != "--swc" && option.name != "--graphml" &&
                            option.name != "--csv" && option.name != "--png"))
        continue;
      if (line[0] == "verify" && option.name == "--json") continue;
      std::vector<std::string> more = with(line, {option.name, ""});
      if (folder_made) more[3] = "new";
      refuses(1, {"'no'", "does not exist"}, (more.back() = "no/x.png", more));
      refuses(2, {"too long"}, (more.back() = long_name + ".png", more));
    }
  }
  refuses(2, {"'out/core.vtp'", "folder"}, {"run", "s.off", "-o", "out"});
  refuses(2, {"too long"}, {"run", "s.off", "-o", "new/" + long_name + "/deep"});
  for (const char* command : {"core", "burn", "skeleton"})
    refuses(2, {"'o.xyz'", ".vtp"}, {command, std::string(command) == "core" ? "s.off" : "a.vtp", "-o", "o.xyz"});
}

TEST_F(Options, RunReplacesNothingUnlessAsked) {
  folder.write("cube.off", cube_off());
  const std::vector<std::string> run{"run", "cube.off", "--resolution", "8", "-o", "out", "--quiet"};
  works(run);
  refuses(2, {"'out/core.vtp' exists", "--overwrite"}, run);
  const auto made = files();
  for (const auto& [name, content] : made) {
    if (!name.starts_with("out/")) continue;
    std::filesystem::remove_all(folder / "out");
    std::filesystem::create_directory(folder / "out");
    folder.write(name, "mine");
    refuses(2, {"'" + name + "' exists", "--overwrite"}, run);
  }
  works(with(run, {"--overwrite"}));
  EXPECT_EQ(files().size(), made.size());
  refuses(2, {"--json", "same file", "core.vtp"}, with(run, {"--overwrite", "--json", "out/core.vtp"}));
}

TEST_F(Options, TheShareThatCleaningDrops) {
  std::string row(20, '\1');
  row[12] = '\0';  // 12 voxels and 7
  folder.write("v.npy", npy(1, 1, 20, row));
  const Outcome much = works({"core", "v.npy", "--largest-component", "-o", "a.vtp", "--json", "a.json"});
  EXPECT_NE(
      much.err.find("cleaned: 1 component of 7 voxels dropped (37% of the shape), 0 cavities of 0 voxels filled\n"),
      std::string::npos)
      << much.err;
  EXPECT_NE(much.err.find("warning: dropping components took 37% of the shape"), std::string::npos) << much.err;
  EXPECT_NE(bytes("a.json").find("\"voxels_before\": 19"), std::string::npos);
  row.assign(200, '\1');
  row[198] = '\0';
  folder.write("v.npy", npy(1, 1, 200, row));
  const Outcome speck = works({"core", "v.npy", "--largest-component", "-o", "b.vtp"});
  EXPECT_NE(speck.err.find("1 component of 1 voxel dropped (0.5% of the shape)"), std::string::npos) << speck.err;
  EXPECT_EQ(speck.err.find("warning"), std::string::npos) << speck.err;
}

TEST_F(Options, SentencesThatHelp) {
  const std::string header("\0\0\0\rIHDR\0\0\0\1\0\0\0\1\b\0\0\0\0", 21), checksum(4, '\0');
  folder.write("bad.png", "\x89PNG\r\n\x1a\n" + header + checksum + std::string(12, '\0'));
  refuses(3, {"'bad.png'", "checksum of the chunk at byte 8 is wrong", "copy it again"}, {"info", "bad.png"});
  folder.write("short.off", "OFF\n4294967299 1 0\n0 0 0\n");
  refuses(3, {"4294967299 vertices and 1 face are declared"}, {"info", "short.off"});
  folder.write("cube.off", cube_off());
  refuses(2, {"--lambda '-1' is negative"}, {"core", "cube.off", "-o", "a.vtp", "--lambda", "-1"});
  folder.write("a.docx", "text");
  refuses(3, {"'a.docx' has the unknown file type '.docx'", ".nrrd"}, {"info", "a.docx"});
  folder.write("plain", "text");
  for (const char* half : {"pair.hdr", "pair.IMG"}) {
    folder.write(half, "text");
    refuses(3, {std::string("'") + half + "' has the unknown file type", "pair .hdr/.img", ".nii"}, {"info", half});
  }
  folder.write("type.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty flaot x\nend_header\n0\n");
  refuses(3, {"'type.ply', line 4: 'flaot' is not a type of PLY properties"}, {"info", "type.ply"});
  folder.write("short.vol", "Version: 2\nX: 4\nY: 4\nZ: 4\nVoxel-Size: 1\n.\nabc");
  refuses(3, {"'short.vol'", "4 x 4 x 4 voxels of 1 byte but"}, {"info", "short.vol"});
  refuses(3, {"'plain' has no file type in its name"}, {"core", "plain", "-o", "a.vtp"});
}

TEST_F(Options, AmountsOfMemory) {
  EXPECT_EQ(quench::base::bytes_text(0), "0 bytes");
  EXPECT_EQ(quench::base::bytes_text(1), "1 byte");
  EXPECT_EQ(quench::base::bytes_text(1500), "1.5 KB");
  EXPECT_EQ(quench::base::bytes_text(52 << 10), "52 KB");
  EXPECT_EQ(quench::base::bytes_text(3 << 19), "1.5 MB");
  EXPECT_EQ(quench::base::bytes_text(std::int64_t{5} << 30), "5.0 GB");
  folder.write("v.npy", npy_box(3, 4, 5, 1));
  refuses(1, {"use a smaller or coarser volume, a part of it, or a larger --memory-limit", "1.0 KB"},
          {"core", "v.npy", "-o", "a.vtp", "--memory-limit", "1K"});
}

}  // namespace program_options_test
