// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "io/common/text_out.h"
#include "quench/error.h"
#include "quench/io.h"
#include "quench/tree.h"

namespace quench::io {
namespace {

constexpr int kSwcSoma = 1;

class TreeSamplesOut {
 public:
  TreeSamplesOut(TextOut& text, const Tree& tree, int type)
      : text_(text), tree_(tree), type_(type), roots_(tree.plants.size(), 0), ends_(tree.branches.size(), 0) {}

  void write() {
    for (std::size_t b = 0; b < tree_.branches.size(); ++b) {
      const Tree::Branch& branch = tree_.branches[b];
      const int type = type_of(branch);
      std::uint64_t parent = branch.parent == kNone ? root_of(branch, type) : ends_[branch.parent];
      for (std::size_t i = 1; i < branch.points.size(); ++i)
        parent = sample(type, branch.points[i], branch.radius[i], static_cast<std::int64_t>(parent));
      ends_[b] = parent;
    }
  }

 private:
  /// A sample of a soma within a branch is one that programs refuse.
  int type_of(const Tree::Branch& branch) const {
    return branch.type <= 0 || branch.type == kSwcSoma ? type_ : branch.type;
  }
  std::uint64_t root_of(const Tree::Branch& branch, int type) {
    std::uint64_t& id = roots_[branch.plant];
    const Tree::Plant& plant = tree_.plants[branch.plant];
    if (id == 0) id = sample(plant.soma ? kSwcSoma : type, plant.root, plant.soma.value_or(branch.radius.front()), -1);
    return id;
  }
  std::uint64_t sample(int type, const Vec3& p, double radius, std::int64_t parent) {
    text_.print("{} {} {} {} {} {} {}\n", ++count_, type, p[0], p[1], p[2], radius, parent);
    return count_;
  }

  TextOut& text_;
  const Tree& tree_;
  int type_;
  std::vector<std::uint64_t> roots_;  ///< ids per plant; 0: not written yet
  std::vector<std::uint64_t> ends_;   ///< ids of the last samples of branches
  std::uint64_t count_ = 0;
};

void say(TextOut& text, const char* what, std::string value) {
  std::replace_if(
      value.begin(), value.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
  if (!value.empty()) text.print("# {}: {}\n", what, value);
}

}  // namespace

void write_swc(const std::filesystem::path& file, const Tree& tree, int type) {
  if (type < 1 || type > 255)
    throw Error(ErrorCode::usage, fmt::format("the type of the samples of a tree is from 1 to 255, not {}", type));
  write_atomically(file, [&](std::ostream& out) {
    TextOut text(out);
    text.print("# Quench {}: trees {}\n", QUENCH_VERSION, tree.plants.size());
    say(text, "units", tree.coordinates.units);
    say(text, "SPACE", tree.coordinates.space);
    text.print("# id type x y z radius parent\n");
    TreeSamplesOut(text, tree, type).write();
    text.flush();
  });
}

}  // namespace quench::io
