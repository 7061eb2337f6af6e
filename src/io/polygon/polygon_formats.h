// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <istream>
#include <limits>
#include <string>
#include <utility>

#include "io/common/formats.h"
#include "quench/polygons.h"

/// One reader per format of polygons; for_each_feature() chooses among them by extension.
namespace quench::io {

/// Where readers hand over features. Counts them, and looks at their coordinates for what a user should know.
class FeatureSink {
 public:
  FeatureSink(std::string file, const std::function<void(PolygonFeature&&)>& take,
              const std::function<void(PolygonFeature&&, const Error&)>& bad, Context* context)
      : file_(std::move(file)), take_(take), bad_(bad), context_(context) {}

  void take(PolygonFeature&& feature) {
    if (context_ && context_->cancelled()) throw Error(ErrorCode::cancelled, "cancelled");
    for (const auto& ring : feature.polygons.rings)
      for (const Vec2& p : ring) {
        largest_[0] = std::max(largest_[0], std::abs(p[0]));
        largest_[1] = std::max(largest_[1], std::abs(p[1]));
        has_positions_ = true;
      }
    feature.number = count_++;
    take_(std::move(feature));
  }
  /// A feature that cannot be used, with what it has but its rings, and why: "its geometry is a Point, not a polygon".
  void refuse(const std::string& reason, PolygonFeature&& feature = {}) {
    feature.number = count_++;
    const Error error(ErrorCode::input, fmt::format("'{}': feature {}: {}", file_, feature.number, reason));
    bad_(std::move(feature), error);
  }

  /// A feature that is left out on purpose.
  void skip(const std::string& sentence) {
    ++count_;
    note(context_, sentence);
  }

  std::uint64_t count() const { return count_; }
  const std::string& file() const { return file_; }
  Context* context() const { return context_; }
  bool has_positions() const { return has_positions_; }
  const Vec2& largest() const { return largest_; }

 private:
  std::string file_;
  const std::function<void(PolygonFeature&&)>& take_;
  const std::function<void(PolygonFeature&&, const Error&)>& bad_;
  Context* context_;
  std::uint64_t count_ = 0;
  bool has_positions_ = false;   // of features that were taken
  Vec2 largest_ = Vec2::Zero();  // absolute coordinates
};

/// What a file says of its coordinates.
enum class Reference {
  degrees,  ///< longitude and latitude
  other,    ///< another system, by name or number
  unknown
};

/// Both stream. Text that is not of the format, or damaged, is Error(input).
Reference read_geojson(std::istream& in, FeatureSink& sink);
Reference read_geojson_lines(std::istream& in, FeatureSink& sink);
Reference read_wkt(std::istream& in, FeatureSink& sink);
void read_svg(const FileText& file, double curve_tolerance, FeatureSink& sink);

}  // namespace quench::io
