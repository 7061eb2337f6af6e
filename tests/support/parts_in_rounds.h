// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <iterator>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "dual/bricks/part.h"

/// The parts of a shape in boxes that grow, all in memory.
namespace quench::testing_duals {

struct Boxes {
  std::int64_t size;                        ///< of the boxes of the first round
  std::int64_t halo;                        ///< of those of the second round; then it grows with the boxes
  std::array<std::int64_t, 3> corner = {};  ///< of a box
};

class Rounds {
 public:
  using Part = dual::bricks::Part;
  using Box = dual::bricks::Box;

  Rounds(const VoxelShape& shape, const Boxes& boxes)
      : shape_(shape), sites_(boundary_vertices(shape)), spacing_(integer_spacing(shape.grid())), boxes_(boxes) {}

  const std::vector<LatticePoint>& sites() const { return sites_; }
  dual::Hulls& hulls() { return hulls_; }
  std::size_t rounds() const { return rounds_; }

  /// `changed`: called with every part after each round.
  Part run(std::size_t most_rounds, const std::function<void(Part&)>& changed = nullptr) {
    std::map<Index, Part> parts;
    std::int64_t size = boxes_.size, halo = boxes_.halo;
    for (const LatticePoint& s : sites_)
      if (const Index index = index_of(s, size); !parts.contains(index)) parts[index] = first(box(index, size));
    for (rounds_ = 1; parts.size() > 1 && rounds_ < most_rounds; ++rounds_) {
      if (changed)
        for (auto& [index, part] : parts) changed(part);
      std::map<Index, Part> larger;
      for (const auto& [index, part] : parts) larger[half(index)];
      std::map<Index, dual::bricks::Unfinished> open;
      for (const auto& [index, part] : parts) open[index] = unfinished(part, hulls_);
      for (auto& [index, part] : larger) part = next(parts, open, index, 2 * size, halo);
      parts = std::move(larger);
      size *= 2;
      halo *= 2;
    }
    if (changed)
      for (auto& [index, part] : parts) changed(part);
    std::vector<Part> all;
    for (auto& [index, part] : parts) all.push_back(std::move(part));
    Part whole = joined(std::move(all), nullptr);
    Box box{{0, 0, 0}, {}};
    for (std::size_t a = 0; a < 3; ++a) box.high[a] = shape_.grid().dims[a] + 1;
    complete(whole, box, nullptr, {}, spacing_, hulls_, nullptr);
    return whole;
  }

 private:
  using Index = std::array<std::int64_t, 3>;

  static std::int64_t floor_of(std::int64_t a, std::int64_t b) { return a >= 0 ? a / b : -((b - 1 - a) / b); }
  static Index half(const Index& index) {
    return {floor_of(index[0], 2), floor_of(index[1], 2), floor_of(index[2], 2)};
  }
  Index index_of(const LatticePoint& p, std::int64_t size) const {
    Index index;
    for (std::size_t a = 0; a < 3; ++a) index[a] = floor_of(p[a] - boxes_.corner[a], size);
    return index;
  }
  Box box(const Index& index, std::int64_t size) const {
    Box box;
    for (std::size_t a = 0; a < 3; ++a) {
      box.low[a] = boxes_.corner[a] + index[a] * size;
      box.high[a] = box.low[a] + size;
    }
    return box;
  }
  static Box grown(Box box, std::int64_t by) {
    for (std::size_t a = 0; a < 3; ++a) {
      box.low[a] -= by;
      box.high[a] += by;
    }
    return box;
  }

  // With the voxels that it must know and no others.
  Part first(const Box& box) {
    const std::int32_t margin = dual::bricks::margin_of_first_part(spacing_);
    const Box around = grown(box, margin), voxels = grown(box, margin + 1);
    Grid grid;
    LatticePoint at;
    std::array<std::int64_t, 3> end;
    for (std::size_t a = 0; a < 3; ++a) {
      at[a] = static_cast<std::int32_t>(std::max<std::int64_t>(voxels.low[a], 0));
      end[a] = std::min(voxels.high[a], shape_.grid().dims[a]);
      grid.dims[a] = end[a] - at[a];
    }
    VoxelShape cut(grid);
    for (std::int64_t z = at[2]; z < end[2]; ++z)
      for (std::int64_t y = at[1]; y < end[1]; ++y) {
        std::vector<Run> runs;
        for (const Run& run : shape_.row(y, z)) {
          const auto first = std::max<std::int64_t>(run.begin, at[0]) - at[0];
          const auto last = std::min<std::int64_t>(run.end, end[0]) - at[0];
          if (first < last) runs.push_back({static_cast<std::int32_t>(first), static_cast<std::int32_t>(last)});
        }
        cut.append_row(runs);
      }
    std::vector<LatticePoint> sites;
    std::ranges::copy_if(sites_, std::back_inserter(sites), [&](const LatticePoint& s) { return around.contains(s); });
    return first_part(cut, at, sites, box, spacing_, hulls_, nullptr);
  }

  Part next(std::map<Index, Part>& parts, const std::map<Index, dual::bricks::Unfinished>& open, const Index& index,
            std::int64_t size, std::int64_t halo) {
    const Box own = box(index, size), region = grown(own, halo);
    std::vector<Part> children;
    std::vector<dual::bricks::Unfinished> around;
    for (auto& [child, part] : parts) {
      if (half(child) == index)
        children.push_back(std::move(part));
      else
        around.push_back(near(open.at(child), region));
    }
    Part part = joined(std::move(children), nullptr);
    complete(part, own, &region, around, spacing_, hulls_, nullptr);
    return part;
  }

  const VoxelShape& shape_;
  std::vector<LatticePoint> sites_;
  std::array<std::int64_t, 3> spacing_;
  Boxes boxes_;
  dual::Hulls hulls_;
  std::size_t rounds_ = 0;
};

}  // namespace quench::testing_duals
