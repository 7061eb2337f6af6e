// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "base/csr.h"
#include "base/text.h"
#include "io/common/words.h"
#include "io/tree/tree_samples.h"
#include "quench/error.h"

/// SWC: a sample per line, `id type x y z radius parent`. Files differ in what they keep of that: parents come before
/// or after children, whole numbers are written as 3.0, more columns follow.
namespace quench::io {
namespace {

constexpr int kSoma = 1, kForkLabel = 5, kEndLabel = 6;

struct Row {
  std::int64_t id = 0, parent = -1;
  std::size_t line = 0;
  TreeSample sample;
};

class SwcReader {
 public:
  SwcReader(const FileText& file, Context* context) : file_(file), context_(context) {}

  Tree read() {
    read_rows();
    find_parents();
    sort_rows();
    drop_labels();
    join_somas();
    std::vector<std::uint32_t> plant_of_root;
    Tree tree = tree_of_samples(samples_, &plant_of_root);
    if (tree.branches.empty())
      throw Error(ErrorCode::input, fmt::format("'{}' holds no branch: no sample has a parent", file_.name));
    for (std::size_t r = 0; r < plant_of_root.size(); ++r)
      if (plant_of_root[r] != kNone && somas_[r]) tree.plants[plant_of_root[r]].soma = samples_[roots_[r]].radius;
    if (const auto alone = std::count(plant_of_root.begin(), plant_of_root.end(), kNone); alone > 0)
      note(context_, fmt::format("'{}': {} without a branch left out", file_.name, base::counted(alone, "sample")));
    number_branches(tree);
    return tree;
  }

 private:
  [[noreturn]] void fail(std::size_t line, const std::string& what) const {
    throw Error(ErrorCode::input, fmt::format("'{}', line {}: {}", file_.name, line, what));
  }

  void read_rows() {
    Words words(file_.bytes, file_.name);
    std::int64_t unknown = 0;
    while (words.next_line()) {
      if (rows_.size() % 65536 == 0)
        checkpoint(context_, "read", static_cast<double>(words.position()) / static_cast<double>(file_.bytes.size()));
      Row row;
      row.line = words.line();
      row.id = whole(words, "the id");
      row.sample.type = static_cast<int>(std::clamp<std::int64_t>(whole(words, "the type"), 0, 255));
      for (int a = 0; a < 3; ++a) row.sample.point[a] = words.coordinate_on_line("a coordinate");
      if (!(row.sample.point.cwiseAbs().maxCoeff() <= kLargestLength)) words.fail("a coordinate is too large");
      const double radius = words.number_on_line("the radius");
      const bool known = radius >= 0 && radius <= kLargestLength;
      row.sample.radius = known ? radius : 0;
      unknown += !known;
      row.parent = whole(words, "the parent");
      rows_.push_back(row);
      if (rows_.size() == kNone) words.fail("there are more samples than 4294967294");
    }
    if (rows_.empty()) throw Error(ErrorCode::input, fmt::format("'{}' holds no samples", file_.name));
    if (unknown > 0)
      note(context_, fmt::format("'{}': {} no length; taken as not known, 0", file_.name,
                                 base::counted(unknown, "radius is", "radii are")));
  }

  /// Some programs write all columns as floating-point numbers.
  static std::int64_t whole(Words& words, const char* what) {
    const double value = words.number_on_line(what);
    if (!(std::abs(value) <= 0x1p53) || value != std::floor(value))
      words.fail(fmt::format("{} is {}, which is not a whole number", what, value));
    return static_cast<std::int64_t>(value);
  }

  void find_parents() {
    std::vector<std::pair<std::int64_t, std::uint32_t>> ids;
    for (std::uint32_t i = 0; i < rows_.size(); ++i) ids.emplace_back(rows_[i].id, i);
    std::sort(ids.begin(), ids.end());
    for (std::size_t i = 1; i < ids.size(); ++i)
      if (ids[i].first == ids[i - 1].first)
        fail(rows_[ids[i].second].line,
             fmt::format("there is another sample of id {}, in line {}", ids[i].first, rows_[ids[i - 1].second].line));
    for (Row& row : rows_) {
      const auto found = std::lower_bound(ids.begin(), ids.end(), std::pair{row.parent, std::uint32_t{0}});
      if (found != ids.end() && found->first == row.parent)
        row.sample.parent = found->second;
      else if (row.parent > 0)  // -1 is a root; 0 is one where no sample has it
        fail(row.line, fmt::format("there is no sample of id {}, the parent", row.parent));
    }
  }

  /// Parents first, depth first, else in the order of the file.
  void sort_rows() {
    const auto n = static_cast<std::uint32_t>(rows_.size());
    const auto children = base::Csr<std::uint32_t>::group(n, [&](const auto& emit) {
      for (std::uint32_t i = 0; i < n; ++i)
        if (rows_[i].sample.parent != kNone) emit(rows_[i].sample.parent, i);
    });
    std::vector<std::uint32_t> place(n, kNone), open;
    for (std::uint32_t i = n; i-- > 0;)
      if (rows_[i].sample.parent == kNone) open.push_back(i);
    while (!open.empty()) {
      const std::uint32_t i = open.back();
      open.pop_back();
      place[i] = static_cast<std::uint32_t>(samples_.size());
      TreeSample sample = rows_[i].sample;
      if (sample.parent != kNone) sample.parent = place[sample.parent];
      samples_.push_back(sample);
      const auto& all = children[i];
      for (std::size_t c = all.size(); c-- > 0;) open.push_back(all[c]);
    }
    for (std::uint32_t i = 0; i < n; ++i)
      if (place[i] == kNone) fail(rows_[i].line, "the parents of this sample lead in a circle");
    rows_ = {};
  }

  /// In older files 5 and 6 say what a sample is in the tree, a fork or an end, and not of what.
  void drop_labels() {
    std::vector<std::uint32_t> children(samples_.size(), 0);
    for (const TreeSample& sample : samples_)
      if (sample.parent != kNone) ++children[sample.parent];
    for (std::size_t s = 0; s < samples_.size(); ++s) {
      if (samples_[s].type == kForkLabel && children[s] < 2) return;
      if (samples_[s].type == kEndLabel && children[s] > 0 && samples_[s].parent != kNone) return;
    }
    for (TreeSample& sample : samples_)
      if (sample.type == kForkLabel || sample.type == kEndLabel) sample.type = 0;
  }

  /// The samples of type soma around a root node become one, the root node. A tree of such samples alone has none: a
  /// type that all samples have says nothing.
  void join_somas() {
    const auto n = static_cast<std::uint32_t>(samples_.size());
    std::vector<std::uint32_t> root_of(n);
    std::vector<char> in_soma(n), others(n, 0);
    for (std::uint32_t s = 0; s < n; ++s) {
      const std::uint32_t parent = samples_[s].parent;
      root_of[s] = parent == kNone ? s : root_of[parent];
      in_soma[s] = samples_[s].type == kSoma && (parent == kNone || in_soma[parent]);
      if (!in_soma[s]) others[root_of[s]] = 1;
    }
    std::map<std::uint32_t, std::vector<std::uint32_t>> members;  // by root node
    for (std::uint32_t s = 0; s < n; ++s) {
      in_soma[s] = in_soma[s] && others[root_of[s]];
      if (in_soma[s]) members[root_of[s]].push_back(s);
    }
    std::vector<std::uint32_t> place(n, kNone);
    std::vector<TreeSample> kept;
    for (std::uint32_t s = 0; s < n; ++s) {
      TreeSample sample = samples_[s];
      const bool root = sample.parent == kNone;
      if (root) {
        roots_.push_back(static_cast<std::uint32_t>(kept.size()));
        somas_.push_back(in_soma[s]);
        if (in_soma[s]) make_ball(sample, members[s]);
      } else if (in_soma[s]) {
        place[s] = place[root_of[s]];
        continue;
      } else {
        sample.parent = place[sample.parent];
      }
      place[s] = static_cast<std::uint32_t>(kept.size());
      kept.push_back(sample);
    }
    samples_ = std::move(kept);
  }

  /// One sample is the soma itself; of three, two that hang on the first lie at its surface (the convention of
  /// NeuroMorpho.org); more are a stack of cylinders or its outline: the mean, as far as the samples reach on average.
  void make_ball(TreeSample& sample, const std::vector<std::uint32_t>& members) const {
    const std::uint32_t first = members[0];
    const bool three =
        members.size() == 3 && samples_[members[1]].parent == first && samples_[members[2]].parent == first;
    if (members.size() == 1 || three) return;
    Vec3 centre = Vec3::Zero();
    for (const std::uint32_t s : members) centre += samples_[s].point / static_cast<double>(members.size());
    double reach = 0, thickest = 0;
    for (const std::uint32_t s : members) {
      reach += (samples_[s].point - centre).norm() / static_cast<double>(members.size());
      thickest = std::max(thickest, samples_[s].radius);
    }
    sample.point = centre;
    sample.radius = std::max(reach, thickest);
  }

  const FileText& file_;
  Context* context_;
  std::vector<Row> rows_;
  std::vector<TreeSample> samples_;
  std::vector<std::uint32_t> roots_;  ///< samples
  std::vector<char> somas_;           ///< per root node: it is one
};

}  // namespace

Tree read_swc(const FileText& file, Context* context) { return SwcReader(file, context).read(); }

}  // namespace quench::io
