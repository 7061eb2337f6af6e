// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <functional>

#include "base/grid_text.h"
#include "base/text.h"
#include "quench/error.h"
#include "quench/shape.h"
#include "shape/voxel_components.h"

namespace quench {
namespace {

// The runs for which keep(index among all runs).
template <class Keep>
VoxelShape filtered(const VoxelShape& shape, const Keep& keep) {
  VoxelShape result(shape.grid());
  std::vector<Run> runs;
  shape::for_scanlines(shape, nullptr, {}, [&](std::int64_t y, std::int64_t z) {
    const auto row = shape.row(y, z);
    std::uint32_t index = shape::first_index(shape, row);
    runs.clear();
    for (const Run& run : row)
      if (keep(index++)) runs.push_back(run);
    result.append_row(runs);
  });
  return result;
}

VoxelShape drop_components(const VoxelShape& shape, const ForegroundOptions& options, ForegroundReport& report,
                           Context* context) {
  base::UnionFind sets = shape::foreground_components(shape, context);
  const auto runs = shape.runs();
  std::vector<std::int64_t> voxels(runs.size(), 0);
  for (std::uint32_t i = 0; i < runs.size(); ++i) voxels[sets.find(i)] += runs[i].end - runs[i].begin;
  // The first of equally large components wins.
  const auto largest = static_cast<std::uint32_t>(std::max_element(voxels.begin(), voxels.end()) - voxels.begin());
  const auto keep = [&](std::uint32_t root) {
    return voxels[root] >= options.min_component && (!options.largest_component || root == largest);
  };
  for (std::uint32_t i = 0; i < runs.size(); ++i)
    if (voxels[i] > 0 && !keep(i)) {
      ++report.components_removed;
      report.voxels_removed += voxels[i];
    }
  const std::string cell = base::cell_name(shape.grid());
  if (report.voxels_removed == shape.voxel_count())
    throw Error(ErrorCode::input,
                fmt::format("dropping components of fewer than {} leaves nothing: the largest component has {}",
                            base::counted(options.min_component, cell), base::counted(voxels[largest], cell)));
  if (report.components_removed == 0) return shape;
  return filtered(shape, [&](std::uint32_t run) { return keep(sets.find(run)); });
}

// Of the gap after each run: the voxels of its cavity, 0 outside.
struct Cavities {
  explicit Cavities(const VoxelShape& shape, Context* context)
      : sets(shape::background_components(shape, context)),
        outside(sets.find(static_cast<std::uint32_t>(shape.runs().size()))),
        voxels(shape.runs().size(), 0) {
    shape::for_scanlines(shape, nullptr, {}, [&](std::int64_t y, std::int64_t z) {
      const auto row = shape.row(y, z);
      std::uint32_t gap = shape::first_index(shape, row);
      for (std::size_t i = 0; i + 1 < row.size(); ++i, ++gap)
        if (const std::uint32_t root = sets.find(gap); root != outside) voxels[root] += row[i + 1].begin - row[i].end;
    });
  }
  base::UnionFind sets;
  std::uint32_t outside;
  std::vector<std::int64_t> voxels;  // per root
};

VoxelShape fill_cavities(const VoxelShape& shape, const ForegroundOptions& options, ForegroundReport& report,
                         Context* context) {
  Cavities cavities(shape, context);
  VoxelShape result(shape.grid());
  std::vector<Run> filled;
  shape::for_scanlines(shape, nullptr, {}, [&](std::int64_t y, std::int64_t z) {
    const auto row = shape.row(y, z);
    filled.assign(row.begin(), row.end());
    std::uint32_t gap = shape::first_index(shape, row);
    for (std::size_t i = 0; i + 1 < row.size(); ++i, ++gap)
      if (const std::uint32_t root = cavities.sets.find(gap);
          root != cavities.outside && (options.fill_cavities || cavities.voxels[root] < options.min_cavity)) {
        report.voxels_filled += row[i + 1].begin - row[i].end;
        report.cavities_filled += root == gap;
        filled[i].end = row[i + 1].begin;  // touches the next run: append_row merges them
      }
    result.append_row(filled);
  });
  return result;
}

}  // namespace

std::vector<std::int64_t> cavity_sizes(const VoxelShape& shape, Context* context) {
  if (shape.empty()) return {};
  std::vector<std::int64_t> sizes = Cavities(shape, context).voxels;
  std::erase(sizes, 0);
  std::ranges::sort(sizes, std::greater{});
  return sizes;
}

Specks specks_of(const VoxelShape& shape, std::int64_t below, Context* context) {
  base::UnionFind sets = shape::foreground_components(shape, context);
  base::UnionFind touching = shape::touching_components(shape, context);
  const auto runs = shape.runs();
  std::vector<std::int64_t> voxels(runs.size(), 0);
  for (std::uint32_t i = 0; i < runs.size(); ++i) voxels[sets.find(i)] += runs[i].end - runs[i].begin;
  std::vector<std::uint32_t> parts(runs.size(), 0);  // components per set of those that touch
  for (std::uint32_t i = 0; i < runs.size(); ++i) parts[touching.find(i)] += voxels[i] > 0;
  Specks specks;
  for (std::uint32_t i = 0; i < runs.size(); ++i) {
    if (voxels[i] == 0 || voxels[i] >= below) continue;
    ++specks.count;
    specks.voxels += voxels[i];
    specks.touching += parts[touching.find(i)] > 1;
  }
  return specks;
}

std::string percent_text(std::int64_t part, std::int64_t whole) {
  if (part == 0) return "0%";
  const double percent = 100 * static_cast<double>(part) / static_cast<double>(whole);
  if (percent >= 99 && part < whole) return "more than 99%";
  return percent >= 1 ? fmt::format("{:.0f}%", percent) : fmt::format("{:.1g}%", percent);
}

std::string much_dropped(const ForegroundReport& report, bool plane) {
  constexpr std::int64_t kMuch = 20;  // one in so many voxels
  if (report.voxels_removed == 0 || report.voxels_removed * kMuch < report.voxels_before) return {};
  return fmt::format(
      "dropping components took {} of the shape; if that was not meant, a lower threshold or a higher "
      "resolution may connect them, and a minimal number of {}s drops specks only",
      percent_text(report.voxels_removed, report.voxels_before), plane ? "pixel" : "voxel");
}

VoxelShape clean(const VoxelShape& shape, const ForegroundOptions& options, ForegroundReport* report,
                 Context* context) {
  ForegroundReport changed;
  changed.voxels_before = shape.voxel_count();
  VoxelShape result = shape;
  if (!shape.empty() && (options.largest_component || options.min_component > 1))
    result = drop_components(result, options, changed, context);
  if (!result.empty() && (options.fill_cavities || options.min_cavity > 1))
    result = fill_cavities(result, options, changed, context);
  if (report) *report = changed;
  return result;
}

}  // namespace quench
