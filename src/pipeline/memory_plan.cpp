// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/memory.h"
#include "quench/error.h"
#include "quench/pipeline.h"
#include "shape/sample_type.h"

namespace quench::pipeline {
namespace {

bool is_limited(const Context* context) { return context && context->memory_limit > 0; }

std::int64_t limit_of(const Context* context) {
  return is_limited(context) ? context->memory_limit : base::available_memory();
}

}  // namespace

bool fits(double bytes, const Context* context) { return bytes <= static_cast<double>(limit_of(context)); }

bool samples_fit(const SliceStream& slices, const Context* context) {
  auto bytes = static_cast<double>(shape::size_of(slices.type));
  for (const std::int64_t n : slices.grid.dims) bytes *= static_cast<double>(n);
  return fits(bytes, context);
}

void require_memory(std::int64_t bytes, const std::string& what, const std::vector<std::string>& remedies,
                    const Context* context) {
  const std::int64_t limit = limit_of(context);
  if (bytes <= limit) return;
  throw Error(ErrorCode::failed,
              fmt::format("{} needs about {} of memory, and {} are {}; use {}", what, base::bytes_text(bytes),
                          base::bytes_text(limit), is_limited(context) ? "allowed" : "free", fmt::join(remedies, ", ")),
              "memory_limit");
}

CorePlan plan_core(const VoxelShape& shape, const Context* context) {
  CorePlan plan;
  plan.sites = count_boundary_vertices(shape);
  const bool plane = shape.grid().is_plane();  // whose cores are small, and made at once
  plan.at_once = plane ? predicted_core_bytes(plan.sites) : predicted_core_bytes(shape);
  plan.bricks = plane ? plan.at_once : predicted_core_bytes_in_bricks(shape);
  // Measuring gives freed memory back first, which is not worth its time for many small shapes.
  constexpr std::int64_t kSmall = 64 << 20;
  if (is_limited(context) || plan.at_once > kSmall) plan.held = base::held_memory();
  // A limit is for all the process holds; what is free is beside what it holds.
  const std::int64_t before = is_limited(context) ? plan.held : 0;
  plan.in_bricks = before + plan.at_once > limit_of(context) && plan.bricks < plan.at_once;
  return plan;
}

std::int64_t predicted_run_bytes(const VoxelShape& shape) {
  // 0.4 to 1.6 KB per site on organic and technical shapes and roots, by automatic detail and with automatic omega.
  return predicted_core_bytes(0) + 1800 * count_boundary_vertices(shape);
}

std::int64_t predicted_skeleton_bytes(const Burning& burning) {
  return 800 * std::int64_t{burning.node_count};  // 0.77 KB per node at most without a floor, 0.6 with that of a run
}

}  // namespace quench::pipeline
