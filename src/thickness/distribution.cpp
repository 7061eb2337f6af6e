// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "quench/thickness.h"

namespace quench {
namespace {

// 13 bits of the mantissa: percentiles to 1/8192.
constexpr int kDroppedBits = 10;
constexpr double kMostBins = 1 << 20;

std::size_t bucket_of(double value) { return std::bit_cast<std::uint32_t>(static_cast<float>(value)) >> kDroppedBits; }
double value_of(std::size_t bucket) {
  return static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(bucket << kDroppedBits)));
}

// Makes room for place `at` in values of which the first has the place `first`.
void make_room(std::vector<double>& values, std::size_t& first, std::size_t at) {
  if (values.empty()) first = at;
  if (at < first) {
    values.insert(values.begin(), first - at, 0.0);
    first = at;
  }
  if (at - first >= values.size()) values.resize(at - first + 1, 0.0);
}

}  // namespace

ThicknessDistribution::ThicknessDistribution(double width, std::size_t bins)
    : width_(width > 0 ? width : 1), bins_(bins, 0.0) {}

void ThicknessDistribution::add(double value, double weight) {
  if (!(value >= 0) || !(weight > 0) || !std::isfinite(value) || !std::isfinite(weight)) return;
  least_ = weight_ > 0 ? std::min(least_, value) : value;
  largest_ = weight_ > 0 ? std::max(largest_, value) : value;
  weight_ += weight;
  const double difference = value - mean_;
  mean_ += difference * (weight / weight_);
  squares_ += weight * difference * (value - mean_);
  const auto bin = static_cast<std::size_t>(std::min(value / width_, kMostBins));
  if (bin >= bins_.size()) bins_.resize(bin + 1, 0.0);
  bins_[bin] += weight;
  const std::size_t bucket = bucket_of(value);
  if (bucket < first_ || bucket - first_ >= fine_.size()) make_room(fine_, first_, bucket);
  fine_[bucket - first_] += weight;
}

void ThicknessDistribution::add(const ThicknessDistribution& other) {
  if (!(other.weight_ > 0)) return;
  least_ = weight_ > 0 ? std::min(least_, other.least_) : other.least_;
  largest_ = weight_ > 0 ? std::max(largest_, other.largest_) : other.largest_;
  const double all = weight_ + other.weight_, difference = other.mean_ - mean_;
  mean_ += difference * (other.weight_ / all);
  squares_ += other.squares_ + difference * difference * (weight_ / all) * other.weight_;
  weight_ = all;
  if (other.bins_.size() > bins_.size()) bins_.resize(other.bins_.size(), 0.0);
  for (std::size_t b = 0; b < other.bins_.size(); ++b) bins_[b] += other.bins_[b];
  make_room(fine_, first_, other.first_);
  make_room(fine_, first_, other.first_ + other.fine_.size() - 1);
  for (std::size_t b = 0; b < other.fine_.size(); ++b) fine_[other.first_ + b - first_] += other.fine_[b];
}

double ThicknessDistribution::deviation() const {
  return weight_ > 0 ? std::sqrt(std::max(0.0, squares_ / weight_)) : 0;
}

double ThicknessDistribution::percentile(double share) const {
  if (!(weight_ > 0)) return 0;
  if (share <= 0) return least_;
  double below = 0;
  for (std::size_t b = 0; b < fine_.size(); ++b) {
    below += fine_[b];
    // Rounded sums of weights must not take the next value.
    if (below < share * weight_ * (1 - 1e-12)) continue;
    const double middle = (value_of(first_ + b) + value_of(first_ + b + 1)) / 2;
    return std::clamp(middle, least_, largest_);
  }
  return largest_;
}

double automatic_bin_width(const Grid& grid, double largest) {
  constexpr double kMost = 200;
  double tenth = grid.spacing.minCoeff() / 10;
  if (!(tenth > 0) || !std::isfinite(largest)) return 1;
  for (;; tenth *= 10)
    for (const double step : {1.0, 2.0, 5.0})
      if (largest <= kMost * step * tenth) return step * tenth;
}

double thickness_correction(const MedialAxis& axis) {
  return axis.grid.is_plane() || axis.is_fitted() ? 0 : axis.grid.spacing.minCoeff() / 2;
}

ThicknessDistribution sheet_thickness(const MedialAxis& axis, double correction) {
  ThicknessDistribution all(axis.grid.spacing.minCoeff());
  const CellComplex& cells = axis.complex;
  if (axis.grid.is_plane())
    for (const auto& [a, b] : cells.edges)
      all.add(axis.radius[a] + axis.radius[b] + 2 * correction, (axis.points[b] - axis.points[a]).norm());
  for (std::size_t f = 0; f < cells.face_count(); ++f) {
    const auto corners = cells.corners(f);
    for (std::size_t i = 2; i < corners.size(); ++i) {
      const std::uint32_t a = corners[0], b = corners[i - 1], c = corners[i];
      const Vec3 normal = (axis.points[b] - axis.points[a]).cross(axis.points[c] - axis.points[a]);
      all.add((axis.radius[a] + axis.radius[b] + axis.radius[c]) * (2.0 / 3) + 2 * correction, normal.norm() / 2);
    }
  }
  return all;
}

}  // namespace quench
