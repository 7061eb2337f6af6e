// SPDX-License-Identifier: Apache-2.0
#include "axis/significant_parts.h"

#include <tbb/parallel_sort.h>

#include <algorithm>

namespace quench::axis {

SignificantParts::SignificantParts(const TopCells& cells, std::uint32_t vertex_count, double least)
    : cells_(cells), member_of_(vertex_count, kNone), above_(cells.count(), 0) {
  for (std::uint32_t c = 0; c < cells.count(); ++c)
    if (cells.value(c) >= least) {
      order_.push_back({cells.value(c), c});
      above_[c] = 1;
    }
  tbb::parallel_sort(order_.begin(), order_.end(), [](const Entry& a, const Entry& b) {
    return a.height != b.height ? a.height > b.height : a.cell < b.cell;
  });
  std::uint32_t members = 0;
  for (const Entry& entry : order_)
    cells.for_corners(entry.cell, [&](std::uint32_t v) {
      if (member_of_[v] == kNone) member_of_[v] = members++;
    });
  sets_ = base::UnionFind(members);
  parts_.resize(members);
  next_.assign(order_.size(), kNone);
}

void SignificantParts::set_details() {
  for (std::uint32_t i = 0; i < order_.size(); ++i) add(i);
  for (Part& part : parts_)
    if (!part.significant) resolve(part, part.peak / kPeak);
}

void SignificantParts::raise(const std::vector<char>& needed, double least) {
  for (const Entry& entry : order_)
    if (needed[component_of(cells_.first_corner(entry.cell))])
      cells_.value(entry.cell) = std::max(cells_.value(entry.cell), least);
}

void SignificantParts::resolve(Part& part, double detail) {
  for (std::uint32_t i = part.first; i != kNone; i = next_[i]) cells_.value(order_[i].cell) = detail;
  part.first = part.last = kNone;
  part.significant = true;
}

// Before anything happens to a component at d: it may have become significant on the way there.
void SignificantParts::catch_up(Part& part, double d) {
  if (!part.significant && part.peak / kPeak >= d) resolve(part, part.peak / kPeak);
}

void SignificantParts::join(std::uint32_t a, std::uint32_t b, double d) {
  Part &p = parts_[a], &q = parts_[b];
  catch_up(p, d);
  catch_up(q, d);
  if (p.significant != q.significant) resolve(p.significant ? q : p, d);
  Part merged{std::max(p.peak, q.peak), p.significant, p.first, p.last};
  if (q.first != kNone) {
    (merged.first == kNone ? merged.first : next_[merged.last]) = q.first;
    merged.last = q.last;
  }
  sets_.unite(a, b);
  p = q = {0, true, kNone, kNone};  // nothing is left to resolve in the one that is no root any more
  parts_[sets_.find(a)] = merged;
}

void SignificantParts::add(std::uint32_t i) {
  const double height = order_[i].height;
  std::uint32_t root = kNone;
  cells_.for_corners(order_[i].cell, [&](std::uint32_t v) {
    const std::uint32_t set = sets_.find(member_of_[v]);
    parts_[set].peak = std::max(parts_[set].peak, height);  // changes vertices that are met for the first time
    if (root != kNone && set != root) join(root, set, height);
    root = sets_.find(set);
  });
  Part& part = parts_[root];
  catch_up(part, height);
  if (part.significant) return;  // the detail is the height
  (part.first == kNone ? part.first : next_[part.last]) = i;
  part.last = i;
}

}  // namespace quench::axis
