// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cstring>
#include <utility>

#include "base/grid_text.h"
#include "base/text.h"
#include "preparation/filters.h"
#include "quench/error.h"
#include "quench/preparation.h"
#include "shape/sample_type.h"

namespace quench {
namespace {

bool has_at_most_two_values(const Volume& volume) {
  return std::visit(
      [](const auto& samples) {
        if (samples.empty()) return true;
        const auto first = samples.front();
        auto second = first;
        for (const auto sample : samples) {
          if (sample == first || sample == second) continue;
          if (second != first || sample != sample) return false;
          second = sample;
        }
        return true;
      },
      volume.samples);
}

/// All but the voxels of a label become another value.
void keep_label(Volume& volume, std::int64_t label) {
  std::visit(
      [&]<class T>(std::vector<T>& samples) {
        const T other = label == 0 ? T{1} : T{0};
        for (T& sample : samples) {
          bool has = false;
          if constexpr (std::is_integral_v<T>)
            has = std::cmp_equal(sample, label);
          else
            has = sample == static_cast<T>(label);
          if (!has) sample = other;
        }
      },
      volume.samples);
}

/// Exchanges 0 and 1.
void exchange(Volume& volume) {
  std::visit(
      [](auto& samples) {
        using T = typename std::decay_t<decltype(samples)>::value_type;
        for (T& sample : samples) sample = sample == T{0} ? T{1} : T{0};
      },
      volume.samples);
}

void check(const Volume& volume, const PreparationOptions& options, bool mask) {
  const auto refuse = [](const std::string& sentence, const char* field) {
    throw Error(ErrorCode::usage, sentence, field);
  };
  if (options.median < 0 || options.median > kLargestMedian)
    refuse(
        fmt::format("the radius {} of the median is not a whole number from 0 to {}", options.median, kLargestMedian),
        "median");
  if (!(options.blur >= 0 && options.blur <= kLargestBlur))
    refuse(fmt::format("the width {} of the blur is not a number from 0 to {}", options.blur, kLargestBlur), "blur");
  if (options.blur > 0 && mask)
    refuse("a label or a mask has no grey values to blur; give a threshold, or take medians or close it instead",
           "blur");
  if (options.interpolate && volume.grid.is_plane())
    refuse("an image of the plane has no slices to interpolate between", "interpolate");
}

std::string sizes(const Grid& grid) {
  return fmt::format("{} x {} x {} voxels of {}", grid.dims[0], grid.dims[1], grid.dims[2],
                     base::axes_text(grid, grid.spacing));
}

}  // namespace

Volume prepared(Volume&& volume, const PreparationOptions& options, const ForegroundOptions& foreground,
                PreparationReport* report, Context* context) {
  Volume result = std::move(volume);
  PreparationReport done;
  done.before = result.grid;
  const bool mask = foreground.label || (!foreground.threshold && has_at_most_two_values(result));
  check(result, options, mask);
  if (foreground.label && options.any()) keep_label(result, *foreground.label);
  const bool grew = options.interpolate && preparation::cubes_of(result.grid).dims != result.grid.dims;
  if (options.interpolate) {
    const bool of_zero = foreground.label && *foreground.label == 0;
    if (of_zero) exchange(result);
    preparation::interpolate(result, mask, context);
    if (of_zero) exchange(result);
    done.done.push_back(grew ? fmt::format("interpolated {} to cubes: {} became {}",
                                           mask ? "by signed distances" : "linearly", sizes(done.before),
                                           sizes(result.grid))
                             : fmt::format("nothing to interpolate: {}", sizes(result.grid)));
  }
  if (options.median > 0) {
    preparation::take_medians(result, options.median, context);
    const int side = 2 * options.median + 1;
    done.done.push_back(result.grid.is_plane() ? fmt::format("medians of {0} x {0} pixels", side)
                                               : fmt::format("medians of {0} x {0} x {0} voxels", side));
  }
  if (options.blur > 0) {
    const std::size_t type = result.samples.index();
    preparation::blur(result, options.blur, context);
    done.done.push_back(
        fmt::format("blurred with a Gaussian of {} {}{}", options.blur,
                    options.blur == 1 ? base::cell_name(result.grid) : fmt::format("{}s", base::cell_name(result.grid)),
                    result.samples.index() == type ? "" : ", as floating-point numbers"));
  }
  if (report) *report = std::move(done);
  return result;
}

std::int64_t predicted_preparation_bytes(const Volume& volume, const PreparationOptions& options) {
  const auto count = [](const Grid& grid) {
    return static_cast<double>(grid.dims[0]) * static_cast<double>(grid.dims[1]) * static_cast<double>(grid.dims[2]);
  };
  return std::visit(
      [&]<class T>(const std::vector<T>&) {
        const double sample = std::max(sizeof(T), std::is_integral_v<T> && sizeof(T) == 1 ? sizeof(float) : sizeof(T));
        const double slice = static_cast<double>(volume.grid.dims[0]) * static_cast<double>(volume.grid.dims[1]);
        double bytes = 0;
        if (options.interpolate && !volume.grid.is_plane())
          bytes += count(volume.grid) * sizeof(float) + count(preparation::cubes_of(volume.grid)) * sample;
        if (options.median > 0) bytes = std::max(bytes, slice * (2 * options.median + 16) * sample);
        if (options.blur > 0)
          bytes = std::max(bytes, slice * (12 * options.blur + 32) * sizeof(preparation::Work<T>) +
                                      (sizeof(T) == 1 ? count(volume.grid) * sizeof(float) : 0));
        return static_cast<std::int64_t>(std::min(bytes, 0x1p62));
      },
      volume.samples);
}

Volume volume_of(const ImageView& image) {
  Volume volume;
  volume.grid = image.grid;
  const auto& dims = image.grid.dims;
  const auto copy = [&]<class T>(T) {
    std::vector<T> samples;
    samples.reserve(static_cast<std::size_t>(dims[0] * dims[1] * dims[2]));
    const auto* from = static_cast<const char*>(image.data);
    for (std::int64_t z = 0; z < dims[2]; ++z)
      for (std::int64_t y = 0; y < dims[1]; ++y)
        for (std::int64_t x = 0; x < dims[0]; ++x) {
          T sample;
          std::memcpy(&sample, from + image.strides[0] * x + image.strides[1] * y + image.strides[2] * z, sizeof(T));
          samples.push_back(sample);
        }
    volume.samples = std::move(samples);
  };
  shape::with_sample_type(image.type, copy);
  return volume;
}

}  // namespace quench
