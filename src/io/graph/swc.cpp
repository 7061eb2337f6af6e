// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <limits>
#include <span>
#include <string_view>
#include <tuple>
#include <utility>

#include "base/csr.h"
#include "base/union_find.h"
#include "io/common/text_out.h"
#include "quench/error.h"
#include "quench/graph.h"
#include "quench/io.h"

/// A curve graph as trees of samples. What SWC cannot express (loops, sheets) is in the header, before all rows: some
/// readers accept comments only there.
namespace quench::io {
namespace {

// Sample types of SWC and SWC+. Files contain the first name of a number.
constexpr std::array<std::pair<std::string_view, int>, 9> kTypeNames{{{"undefined", 0},
                                                                      {"soma", 1},
                                                                      {"axon", 2},
                                                                      {"dendrite", kSwcDendrite},
                                                                      {"basal-dendrite", kSwcDendrite},
                                                                      {"apical-dendrite", 4},
                                                                      {"custom", 5},
                                                                      {"neurite", 6},
                                                                      {"glia", 7}}};

std::string type_text(int type) {
  for (const auto& [name, number] : kTypeNames)
    if (number == type) return fmt::format("{} ({})", type, name);
  return fmt::format("{}", type);
}

struct Row {
  Vec3 point;
  double radius;
  std::uint64_t parent;  ///< id, or 0
};

/// A way out of a node: a branch, from its first or last point, or a straight link to another node of the same sheet.
struct Way {
  std::uint32_t node = 0, branch = kNone;
  bool backwards = false;
  std::uint32_t linked = kNone;  ///< the other node of a link
};

class Trees {
 public:
  Trees(const CurveGraph& graph, const SwcOptions& options)
      : graph_(graph), sets_(graph.nodes.size()), cut_(graph.branches.size(), kNone), cut_ids_(graph.branches.size()) {
    link_sheets();
    cut_loops();
    list_ways();
    const std::vector<std::uint32_t> roots = choose_roots(options);
    for (std::uint32_t root : roots) {
      root_ids_.push_back(rows_.size() + 1);
      grow(root);
    }
    report_.roots = roots;
    report_.trees = static_cast<std::uint32_t>(roots.size());
    report_.samples = rows_.size();
    report_.sheet_links = links_.size();
    for (std::uint32_t b = 0; b < cut_.size(); ++b)
      if (cut_[b] != kNone)
        report_.cuts.push_back({b, graph_.branches[b].points[cut_[b]], graph_.branches[b].points[cut_[b] + 1]});
  }

  SwcReport write(std::ostream& out, const SwcOptions& options) const {
    TextOut text(out);
    text.print("# Quench {}: trees {}, samples {}, loops cut {}\n", QUENCH_VERSION, report_.trees, report_.samples,
               report_.cuts.size());
    const auto say = [&](const char* what, std::string value) {
      std::replace_if(
          value.begin(), value.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
      if (!value.empty()) text.print("# {}: {}\n", what, value);
    };
    say("units", options.coordinates.units);
    say("SPACE", options.coordinates.space);
    for (std::size_t t = 0; t < report_.roots.size(); ++t)
      text.print("# component {}: root is sample {}\n", graph_.nodes[report_.roots[t]].component, root_ids_[t]);
    for (const SwcReport::Cut& cut : report_.cuts) {
      const Vec3 middle = (cut.from + cut.to) / 2;
      text.print("# loop cut at {} {} {}: branch {}, no segment between samples {} and {}\n", middle[0], middle[1],
                 middle[2], cut.branch, cut_ids_[cut.branch][0], cut_ids_[cut.branch][1]);
    }
    for (std::uint64_t id : links_)
      text.print("# sheet link: from sample {} to its parent {} is a straight line across a sheet, not a curve\n", id,
                 rows_[id - 1].parent);
    for (std::uint32_t component : graph_.sheet_only)
      text.print("# component {} is a sheet without curves and has no tree here\n", component);
    text.print("# type of every sample: {}; it is a label, not something that was found out\n",
               type_text(options.type));
    text.print("# id type x y z radius parent\n");
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const Row& row = rows_[i];
      text.print("{} {} {} {} {} {} ", i + 1, options.type, row.point[0], row.point[1], row.point[2], row.radius);
      if (row.parent == 0) {
        text.print("-1\n");
      } else {
        text.print("{}\n", row.parent);
      }
    }
    text.flush();
    return report_;
  }

 private:
  /// A star per patch of sheets, with its thickest node in the middle.
  void link_sheets() {
    std::vector<std::uint32_t> hub(graph_.sheets, kNone);
    const auto& nodes = graph_.nodes;
    for (std::uint32_t n = 0; n < nodes.size(); ++n)
      if (nodes[n].sheet != kNone) {
        std::uint32_t& best = hub[nodes[n].sheet];
        if (best == kNone || nodes[n].radius > nodes[best].radius) best = n;
      }
    for (std::uint32_t n = 0; n < nodes.size(); ++n)
      if (nodes[n].sheet != kNone && hub[nodes[n].sheet] != n) {
        const std::uint32_t middle = hub[nodes[n].sheet];
        sets_.unite(n, middle);
        sheet_ways_.push_back({n, kNone, false, middle});
        sheet_ways_.push_back({middle, kNone, false, n});
      }
  }

  /// Branches from thick to thin; one that closes a loop is then the thinnest of that loop.
  void cut_loops() {
    std::vector<std::uint32_t> order(graph_.branches.size());
    for (std::uint32_t b = 0; b < order.size(); ++b) order[b] = b;
    const auto key = [&](std::uint32_t b) {
      const CurveGraph::Branch& branch = graph_.branches[b];
      return std::make_tuple(-branch.min_radius, -branch.mean_radius, branch.length, b);
    };
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return key(a) < key(b); });
    for (std::uint32_t b : order)
      if (!sets_.unite(graph_.branches[b].from, graph_.branches[b].to)) cut_[b] = thinnest_segment(graph_.branches[b]);
  }

  /// Of equally thin ones the nearest to the middle.
  static std::uint32_t thinnest_segment(const CurveGraph::Branch& branch) {
    const auto segments = static_cast<std::uint32_t>(branch.points.size() - 1);
    const auto key = [&](std::uint32_t i) {
      const auto [thin, thick] = std::minmax(branch.radius[i], branch.radius[i + 1]);
      const std::uint32_t off = 2 * i + 1 > segments ? 2 * i + 1 - segments : segments - 2 * i - 1;
      return std::make_tuple(thin, thick, off, i);
    };
    std::uint32_t best = 0;
    for (std::uint32_t i = 1; i < segments; ++i)
      if (key(i) < key(best)) best = i;
    return best;
  }

  void list_ways() {
    ways_ = base::Csr<Way>::group(graph_.nodes.size(), [&](const auto& emit) {
      for (const Way& way : sheet_ways_) emit(way.node, way);
      for (std::uint32_t b = 0; b < graph_.branches.size(); ++b) {
        emit(graph_.branches[b].from, {graph_.branches[b].from, b, false, kNone});
        emit(graph_.branches[b].to, {graph_.branches[b].to, b, true, kNone});
      }
    });
    for (std::size_t n = 0; n < graph_.nodes.size(); ++n)
      std::ranges::sort(ways_[n], {}, [](const Way& w) { return std::tie(w.branch, w.backwards, w.linked); });
  }

  /// One per tree, in the order of the trees' first nodes.
  std::vector<std::uint32_t> choose_roots(const SwcOptions& options) {
    const auto& nodes = graph_.nodes;
    std::vector<std::uint32_t> best(nodes.size(), kNone), roots;
    std::uint32_t nearest = kNone;
    double distance = std::numeric_limits<double>::infinity();
    for (std::uint32_t n = 0; n < nodes.size(); ++n) {
      std::uint32_t& thickest = best[sets_.find(n)];
      if (thickest == kNone || nodes[n].radius > nodes[thickest].radius) thickest = n;
      if (!options.root) continue;
      if (const double d = (nodes[n].point - *options.root).norm(); d < distance) {
        distance = d;
        nearest = n;
      }
    }
    if (nearest != kNone) best[sets_.find(nearest)] = nearest;
    for (std::uint32_t n = 0; n < nodes.size(); ++n)
      if (sets_.find(n) == n) roots.push_back(best[n]);
    std::stable_sort(roots.begin(), roots.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return nodes[a].component < nodes[b].component; });
    return roots;
  }

  std::uint64_t add_row(const Vec3& point, double radius, std::uint64_t parent) {
    rows_.push_back({point, radius, parent});
    return rows_.size();
  }

  /// Adds the points of a branch, in the direction of `way`, from the second one up to the cut or to the last but one.
  std::uint64_t add_inner_points(const Way& way, std::uint64_t parent) {
    const CurveGraph::Branch& branch = graph_.branches[way.branch];
    const std::size_t last = branch.points.size() - 1, cut = cut_[way.branch];
    std::size_t end = last;  // first point not to write, counted along the way
    if (cut != kNone) end = way.backwards ? last - cut : cut + 1;
    for (std::size_t i = 1; i < end; ++i) {
      const std::size_t at = way.backwards ? last - i : i;
      parent = add_row(branch.points[at], branch.radius[at], parent);
    }
    if (cut != kNone) cut_ids_[way.branch][way.backwards ? 1 : 0] = parent;
    return parent;
  }

  /// Adds the rows of a tree depth first: the samples of a branch follow each other.
  void grow(std::uint32_t root) {
    struct Visit {
      Way way;
      std::uint64_t parent;
    };
    std::vector<Visit> stack;
    const auto visit = [&](std::uint32_t n, const Way* from, std::uint64_t parent) {
      const std::uint64_t id = add_row(graph_.nodes[n].point, graph_.nodes[n].radius, parent);
      if (from && from->branch == kNone) links_.push_back(id);
      const std::size_t bottom = stack.size();
      for (const Way& way : ways_[n]) {
        const bool cut = way.branch != kNone && cut_[way.branch] != kNone;
        const bool back = from && (way.branch == kNone ? from->branch == kNone && way.linked == from->node
                                                       : way.branch == from->branch);
        if (cut) {
          add_inner_points(way, id);
        } else if (!back) {
          stack.push_back({way, id});
        }
      }
      std::reverse(stack.begin() + static_cast<std::ptrdiff_t>(bottom), stack.end());
    };
    visit(root, nullptr, 0);
    while (!stack.empty()) {
      const Visit next = stack.back();
      stack.pop_back();
      if (next.way.branch == kNone) {
        visit(next.way.linked, &next.way, next.parent);
      } else {
        const CurveGraph::Branch& branch = graph_.branches[next.way.branch];
        const std::uint64_t parent = add_inner_points(next.way, next.parent);
        visit(next.way.backwards ? branch.from : branch.to, &next.way, parent);
      }
    }
  }

  const CurveGraph& graph_;
  base::UnionFind sets_;
  std::vector<std::uint32_t> cut_;                     ///< per branch: the segment left out, or kNone
  std::vector<std::array<std::uint64_t, 2>> cut_ids_;  ///< per cut branch: the samples on both sides of the cut
  std::vector<Way> sheet_ways_;                        ///< straight links, from both their ends
  base::Csr<Way> ways_;                                ///< per node: all ways out of it
  std::vector<Row> rows_;
  std::vector<std::uint64_t> links_, root_ids_;
  SwcReport report_;
};

}  // namespace

int swc_type_of(std::string_view text, std::string_view what) {
  for (const auto& [name, number] : kTypeNames)
    if (text == name) return number;
  int type = -1;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), type);
  if (error == std::errc() && end == text.data() + text.size() && type >= 0 && type <= 255) return type;
  std::string names;
  for (const auto& [name, number] : kTypeNames) names += fmt::format("{}{}", names.empty() ? "" : ", ", name);
  throw Error(
      ErrorCode::usage,
      fmt::format("{} '{}' is not a type of SWC samples; give a number from 0 to 255 or one of {}", what, text, names));
}

SwcReport write_swc(const std::filesystem::path& file, const CurveGraph& graph, const SwcOptions& options) {
  if (options.type < 0)
    throw Error(ErrorCode::usage, fmt::format("an SWC type is 0 or more, not {}; 0 is undefined", options.type));
  if (options.root && !options.root->allFinite())
    throw Error(ErrorCode::usage, "the root of an SWC tree must be a point with finite coordinates");
  const Trees trees(graph, options);
  SwcReport report;
  write_atomically(file, [&](std::ostream& out) { report = trees.write(out, options); });
  return report;
}

}  // namespace quench::io
