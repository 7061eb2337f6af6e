// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <unordered_map>
#include <utility>

#include "quench/error.h"
#include "quench/shape.h"
#include "shape/image_rows.h"

namespace quench {
namespace {

// Tiles of 64 x 1 x 64 voxels are copied into the order of runs first: cache lines are read once whatever the order in
// memory is.
constexpr std::int64_t kTile = 64;

template <class T>
std::vector<LabelRuns> runs_of(const shape::Samples<T>& samples, const std::function<bool(std::int64_t)>& wanted,
                               Context* context) {
  if constexpr (!std::is_integral_v<T>) {
    throw Error(ErrorCode::input, "the image holds no labels: its values are floating-point numbers; give integers");
  } else {
    const auto& dims = samples.grid().dims;
    std::unordered_map<T, std::size_t> place;  // per label its index in `found`, or kUnwanted
    constexpr auto kUnwanted = static_cast<std::size_t>(-1);
    std::vector<LabelRuns> found;
    const auto place_of = [&](T value) {
      const auto [entry, is_new] = place.try_emplace(value, kUnwanted);
      if (!is_new) return entry->second;
      if (!std::in_range<std::int64_t>(value))
        throw Error(ErrorCode::input, fmt::format("the label {} does not fit into 64 bits with a sign", value));
      const auto label = static_cast<std::int64_t>(value);
      if (wanted ? wanted(label) : label != 0) {
        entry->second = found.size();
        found.push_back({label, {}});
      }
      return entry->second;
    };
    T last{};
    std::size_t last_place = place_of(last);
    const bool along_x = samples.order()[2] == 0;
    std::vector<T> tile(static_cast<std::size_t>(dims[0] * (along_x ? 1 : kTile)));
    const auto nx = static_cast<std::int32_t>(dims[0]);
    const auto scan = [&](const T* row, std::int64_t y, std::int64_t z) {
      for (std::int32_t x = 0; x < nx;) {
        const std::int32_t begin = x;
        const T value = row[x];
        while (x < nx && row[x] == value) ++x;
        if (value != last) last_place = place_of(last = value);
        if (last_place != kUnwanted)
          found[last_place].pieces.push_back({static_cast<std::int32_t>(z), static_cast<std::int32_t>(y), begin, x});
      }
    };
    const std::int64_t depth = along_x ? 1 : kTile;
    for (std::int64_t base = 0; base < dims[2]; base += depth) {
      checkpoint(context, "labels", static_cast<double>(base) / static_cast<double>(dims[2]));
      const std::int64_t count = std::min(depth, dims[2] - base);
      for (std::int64_t y = 0; y < dims[1]; ++y) {
        for (std::int64_t x = 0; x < dims[0]; ++x)
          for (std::int64_t z = 0; z < count; ++z)
            tile[static_cast<std::size_t>(z * dims[0] + x)] = samples.at(x, y, base + z);
        for (std::int64_t z = 0; z < count; ++z) scan(tile.data() + z * dims[0], y, base + z);
      }
    }
    checkpoint(context, "labels", 1);
    std::erase_if(found, [](const LabelRuns& l) { return l.pieces.empty(); });
    std::sort(found.begin(), found.end(), [](const LabelRuns& a, const LabelRuns& b) { return a.label < b.label; });
    return found;
  }
}

}  // namespace

VoxelShape LabelRuns::shape(const Grid& image) const {
  if (pieces.empty()) return VoxelShape(image);
  constexpr std::int64_t kFar = std::numeric_limits<std::int32_t>::max();
  std::array<std::int64_t, 3> low{kFar, kFar, kFar}, high{0, 0, 0};
  for (const Piece& p : pieces) {
    const std::array<std::int64_t, 3> begin{p.begin, p.y, p.z}, end{p.end, p.y + 1, p.z + 1};
    for (std::size_t a = 0; a < 3; ++a) {
      low[a] = std::min(low[a], begin[a]);
      high[a] = std::max(high[a], end[a]);
    }
  }
  Grid whole = image;  // rounded as a whole, so that all labels lie on one lattice
  whole.spacing = nearest_integer_spacing(image);
  if (whole.is_plane()) whole.make_plane();
  Grid grid = whole;
  Vec3 corner;
  for (std::size_t a = 0; a < 3; ++a) {
    grid.dims[a] = high[a] - low[a];
    corner[static_cast<Eigen::Index>(a)] =
        static_cast<double>(low[a]) + whole.first_centre()[static_cast<Eigen::Index>(a)];
  }
  grid.origin = whole.world(corner);
  std::vector<Piece> sorted = pieces;
  std::sort(sorted.begin(), sorted.end());
  VoxelShape result(grid);
  std::vector<Run> runs;
  auto piece = sorted.begin();
  for (std::int64_t z = low[2]; z < high[2]; ++z)
    for (std::int64_t y = low[1]; y < high[1]; ++y) {
      runs.clear();
      for (; piece != sorted.end() && piece->z == z && piece->y == y; ++piece)
        runs.push_back(
            {static_cast<std::int32_t>(piece->begin - low[0]), static_cast<std::int32_t>(piece->end - low[0])});
      result.append_row(runs);
    }
  return result;
}

std::vector<LabelRuns> label_runs(const ImageView& image, const std::function<bool(std::int64_t)>& wanted,
                                  Context* context) {
  return shape::with_samples(image, [&](const auto& samples) { return runs_of(samples, wanted, context); });
}

}  // namespace quench
