// SPDX-License-Identifier: Apache-2.0
#include "io/mesh/weld.h"

#include <bit>

#include "quench/error.h"

namespace quench::io {
namespace {

std::uint64_t hash(const Vec3& point) {
  std::uint64_t h = 0;
  for (int a = 0; a < 3; ++a) {
    // Adding 0 turns -0 into 0: both are the same position.
    h = (h ^ std::bit_cast<std::uint64_t>(point[a] + 0.0)) * 0x9E3779B97F4A7C15ull;
    h ^= h >> 32;
  }
  return h;
}

}  // namespace

void Weld::grow(const std::vector<Vec3>& points) {
  slots_.assign(slots_.empty() ? 64 : 2 * slots_.size(), kNone);
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    std::size_t slot = hash(points[i]) & (slots_.size() - 1);
    while (slots_[slot] != kNone) slot = (slot + 1) & (slots_.size() - 1);
    slots_[slot] = i;
  }
}

std::uint32_t Weld::operator()(const Vec3& point, std::vector<Vec3>& points) {
  if (2 * (points.size() + 1) > slots_.size()) grow(points);
  std::size_t slot = hash(point) & (slots_.size() - 1);
  for (; slots_[slot] != kNone; slot = (slot + 1) & (slots_.size() - 1))
    if (points[slots_[slot]] == point) return slots_[slot];
  if (points.size() >= kNone) throw Error(ErrorCode::input, "a mesh has more than 4,294,967,294 different corners");
  slots_[slot] = static_cast<std::uint32_t>(points.size());
  points.push_back(point);
  return slots_[slot];
}

}  // namespace quench::io
