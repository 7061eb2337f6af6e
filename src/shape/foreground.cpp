// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <concepts>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <type_traits>
#include <utility>

#include "base/grid_text.h"
#include "quench/error.h"
#include "quench/shape.h"
#include "shape/grown.h"
#include "shape/image_rows.h"
#include "shape/isosurface.h"

namespace quench {
namespace {

// Decides whether a sample is foreground, in the type of the samples, so that 64-bit labels stay exact.
template <class T>
struct Rule {
  enum class Kind { none, all, at_least, equal, non_zero } kind = Kind::none;
  T value{};

  bool operator()(T sample) const {
    switch (kind) {
      case Kind::all:
        return true;
      case Kind::at_least:
        return sample >= value;
      case Kind::equal:
        return sample == value;
      case Kind::non_zero:
        return sample != T{} && sample == sample;
      default:
        return false;
    }
  }
};

// The least sample >= t; exact for every type, as t is rounded up to the samples'.
template <class T>
Rule<T> at_least(double t) {
  using Kind = typename Rule<T>::Kind;
  if constexpr (std::is_integral_v<T>) {
    const double least = std::ceil(t);
    if (least >= std::ldexp(1.0, std::numeric_limits<T>::digits)) return {Kind::none, {}};
    if (least <= static_cast<double>(std::numeric_limits<T>::min())) return {Kind::all, {}};
    return {Kind::at_least, static_cast<T>(least)};
  } else {
    T value = static_cast<T>(t);
    if (static_cast<double>(value) < t) value = std::nextafter(value, std::numeric_limits<T>::infinity());
    return {Kind::at_least, value};
  }
}

template <class T, std::integral Whole>
Rule<T> at_least(Whole t) {
  using Kind = typename Rule<T>::Kind;
  if constexpr (std::is_integral_v<T>) {
    if (std::cmp_greater(t, std::numeric_limits<T>::max())) return {Kind::none, {}};
    if (std::cmp_less_equal(t, std::numeric_limits<T>::min())) return {Kind::all, {}};
    return {Kind::at_least, static_cast<T>(t)};
  } else {
    T value = static_cast<T>(t);
    // A value that was rounded up beyond the range of Whole is not below t.
    const bool above = value >= std::ldexp(T{1}, std::numeric_limits<Whole>::digits);
    if (!above && static_cast<Whole>(value) < t) value = std::nextafter(value, std::numeric_limits<T>::infinity());
    return {Kind::at_least, value};
  }
}

template <class T>
Rule<T> equal_to(std::int64_t label) {
  using Kind = typename Rule<T>::Kind;
  if constexpr (std::is_integral_v<T>) {
    if (!std::in_range<T>(label)) return {Kind::none, {}};
    return {Kind::equal, static_cast<T>(label)};
  } else {
    const T value = static_cast<T>(label);
    if (!(std::abs(value) < T(0x1p63)) || static_cast<std::int64_t>(value) != label) return {Kind::none, {}};
    return {Kind::equal, value};
  }
}

// The range of the values, and whether there are at most two.
template <class T>
struct Values {
  T least{}, largest{};
  bool any = false;

  explicit Values() = default;
  /// `enough`: the range does not matter when there are more than two values.
  explicit Values(const shape::Samples<T>& samples, bool enough = false) {
    const auto [far, middle, near] = samples.order();
    const auto& dims = samples.grid().dims;
    std::array<std::int64_t, 3> at{};
    for (at[far] = 0; at[far] < dims[far]; ++at[far])
      for (at[middle] = 0; at[middle] < dims[middle] && !(enough && !at_most_two()); ++at[middle])
        for (at[near] = 0; at[near] < dims[near]; ++at[near]) add(samples.at(at[0], at[1], at[2]));
  }
  void add(T v) {
    if (v != v) {
      not_a_number = true;
      return;
    }
    if (!any) least = largest = v;
    any = true;
    if (v == least || v == largest) return;
    if (least != largest) third = true;
    if (v < least) least = v;
    if (v > largest) largest = v;
  }
  void add_all(const std::vector<T>& samples) {
    constexpr std::size_t kTogether = 64;
    for (std::size_t i = 0; i < samples.size();) {
      const std::size_t end = std::min(samples.size(), i + kTogether);
      std::uint8_t other = !any;
      for (std::size_t j = i; j < end; ++j)
        other |= static_cast<std::uint8_t>(int{samples[j] != least} & int{samples[j] != largest});
      if (other == 0) i = end;
      for (; i < end; ++i) add(samples[i]);
    }
  }
  bool at_most_two() const { return !third && !(not_a_number && least != largest); }
  std::string text() const {
    if (!any) return "it has no values but NaN";
    return fmt::format("its values range from {} to {}", +least, +largest);
  }

 private:
  bool not_a_number = false, third = false;
};

template <class T>
Rule<T> rule_of(const Threshold& threshold) {
  return std::visit([](auto t) { return at_least<T>(t); }, threshold);
}

template <class T>
[[noreturn]] void refuse_many_values(const Values<T>& values) {
  throw Error(ErrorCode::usage,
              fmt::format("the image has more than two values, so it is not clear what the shape is ({}); give "
                          "a threshold T (value >= T) or a label K (value = K)",
                          values.text()),
              "threshold");
}

// Without threshold and label the image must have at most two values: to be checked by the caller.
template <class T>
Rule<T> rule_for(const ForegroundOptions& options) {
  if (options.threshold) return rule_of<T>(*options.threshold);
  if (options.label) return equal_to<T>(*options.label);
  return {Rule<T>::Kind::non_zero, {}};
}

// How far samples are on the side of the foreground of a threshold, exact for every type. Between whole numbers and a
// whole threshold the surface is half way to the next lower value.
template <class T>
class Height {
 public:
  explicit Height(const ForegroundOptions& options) : sign_(options.invert ? -1 : 1) {
    if (const Rule<T> rule = rule_for<T>(options); rule.kind == Rule<T>::Kind::at_least) least_ = rule.value;
    const double* t = std::get_if<double>(&*options.threshold);
    if constexpr (std::is_integral_v<T>)
      below_ = t && *t != std::floor(*t) ? std::ceil(*t) - *t : 0.5;
    else
      level_ = std::visit([](auto whole) { return static_cast<double>(whole); }, *options.threshold);
  }
  double operator()(T sample) const {
    if constexpr (std::is_integral_v<T>) {
      using Distance = std::make_unsigned_t<T>;
      const auto far = [](T a, T b) {
        return static_cast<double>(static_cast<Distance>(static_cast<Distance>(a) - static_cast<Distance>(b)));
      };
      return sign_ * (sample >= least_ ? far(sample, least_) + below_ : below_ - far(least_, sample));
    } else {
      return sign_ * (static_cast<double>(sample) - level_);
    }
  }

 private:
  double sign_, below_ = 0, level_ = 0;
  T least_{};
};

template <class T>
class HeightInImage : public shape::SignedSamples {
 public:
  HeightInImage(const shape::Samples<T>& samples, const ForegroundOptions& options)
      : samples_(samples), height_(options) {}
  double at(std::int64_t x, std::int64_t y, std::int64_t z) const override { return height_(samples_.at(x, y, z)); }

 private:
  const shape::Samples<T>& samples_;
  Height<T> height_;
};

// Of the last two slices of a stream.
template <class T>
class HeightInSlices : public shape::SignedSamples {
 public:
  HeightInSlices(const ForegroundOptions& options, const std::array<std::vector<T>, 2>& slices, std::int64_t width)
      : slices_(slices), width_(width), height_(options) {}
  double at(std::int64_t x, std::int64_t y, std::int64_t z) const override {
    return height_(slices_[static_cast<std::size_t>(z & 1)][static_cast<std::size_t>(x + width_ * y)]);
  }

 private:
  const std::array<std::vector<T>, 2>& slices_;
  std::int64_t width_;
  Height<T> height_;
};

std::string describe(const ForegroundOptions& options) {
  std::string text = options.threshold ? std::visit([](auto t) { return fmt::format("a value of at least {}", t); },
                                                    *options.threshold)
                     : options.label   ? fmt::format("the value {}", *options.label)
                                       : std::string("a value other than 0");
  return options.invert ? "anything but " + text + " (inverted)" : text;
}

template <class T>
[[noreturn]] void refuse_nothing(const ForegroundOptions& options, const Values<T>& values, const Grid& grid) {
  throw Error(ErrorCode::input,
              fmt::format("no {} of the image has {}: {}; give another threshold or label", base::cell_name(grid),
                          describe(options), values.text()),
              "threshold");
}

// The runs of one scanline; `inside(x)` says what is foreground.
template <class Inside>
void append_runs(VoxelShape& shape, std::vector<Run>& runs, const Inside& inside) {
  const auto nx = static_cast<std::int32_t>(shape.grid().dims[0]);
  runs.clear();
  for (std::int32_t x = 0; x < nx;) {
    while (x < nx && !inside(x)) ++x;
    const std::int32_t begin = x;
    while (x < nx && inside(x)) ++x;
    if (begin < x) runs.push_back({begin, x});
  }
  shape.append_row(runs);
}

/// Samples that are looked at together where most of them are as the one before, as in masks and on dark ground: a few
/// instructions for all of them.
constexpr std::int32_t kStretch = 64;

/// The first sample from `x` on which is inside where `state` says outside, or the other way round.
template <class T, class Inside>
std::int32_t first_other(const T* row, std::int32_t x, std::int32_t nx, bool state, const Inside& inside) {
  for (; nx - x >= kStretch; x += kStretch) {
    std::uint8_t other = 0;
    for (std::int32_t i = 0; i < kStretch; ++i) other |= static_cast<std::uint8_t>(inside(row[x + i]) != state);
    if (other != 0) break;
  }
  while (x < nx && inside(row[x]) == state) ++x;
  return x;
}

/// The runs of a scanline whose samples follow each other in memory.
template <class T>
void append_runs_of(VoxelShape& shape, std::vector<Run>& runs, const T* row, const Rule<T>& rule, bool invert) {
  const auto nx = static_cast<std::int32_t>(shape.grid().dims[0]);
  const T value = rule.value;
  const auto append = [&](const auto& inside) {
    runs.clear();
    for (std::int32_t x = 0;;) {
      const std::int32_t begin = first_other(row, x, nx, invert, inside);
      if (begin == nx) break;
      x = first_other(row, begin, nx, !invert, inside);
      runs.push_back({begin, x});
    }
    shape.append_row(runs);
  };
  switch (rule.kind) {
    case Rule<T>::Kind::all:
      return append([](T) { return true; });
    case Rule<T>::Kind::at_least:
      return append([value](T sample) { return sample >= value; });
    case Rule<T>::Kind::equal:
      return append([value](T sample) { return sample == value; });
    case Rule<T>::Kind::non_zero:
      return append([](T sample) { return (sample < T{}) | (sample > T{}); });
    default:
      return append([](T) { return false; });
  }
}

template <class T>
VoxelShape scan_along_x(const shape::Samples<T>& samples, const Rule<T>& rule, bool invert, Context* context) {
  const auto& dims = samples.grid().dims;
  VoxelShape shape(samples.grid());
  std::vector<Run> runs;
  for (std::int64_t z = 0; z < dims[2]; ++z) {
    checkpoint(context, "foreground", static_cast<double>(z) / static_cast<double>(dims[2]));
    for (std::int64_t y = 0; y < dims[1]; ++y)
      append_runs(shape, runs, [&](std::int32_t x) { return rule(samples.at(x, y, z)) != invert; });
  }
  return shape;
}

// Where x is not the closest axis in memory, 64 slices are read together, each in the order of memory, into one bit
// per voxel: cache lines are read once.
template <class T>
VoxelShape scan_slabs(const shape::Samples<T>& samples, const Rule<T>& rule, bool invert, Context* context) {
  const auto& dims = samples.grid().dims;
  VoxelShape shape(samples.grid());
  std::vector<Run> runs;
  const auto nx = static_cast<std::size_t>(dims[0]);
  std::vector<std::uint64_t> slab(nx * static_cast<std::size_t>(dims[1]));
  const auto [far, middle, near] = samples.order();
  for (std::int64_t base = 0; base < dims[2]; base += 64) {
    checkpoint(context, "foreground", static_cast<double>(base) / static_cast<double>(dims[2]));
    const std::array<std::int64_t, 3> count{dims[0], dims[1], std::min<std::int64_t>(64, dims[2] - base)};
    std::fill(slab.begin(), slab.end(), 0);
    std::array<std::int64_t, 3> at{};
    for (at[far] = 0; at[far] < count[far]; ++at[far])
      for (at[middle] = 0; at[middle] < count[middle]; ++at[middle])
        for (at[near] = 0; at[near] < count[near]; ++at[near])
          if (rule(samples.at(at[0], at[1], base + at[2])) != invert)
            slab[static_cast<std::size_t>(at[0]) + nx * static_cast<std::size_t>(at[1])] |= std::uint64_t{1} << at[2];
    for (std::int64_t z = 0; z < count[2]; ++z)
      for (std::int64_t y = 0; y < dims[1]; ++y) {
        const std::uint64_t* row = slab.data() + nx * static_cast<std::size_t>(y);
        append_runs(shape, runs, [&](std::int32_t x) { return (row[x] >> z & 1) != 0; });
      }
  }
  return shape;
}

template <class T>
VoxelShape scan(const shape::Samples<T>& samples, const Rule<T>& rule, bool invert, Context* context) {
  const bool along_x = samples.order()[2] == 0;
  VoxelShape shape =
      along_x ? scan_along_x(samples, rule, invert, context) : scan_slabs(samples, rule, invert, context);
  checkpoint(context, "foreground", 1);
  return shape;
}

/// What is connected to voxels of at least the upper threshold.
VoxelShape strong_parts(const VoxelShape& shape, const VoxelShape& seeds, const ForegroundOptions& options,
                        ForegroundReport& report, Context* context) {
  if (seeds.empty())
    throw Error(ErrorCode::input,
                fmt::format("no {} of the image has a value of at least {}, the upper of the two thresholds; give a "
                            "lower one",
                            base::cell_name(shape.grid()),
                            std::visit([](auto t) { return fmt::format("{}", t); }, *options.seed_threshold)),
                "threshold");
  return shape::with_seeds(shape, seeds, options.connectivity, report, context);
}

bool adds_voxels(const ForegroundOptions& options) { return options.close > 0 || options.connectivity == 26; }

VoxelShape with_additions(VoxelShape shape, const ForegroundOptions& options, const shape::SignedSamples* values,
                          ForegroundReport& report, Context* context) {
  if (options.close > 0) shape = shape::closed(shape, options.close, report, context);
  if (options.connectivity == 26) shape = shape::joined(shape, values, report, context);
  return shape;
}

template <class T>
VoxelShape foreground_of(const shape::Samples<T>& samples, const ForegroundOptions& options, ForegroundReport& report,
                         Context* context, std::optional<TriangleMesh>* isosurface) {
  if (!options.threshold && !options.label)
    if (const Values<T> values(samples); !values.at_most_two()) refuse_many_values(values);
  VoxelShape shape = scan(samples, rule_for<T>(options), options.invert, context);
  if (shape.empty()) refuse_nothing(options, Values<T>(samples), shape.grid());
  std::optional<HeightInImage<T>> height;
  if (options.threshold) height.emplace(samples, options);
  const bool surface = isosurface && height && !Values<T>(samples, true).at_most_two();
  // As of a stream, where the surface is there before parts are dropped.
  if (surface && !adds_voxels(options)) *isosurface = shape::all_layers(shape, &*height, context);
  if (options.seed_threshold)
    shape = strong_parts(shape, scan(samples, rule_of<T>(*options.seed_threshold), false, context), options, report,
                         context);
  shape = with_additions(std::move(shape), options, height ? &*height : nullptr, report, context);
  if (surface && adds_voxels(options)) *isosurface = shape::all_layers(shape, &*height, context);
  return shape;
}

/// The grid of an image, with a spacing of integer proportion where that is near.
Grid grid_of_shape(const Grid& image, Context* context) {
  Grid grid = image;
  double moved = 0;
  grid.spacing = nearest_integer_spacing(image, &moved);
  if (grid.is_plane()) grid.make_plane();
  if (moved > 0)
    note(context,
         fmt::format("the spacing {} is taken as {}, which has an integer proportion; no {} moves by more than "
                     "{:.2g} of its size",
                     base::axes_text(image, image.spacing), base::axes_text(grid, grid.spacing, "{:.9g}"),
                     base::cell_name(grid), moved));
  return grid;
}

/// The samples of a stream, all of them.
template <class T>
std::vector<T> all_samples(const SliceStream& image, Context* context) {
  const auto& dims = image.grid.dims;
  const auto slice = static_cast<std::size_t>(dims[0] * dims[1]);
  std::vector<T> samples(slice * static_cast<std::size_t>(dims[2]));
  for (std::int64_t z = 0; z < dims[2]; ++z) {
    checkpoint(context, "read", static_cast<double>(z) / static_cast<double>(dims[2]));
    image.next(std::as_writable_bytes(std::span(samples).subspan(slice * static_cast<std::size_t>(z), slice)));
  }
  checkpoint(context, "read", 1);
  return samples;
}

template <class T>
VoxelShape foreground_of(const SliceStream& image, const ForegroundOptions& options, ForegroundReport& report,
                         Context* context, std::optional<TriangleMesh>* isosurface) {
  if (adds_voxels(options) && options.threshold) {  // which voxels are added depends on values
    const std::vector<T> all = all_samples<T>(image, context);
    constexpr auto size = static_cast<std::int64_t>(sizeof(T));
    const ImageView view{grid_of_shape(image.grid, context),
                         image.type,
                         all.data(),
                         {size, size * image.grid.dims[0], size * image.grid.dims[0] * image.grid.dims[1]}};
    return foreground_of(shape::Samples<T>(view), options, report, context, isosurface);
  }
  const Rule<T> rule = rule_for<T>(options);
  const bool chosen = options.threshold || options.label;
  const auto& dims = image.grid.dims;
  const auto nx = static_cast<std::size_t>(dims[0]);
  const bool surface = isosurface && options.threshold;
  std::array<std::vector<T>, 2> slices;
  for (std::size_t i = 0; i < (surface ? 2 : 1); ++i) slices[i].resize(nx * static_cast<std::size_t>(dims[1]));
  VoxelShape shape(grid_of_shape(image.grid, context)), seeds(shape.grid());
  const bool seeded = options.seed_threshold.has_value();
  const Rule<T> seed_rule = seeded ? rule_of<T>(*options.seed_threshold) : Rule<T>{};
  std::vector<Run> runs;
  Values<T> values;
  std::optional<HeightInSlices<T>> height;
  std::optional<shape::SurfaceLayers> layers;
  if (surface) layers.emplace(shape, &height.emplace(options, slices, dims[0]), -1);
  for (std::int64_t z = 0; z < dims[2]; ++z) {
    checkpoint(context, "read", static_cast<double>(z) / static_cast<double>(dims[2]));
    auto& slice = slices[layers ? z & 1 : 0];
    image.next(std::as_writable_bytes(std::span(slice)));
    // With a threshold or label the values are needed only for the error that nothing is foreground, and to know
    // whether there are more than two.
    if (!chosen || shape.empty() || (layers && values.at_most_two())) values.add_all(slice);
    for (std::int64_t y = 0; y < dims[1]; ++y) {
      const T* row = slice.data() + nx * static_cast<std::size_t>(y);
      append_runs_of(shape, runs, row, rule, options.invert);
      if (seeded) append_runs_of(seeds, runs, row, seed_rule, false);
    }
    if (layers) layers->add_layer();
  }
  if (layers) layers->add_layer();
  checkpoint(context, "read", 1);
  if (!chosen && !values.at_most_two()) refuse_many_values(values);
  if (shape.empty()) refuse_nothing(options, values, shape.grid());
  if (layers && !values.at_most_two()) *isosurface = std::move(layers->mesh);
  if (seeded) shape = strong_parts(shape, seeds, options, report, context);
  return with_additions(std::move(shape), options, nullptr, report, context);
}

double as_double(const Threshold& threshold) {
  return std::visit([](auto t) { return static_cast<double>(t); }, threshold);
}

void check(const ForegroundOptions& options) {
  if (options.threshold && options.label)
    throw Error(ErrorCode::usage, "a threshold and a label cannot be combined; give one of them");
  for (const auto* threshold : {&options.threshold, &options.seed_threshold})
    if (*threshold && std::isnan(as_double(**threshold)))
      throw Error(ErrorCode::usage, "the threshold is not a number", "threshold");
  if (options.seed_threshold) {
    if (!options.threshold || as_double(*options.seed_threshold) < as_double(*options.threshold))
      throw Error(ErrorCode::usage, "of two thresholds the lower one is given first, then one that is no less",
                  "threshold");
    if (options.invert)
      throw Error(ErrorCode::usage, "two thresholds are for bright shapes, which are not inverted; give one threshold",
                  "invert");
  }
  if (options.close < 0 || options.close > kLargestClosing)
    throw Error(
        ErrorCode::usage,
        fmt::format("the radius {} of closing is not a whole number from 0 to {}", options.close, kLargestClosing),
        "close");
  if (options.connectivity != 6 && options.connectivity != 26)
    throw Error(ErrorCode::usage, fmt::format("the connectivity {} is neither 6 nor 26", options.connectivity),
                "connectivity");
}

VoxelShape cleaned(const VoxelShape& shape, const ForegroundOptions& options, ForegroundReport& report,
                   Context* context, std::optional<TriangleMesh>* isosurface) {
  ForegroundReport changed;
  VoxelShape result = clean(shape, options, &changed, context);
  report.voxels_before = changed.voxels_before;
  report.components_removed = changed.components_removed;
  report.voxels_removed = changed.voxels_removed;
  report.cavities_filled = changed.cavities_filled;
  report.voxels_filled = changed.voxels_filled;
  if (isosurface && *isosurface && changed.voxels_removed + changed.voxels_filled + report.weak_dropped > 0)
    restrict_surface(**isosurface, result);
  return result;
}

}  // namespace

VoxelShape foreground(const ImageView& image, const ForegroundOptions& options, ForegroundReport* report,
                      Context* context, std::optional<TriangleMesh>* isosurface) {
  check(options);
  if (isosurface) isosurface->reset();
  ImageView rounded = image;
  rounded.grid = grid_of_shape(image.grid, context);
  ForegroundReport changed;
  const VoxelShape shape = shape::with_samples(
      rounded, [&](const auto& samples) { return foreground_of(samples, options, changed, context, isosurface); });
  VoxelShape result = cleaned(shape, options, changed, context, isosurface);
  if (report) *report = changed;
  return result;
}

VoxelShape foreground(const SliceStream& image, const ForegroundOptions& options, ForegroundReport* report,
                      Context* context, std::optional<TriangleMesh>* isosurface) {
  check(options);
  if (isosurface) isosurface->reset();
  const ImageView type_only{image.grid, image.type, nullptr, {0, 0, 0}};
  ForegroundReport changed;
  const VoxelShape shape = shape::with_samples(type_only, [&]<class T>(const shape::Samples<T>&) {
    return foreground_of<T>(image, options, changed, context, isosurface);
  });
  VoxelShape result = cleaned(shape, options, changed, context, isosurface);
  if (report) *report = changed;
  return result;
}

VoxelShape foreground(const Volume& volume, const ForegroundOptions& options, ForegroundReport* report,
                      Context* context, std::optional<TriangleMesh>* isosurface) {
  return foreground(view_of(volume), options, report, context, isosurface);
}

}  // namespace quench
