// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <span>
#include <string>
#include <utility>

#include "base/csr.h"
#include "io/common/text_out.h"
#include "io/tree/tree_samples.h"
#include "quench/error.h"
#include "quench/io.h"

/// A vertex per line, in the column of how many axes bear each other there. '/' begins what a vertex consists of, '<'
/// continues, '+' branches off; '^' takes the vertex above in the same column.
namespace quench::io {
namespace {

constexpr std::array<std::pair<const char*, const char*>, 10> kFeatures{{{"XX", "REAL"},
                                                                         {"YY", "REAL"},
                                                                         {"ZZ", "REAL"},
                                                                         {"Radius", "REAL"},
                                                                         {"Level", "INT"},
                                                                         {"Strahler", "INT"},
                                                                         {"Order", "INT"},
                                                                         {"Type", "INT"},
                                                                         {"Bridged", "INT"},
                                                                         {"Name", "ALPHA"}}};

/// What readers do not take for the end of a field.
std::string name_in_mtg(const std::string& label) {
  std::string name;
  for (const char c : label) name += std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '.' ? c : '_';
  return name;
}

class MtgWriter {
 public:
  MtgWriter(TextOut& text, const Tree& tree) : text_(text), tree_(tree), column_(tree.axes.size(), 0) {
    find_bearers();
  }

  void write() {
    text_.print(
        "CODE:\tFORM-A\n\nCLASSES:\nSYMBOL\tSCALE\tDECOMPOSITION\tINDEXATION\tDEFINITION\n$\t0\tFREE\tFREE\tIMPLICIT\n"
        "P\t1\tFREE\tFREE\tEXPLICIT\nA\t2\tFREE\tFREE\tEXPLICIT\nS\t3\tNONE\tFREE\tEXPLICIT\n\n"
        "DESCRIPTION:\nLEFT\tRIGHT\tRELTYPE\tMAX\nA\tA\t+\t?\nS\tS\t<\t1\nS\tS\t+\t?\n\nFEATURES:\nNAME\tTYPE\n");
    for (const auto& [name, type] : kFeatures) text_.print("{}\t{}\n", name, type);
    text_.print("\nMTG:\nENTITY-CODE{}", std::string(columns_, '\t'));
    for (std::size_t f = 0; f < kFeatures.size(); ++f) text_.print("{}{}", f == 0 ? "" : "\t", kFeatures[f].first);
    text_.print("\n");
    const auto of_plant = base::Csr<std::uint32_t>::group(tree_.plants.size(), [&](const auto& emit) {
      for (std::uint32_t axis = 0; axis < tree_.axes.size(); ++axis)
        if (bearer_[axis].first == kNone) emit(tree_.axes[axis].plant, axis);
    });
    for (std::uint32_t p = 0; p < tree_.plants.size(); ++p) {
      const Tree::Plant& plant = tree_.plants[p];
      line(0, fmt::format("/P{}", p + 1),
           {fmt::format("{}", plant.root[0]), fmt::format("{}", plant.root[1]), fmt::format("{}", plant.root[2]),
            plant.soma ? fmt::format("{}", *plant.soma) : "", "", "", "", "", "", name_in_mtg(plant.label)});
      bool first = true;
      for (const std::uint32_t a : of_plant[p]) {
        write_with_laterals(a, first);
        first = false;
      }
    }
    text_.flush();
  }

 private:
  using Fields = std::array<std::string, kFeatures.size()>;

  /// The axis and the number of the point on it that each axis grows from; kNone: a root node that is its own.
  void find_bearers() {
    std::vector<std::uint32_t> end(tree_.branches.size(), 0);  // of branches: the number of the point on their axis
    for (const Tree::Axis& axis : tree_.axes) {
      std::uint32_t points = 0;
      for (const std::uint32_t b : axis.branches)
        end[b] = points += static_cast<std::uint32_t>(tree_.branches[b].points.size() - 1);
    }
    bearer_.assign(tree_.axes.size(), {kNone, 0});
    for (std::size_t a = 0; a < tree_.axes.size(); ++a) {
      const Tree::Axis& axis = tree_.axes[a];
      const std::uint32_t base = tree_.branches[axis.branches.front()].parent;
      if (base != kNone)
        bearer_[a] = {tree_.branches[base].axis, end[base]};
      else if (axis.parent != kNone)  // from the root node, as its parent may do, too
        bearer_[a] =
            bearer_[axis.parent].first == kNone ? std::pair{axis.parent, std::uint32_t{0}} : bearer_[axis.parent];
    }
    laterals_ = base::Csr<std::uint32_t>::group(tree_.axes.size(), [&](const auto& emit) {
      for (std::uint32_t a = 0; a < tree_.axes.size(); ++a)
        if (bearer_[a].first != kNone) emit(bearer_[a].first, a);
    });
    for (std::size_t a = 0; a < tree_.axes.size(); ++a)
      std::ranges::stable_sort(laterals_[a], {}, [&](std::uint32_t child) { return bearer_[child].second; });
    find_columns();
  }

  /// From those that none bears: what bears an axis may come after it.
  void find_columns() {
    std::vector<std::uint32_t> found;
    for (std::uint32_t a = 0; a < tree_.axes.size(); ++a)
      if (bearer_[a].first == kNone) found.push_back(a);
    for (std::size_t next = 0; next < found.size(); ++next) {
      const std::uint32_t axis = found[next];
      columns_ = std::max(columns_, column_[axis] + 1);
      for (const std::uint32_t lateral : std::as_const(laterals_)[axis]) {
        column_[lateral] = column_[axis] + 1;
        found.push_back(lateral);
      }
    }
  }

  /// An axis that is being written.
  struct Visit {
    std::uint32_t axis;
    std::size_t branch = 0, point = 1, lateral = 0;
    std::uint32_t number = 0;  ///< of the point on the axis
    std::uint32_t vertices = 0;
  };

  void write_with_laterals(std::uint32_t main, bool first_of_plant) {
    std::vector<Visit> open;
    const auto begin = [&](std::uint32_t axis, const std::string& how) {
      const Tree::Axis& a = tree_.axes[axis];
      line(column_[axis], fmt::format("{}A{}", how, axis + 1),
           {"", "", "", "", fmt::format("{}", a.level), "", "", "", "", name_in_mtg(a.label)});
      open.push_back({axis});
    };
    begin(main, first_of_plant ? "^/" : "/");
    vertex(open.back(), tree_.branches[tree_.axes[main].branches.front()], 0);
    while (!open.empty()) {
      Visit& visit = open.back();
      const std::span<const std::uint32_t> laterals = std::as_const(laterals_)[visit.axis];
      if (visit.lateral < laterals.size() && bearer_[laterals[visit.lateral]].second == visit.number) {
        begin(laterals[visit.lateral++], "+");
        continue;
      }
      const std::vector<std::uint32_t>& branches = tree_.axes[visit.axis].branches;
      if (visit.branch == branches.size()) {
        open.pop_back();
        continue;
      }
      const Tree::Branch& branch = tree_.branches[branches[visit.branch]];
      if (branch.points.size() == 1) {  // a root node without branches
        ++visit.branch;
        continue;
      }
      ++visit.number;
      vertex(visit, branch, visit.point);
      if (++visit.point == branch.points.size()) {
        ++visit.branch;
        visit.point = 1;
      }
    }
  }

  void vertex(Visit& visit, const Tree::Branch& branch, std::size_t i) {
    const Vec3& p = branch.points[i];
    const bool gap = i > 0 && !branch.bridged.empty() && branch.bridged[i - 1] != 0;
    const char* how = visit.vertices == 0 ? "^/" : "^<";
    line(column_[visit.axis], fmt::format("{}S{}", how, ++visit.vertices),
         {fmt::format("{}", p[0]), fmt::format("{}", p[1]), fmt::format("{}", p[2]),
          fmt::format("{}", branch.radius[i]), "", fmt::format("{}", branch.strahler), fmt::format("{}", branch.order),
          fmt::format("{}", branch.type), gap ? "1" : "", ""});
  }

  void line(std::size_t column, const std::string& vertex, const Fields& fields) {
    text_.print("{}{}{}", std::string(column, '\t'), vertex, std::string(columns_ - column, '\t'));
    for (std::size_t f = 0; f < fields.size(); ++f) text_.print("{}{}", f == 0 ? "" : "\t", fields[f]);
    text_.print("\n");
  }

  TextOut& text_;
  const Tree& tree_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> bearer_;
  base::Csr<std::uint32_t> laterals_;  ///< per axis, by the point they grow from
  std::vector<std::size_t> column_;
  std::size_t columns_ = 1;
};

}  // namespace

void write_mtg(const std::filesystem::path& file, const Tree& tree) {
  require_axes(tree, "MTG");
  write_atomically(file, [&](std::ostream& out) {
    TextOut text(out);
    MtgWriter(text, tree).write();
  });
}

}  // namespace quench::io
