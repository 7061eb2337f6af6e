// SPDX-License-Identifier: Apache-2.0
// Traits of published neurons against swc_statistics.py, which takes them from the samples by NeuroM's definitions.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <vector>

#include "data.h"
#include "quench/tree.h"

namespace quench {
namespace neuron_statistics_test {

struct Section {
  std::array<double, 3> end;
  double length = 0, link = 0;
  int strahler = 0, order = 0, tips = 0;
  double radius = 0;
  auto operator<=>(const Section&) const = default;
};

struct Statistics {
  std::map<std::string, double> sample;
  std::vector<Section> sections;
};

Statistics published(const std::filesystem::path& file) {
  const auto script = std::filesystem::path(__FILE__).parent_path() / "../io/tree/swc_statistics.py";
  const std::string command = "/usr/bin/python3 -B '" + script.string() + "' '" + file.string() + "'";
  Statistics found;
  std::FILE* pipe = popen(command.c_str(), "r");
  std::string text;
  for (std::array<char, 4096> block; const std::size_t got = std::fread(block.data(), 1, block.size(), pipe);)
    text.append(block.data(), got);
  EXPECT_EQ(pclose(pipe), 0);
  std::istringstream in(text);
  for (std::string kind, name; in >> kind;) {
    if (kind == "sample") {
      in >> name;
      in >> found.sample[name];
      continue;
    }
    Section s;
    in >> s.end[0] >> s.end[1] >> s.end[2] >> s.length >> s.link >> s.strahler >> s.order >> s.tips >> s.radius;
    found.sections.push_back(s);
  }
  return found;
}

double number(const Table& table, const char* column, std::size_t row) {
  const Table::Column* c = table.find(column);
  EXPECT_NE(c, nullptr) << column;
  if (!c) return 0;
  if (const auto* whole = std::get_if<std::vector<std::int64_t>>(&c->values))
    return static_cast<double>(whole->at(row));
  return std::get<std::vector<double>>(c->values).at(row);
}

class NeuronStatistics : public testing::TestWithParam<const char*> {};

TEST_P(NeuronStatistics, AreThoseOfTheSamples) {
  if (std::system("/usr/bin/python3 -c '' 2>/dev/null") != 0) GTEST_SKIP() << "no Python 3";
  const std::filesystem::path file = data_file(GetParam());
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "no real data beside the checkout: " << GetParam();
  Statistics wanted = published(file);
  const Tree tree = with_hierarchy(io::read_tree(file), {});
  const Traits traits = traits_of(tree);
  for (const char* name : {"branches", "forks", "tips", "strahler", "max_order"})
    EXPECT_EQ(number(traits.sample, name, 0), wanted.sample.at(name)) << name;
  for (const char* name : {"total_length", "soma_radius", "partition_asymmetry"})
    EXPECT_NEAR(number(traits.sample, name, 0), wanted.sample.at(name), 1e-7 * wanted.sample.at(name)) << name;
  for (const char* name : {"local_angle", "remote_angle"}) {  // NeuroM takes forks of two sections only
    double sum = 0, count = 0;
    for (std::size_t b = 0; b < traits.branches.rows; ++b) {
      if (std::isnan(number(traits.branches, "partition_asymmetry", b))) continue;
      sum += number(traits.branches, name, b);
      ++count;
    }
    EXPECT_NEAR(sum / count, wanted.sample.at(name), 1e-7 * wanted.sample.at(name)) << name;
  }
  ASSERT_EQ(traits.branches.rows, wanted.sections.size());
  std::vector<Section> made;
  for (std::size_t b = 0; b < traits.branches.rows; ++b) {
    Section s;
    const Tree::Branch& branch = tree.branches[b];
    s.end = {branch.points.back()[0], branch.points.back()[1], branch.points.back()[2]};
    s.length = number(traits.branches, "length", b);
    s.strahler = static_cast<int>(number(traits.branches, "strahler", b));
    s.order = static_cast<int>(number(traits.branches, "order", b));
    s.tips = static_cast<int>(number(traits.branches, "tips", b));
    s.radius = number(traits.branches, "end_radius", b);
    made.push_back(s);
  }
  std::ranges::sort(made);
  std::ranges::sort(wanted.sections);
  for (std::size_t i = 0; i < made.size(); ++i) {
    EXPECT_EQ(made[i].end, wanted.sections[i].end);
    EXPECT_NEAR(made[i].length, wanted.sections[i].length, 1e-9 * wanted.sections[i].length);
    EXPECT_EQ(made[i].strahler, wanted.sections[i].strahler);
    EXPECT_EQ(made[i].order, wanted.sections[i].order);
    EXPECT_EQ(made[i].tips, wanted.sections[i].tips);
    EXPECT_EQ(made[i].radius, wanted.sections[i].radius);
  }
}

INSTANTIATE_TEST_SUITE_P(Published, NeuronStatistics,
                         testing::Values("trees/neurom_test_morph.swc", "trees/ds_1_cell_390.swc"),
                         [](const auto& which) { return which.index == 0 ? "NeuroM" : "MorphoPy"; });

}  // namespace neuron_statistics_test
}  // namespace quench
