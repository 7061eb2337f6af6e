// SPDX-License-Identifier: Apache-2.0
#include "dual/peel/unit_cubes.h"

#include <bit>
#include <limits>

namespace quench::dual::peel {
namespace {

// Corners of the sides of a cube, counter-clockwise seen from inside: x low, x high, y low, y high, z low, z high.
constexpr std::uint8_t kSide[6][4] = {{0, 2, 6, 4}, {1, 5, 7, 3}, {0, 4, 5, 1},
                                      {2, 3, 7, 6}, {0, 1, 3, 2}, {4, 6, 7, 5}};

constexpr std::uint32_t corners_of_side(std::size_t side) {
  std::uint32_t corners = 0;
  for (const std::uint8_t c : kSide[side]) corners |= 1u << c;
  return corners;
}
constexpr std::array<std::uint32_t, 6> kCorners{corners_of_side(0), corners_of_side(1), corners_of_side(2),
                                                corners_of_side(3), corners_of_side(4), corners_of_side(5)};

constexpr std::array<std::uint32_t, 4> kNoSites{kNone, kNone, kNone, kNone};

}  // namespace

UnitCubes::UnitCubes(const VoxelShape& shape, std::span<const LatticePoint> sites, const delaunay::Bounds& bounds,
                     Hulls& hulls)
    : shape_(shape), sites_(sites) {
  for (std::size_t a = 0; a < 3; ++a) {
    low_[a] = std::max(bounds[0][a], 0);
    high_[a] = std::min<std::int64_t>(bounds[1][a], shape.grid().dims[a]);
  }
  HullFinder finder(hulls);
  for (std::uint32_t mask = 0; mask < 256; ++mask) {
    Kind& kind = kinds_[mask];
    kind.facet.fill(255);
    if (std::popcount(mask) < 4) continue;
    std::vector<delaunay::Point> points;
    std::vector<std::uint32_t> corner;
    for (std::uint32_t c = 0; c < 8; ++c)
      if (mask >> c & 1) {
        points.push_back({static_cast<std::int32_t>(c & 1), static_cast<std::int32_t>(c >> 1 & 1),
                          static_cast<std::int32_t>(c >> 2), c});
        corner.push_back(c);
      }
    kind.hull = finder.find(points);
    if (kind.hull == kNone) continue;
    const Hull& hull = hulls[kind.hull];
    for (std::uint32_t f = 0; f < hull.facets(); ++f) {
      std::uint32_t corners = 0;
      for (const std::uint32_t c : hull.corners_of(f)) corners |= 1u << corner[c];
      for (std::size_t side = 0; side < 6; ++side)
        if (corners == kCorners[side]) kind.facet[side] = static_cast<std::uint8_t>(f);
    }
  }
  if (low_[2] >= high_[2]) return;
  const auto lines = static_cast<std::size_t>(shape.grid().dims[1] + 1);
  line_begin_.assign(static_cast<std::size_t>(high_[2] - low_[2] + 1) * lines + 1, 0);
  const auto first = std::partition_point(sites.begin(), sites.end(), [&](const auto& s) { return s[2] < low_[2]; });
  line_begin_[0] = static_cast<std::uint32_t>(first - sites.begin());
  std::size_t line = 0;
  for (auto s = first; s != sites.end() && (*s)[2] <= high_[2]; ++s)
    for (const std::size_t at = static_cast<std::size_t>((*s)[2] - low_[2]) * lines + static_cast<std::size_t>((*s)[1]);
         line < at;)
      line_begin_[++line] = static_cast<std::uint32_t>(s - sites.begin());
  const auto last = std::partition_point(first, sites.end(), [&](const auto& s) { return s[2] <= high_[2]; });
  while (line + 1 < line_begin_.size()) line_begin_[++line] = static_cast<std::uint32_t>(last - sites.begin());
}

void UnitCubes::start_row(std::int64_t y, std::int64_t z) {
  const auto lines = static_cast<std::size_t>(shape_.grid().dims[1] + 1);
  for (std::size_t r = 0; r < 4; ++r) {
    const std::size_t line =
        (static_cast<std::size_t>(z - low_[2]) + (r >> 1)) * lines + static_cast<std::size_t>(y) + (r & 1);
    next_[r] = line_begin_[line];
    stop_[r] = line_begin_[line + 1];
  }
  const std::array<std::span<const Run>, 5> rows{shape_.row(y, z), shape_.row(y - 1, z), shape_.row(y + 1, z),
                                                 shape_.row(y, z - 1), shape_.row(y, z + 1)};
  for (std::size_t r = 0; r < 5; ++r) rows_[r] = {rows[r].data(), rows[r].data() + rows[r].size()};
  left_ = right_ = kNoSites;
  if (rows[0].empty())  // no voxels, so nothing to do
    next_ = stop_;
}

// Cubes with a column of sites on either side, in order of x.
bool UnitCubes::next_cube() {
  left_ = right_;
  ++x_;
  std::int64_t x = std::numeric_limits<std::int64_t>::max();  // of the next column
  for (std::size_t r = 0; r < 4; ++r)
    if (next_[r] < stop_[r]) x = std::min<std::int64_t>(x, sites_[next_[r]][0]);
  if (left_ == kNoSites) {
    if (x == std::numeric_limits<std::int64_t>::max()) return false;
    x_ = x - 1;
  }
  right_ = kNoSites;
  if (x == x_ + 1)
    for (std::size_t r = 0; r < 4; ++r)
      if (next_[r] < stop_[r] && sites_[next_[r]][0] == x) right_[r] = next_[r]++;
  return true;
}

// Rows are asked for growing x.
bool UnitCubes::inside(std::size_t row, std::int64_t x) {
  Row& r = rows_[row];
  while (r.run != r.end && r.run->end <= x) ++r.run;
  return r.run != r.end && r.run->begin <= x;
}

bool UnitCubes::look() {
  if (!inside(0, x_)) return false;
  std::array<std::uint32_t, 8> corner;
  std::uint32_t mask = 0;
  std::size_t count = 0;
  for (std::size_t r = 0; r < 4; ++r) {
    corner[2 * r] = left_[r];
    corner[2 * r + 1] = right_[r];
  }
  for (std::size_t c = 0; c < 8; ++c)
    if (corner[c] != kNone) {
      mask |= 1u << c;
      found_[count++] = corner[c];
    }
  if (count < 4) return false;
  const Run* run = rows_[0].run;
  const std::array<bool, 6> outside{run->begin == x_, run->end == x_ + 1, !inside(1, x_),
                                    !inside(2, x_),   !inside(3, x_),     !inside(4, x_)};
  const Kind& kind = kinds_[mask];
  cube_ = {{found_.data(), count}, kind.hull, 0, {}};
  std::size_t squares = 0;
  for (std::size_t side = 0; side < 6; ++side) {
    if (!outside[side]) continue;
    if (kind.hull != kNone)
      cube_.boundary |= std::uint64_t{1} << kind.facet[side];
    else
      squares_[squares++] = {corner[kSide[side][0]], corner[kSide[side][1]], corner[kSide[side][2]],
                             corner[kSide[side][3]]};
  }
  cube_.squares = {squares_.data(), squares};
  return kind.hull != kNone || squares > 0;
}

}  // namespace quench::dual::peel
