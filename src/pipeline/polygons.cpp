// SPDX-License-Identifier: Apache-2.0
#include "quench/polygons.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <utility>
#include <vector>

#include "base/parallel.h"
#include "base/text.h"
#include "pipeline/finished_shape.h"
#include "pipeline/parameters.h"
#include "polygons/ring_nesting.h"
#include "quench/error.h"
#include "quench/io.h"
#include "quench/pipeline.h"

namespace quench::pipeline {
namespace {

PolygonFill fill_of(const PolygonFeature& feature, const ShapeOptions& options) {
  if (!options.fill) return feature.fill;
  if (*options.fill == FillRule::evenodd) return PolygonFill::evenodd;
  if (*options.fill == FillRule::nonzero) return PolygonFill::nonzero;
  throw Error(
      ErrorCode::usage,
      fmt::format("fill '{}' is for meshes; polygons are filled 'evenodd' or 'nonzero'", fill_name(*options.fill)),
      "fill");
}

}  // namespace

namespace {

// Narrow inlets close where they are thinner than a pixel, and leave holes at their ends that the polygon has not.
void fill_false_holes(VoxelShape& shape, std::int64_t wanted, Context* context) {
  const std::vector<std::int64_t> sizes = cavity_sizes(shape, context);
  const auto keep = static_cast<std::size_t>(wanted);
  if (sizes.size() <= keep || (keep > 0 && sizes[keep - 1] == sizes[keep])) return;
  ForegroundOptions fill;
  fill.min_cavity = sizes[keep] + 1;
  ForegroundReport report;
  shape = clean(shape, fill, &report, context);
  note(context, fmt::format("{} of {} that the polygon has not, where an inlet is thinner than a pixel, {} filled",
                            base::counted(report.cavities_filled, "hole"), base::counted(report.voxels_filled, "pixel"),
                            report.cavities_filled == 1 ? "is" : "are"));
}

// Where the polygon is in one piece, so is its shape: what breaks off where it is thinner than a pixel, as at sharp
// tips, is left out.
VoxelShape digitized(const Polygons& polygons, const DigitizeOptions& how, Context* context) {
  Context quiet;  // what it has to say of topology is said below
  quiet.progress = [&](std::string_view stage, double fraction) { checkpoint(context, stage, fraction); };
  if (context) quiet.memory_limit = context->memory_limit;
  VoxelShape shape = digitize(polygons, how, &quiet);
  const auto region = polygons::region_topology(polygons, how.fill);
  if (region && region->components == 1) {
    ForegroundOptions keep;
    keep.largest_component = true;
    ForegroundReport report;
    shape = clean(shape, keep, &report, context);
    if (report.components_removed > 0)
      note(context,
           fmt::format("the polygon is one part: {} with {} ({} of it) that broke off where it is thinner than "
                       "a pixel {} left out; a higher resolution keeps them",
                       base::counted(report.components_removed, "part"), base::counted(report.voxels_removed, "pixel"),
                       percent_text(report.voxels_removed, report.voxels_before),
                       report.components_removed == 1 ? "is" : "are"));
  }
  if (region && region->components == 1) fill_false_holes(shape, region->holes, context);
  polygons::note_other_topology(polygons, shape, how.fill, context);
  return shape;
}

}  // namespace

LoadedShape shape_of(PolygonFeature&& feature, const ShapeOptions& options, Context* context) {
  if (options.surface.value_or(SurfaceKind::voxels) != SurfaceKind::voxels)
    throw Error(ErrorCode::usage,
                fmt::format("the surface cannot be '{}': results of the plane are those of its pixels; use 'voxels'",
                            name_of(*options.surface)),
                "surface");
  LoadedShape loaded;
  DigitizeOptions how;
  how.pixel = options.pixel;
  if (options.resolution == kAutomaticResolution)
    throw Error(ErrorCode::usage, "resolution 'auto' is for meshes; give polygons a number of pixels", "resolution");
  how.resolution = options.resolution;
  how.fill = fill_of(feature, options);
  loaded.shape = digitized(feature.polygons, how, context);
  loaded.image = loaded.shape.grid();
  loaded.coordinates.y_down = feature.y_down;
  checkpoint(context, "voxelize", 1);
  if (how.pixel)
    loaded.parameters = with_parameters(loaded.parameters, {{"pixel", *how.pixel}});
  else
    loaded.parameters =
        with_parameters(loaded.parameters, {{"resolution", how.resolution.value_or(kDefaultResolution)}});
  loaded.parameters = with_parameters(loaded.parameters,
                                      {{"fill", std::string(how.fill == PolygonFill::evenodd ? "evenodd" : "nonzero")},
                                       {"feature", static_cast<std::int64_t>(feature.number)}});
  loaded.polygon = std::move(feature);
  return finished(std::move(loaded), options, context);
}

namespace {

// Ends the reading of a file; not an error.
struct Enough {};

}  // namespace

PolygonFeature feature_of(const std::filesystem::path& file, const std::optional<std::uint64_t>& number,
                          Context* context) {
  std::optional<PolygonFeature> found;
  std::optional<Error> fault;
  bool more = false;
  const auto is_wanted = [&](std::uint64_t n) { return !number || n == *number; };
  std::uint64_t features = 0;
  try {
    features = io::for_each_feature(
        file,
        [&](PolygonFeature&& feature) {
          if (!is_wanted(feature.number)) return;
          if (found) {
            more = true;
            throw Enough();
          }
          found = std::move(feature);
          if (number) throw Enough();
        },
        [&](PolygonFeature&& feature, const Error& error) {
          if (is_wanted(feature.number) && !fault) fault = error;
        },
        context);
  } catch (const Enough&) {
  }
  if (more)
    throw Error(ErrorCode::usage,
                fmt::format("'{}' holds several polygons, and one is wanted here; give the number of its feature, from "
                            "0, or take all of them with 'run'",
                            file.string()),
                "feature");
  if (found) return std::move(*found);
  if (fault) throw *fault;
  throw Error(ErrorCode::input,
              number ? fmt::format("'{}' has no feature {}: it holds {}, from 0", file.string(), *number, features)
                     : fmt::format("'{}' holds no polygons", file.string()));
}

bool holds_one_feature(const std::filesystem::path& file) {
  std::uint64_t features = 0;
  const auto count = [&] {
    if (++features > 1) throw Enough();
  };
  try {
    io::for_each_feature(
        file, [&](PolygonFeature&&) { count(); }, [&](PolygonFeature&&, const Error&) { count(); });
  } catch (const Enough&) {
    return false;
  } catch (const Error&) {  // told when it is read for good
    return features <= 1;
  }
  return true;
}

namespace {

// Features are worked on in batches, in parallel; a batch has at most so many features, points and, by the length of
// their outlines, boundary vertices, so that memory is bounded whatever the file.
constexpr std::size_t kBatchFeatures = 256, kBatchPoints = std::size_t{1} << 20;
constexpr double kBatchSites = 0x1p18;

// About how many boundary vertices a polygon will have.
double expected_sites(const Polygons& polygons, const ShapeOptions& options) {
  double length = 0;
  Vec2 low = Vec2::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const auto& ring : polygons.rings)
    for (std::size_t i = 0; i < ring.size(); ++i) {
      length += (ring[i] - ring[i == 0 ? ring.size() - 1 : i - 1]).cwiseAbs().sum();
      low = low.cwiseMin(ring[i]);
      high = high.cwiseMax(ring[i]);
    }
  const double side = (high - low).maxCoeff(),
               pixel =
                   options.pixel.value_or(side / static_cast<double>(options.resolution.value_or(kDefaultResolution)));
  const double sites = length / pixel * options.subdivide;
  return std::isfinite(sites) ? sites : 0;  // refused later
}

struct Pending {
  PolygonFeature feature;
  std::optional<Error> fault;
};

FeatureRun run_of(Pending&& pending, const ShapeOptions& shape_options, const RunOptions& options, Context* outer) {
  FeatureRun run;
  run.number = pending.feature.number;
  run.id = pending.feature.id;
  run.properties = pending.feature.properties;
  if (pending.fault) {
    run.failure = pending.fault->what();
    return run;
  }
  Context context;
  context.note = [&](const std::string& sentence) { run.notes.push_back(sentence); };
  if (outer) context.memory_limit = outer->memory_limit;
  try {
    run.shape = shape_of(std::move(pending.feature), shape_options, &context);
    run.result = pipeline::run(*run.shape, options, &context);
    run.result->core.axis = {};  // most of the memory; the skeleton is what is wanted
    run.result->axis.file = {};
  } catch (const std::bad_alloc&) {
    run.failure = "there is not enough memory; use a lower resolution";
    run.shape.reset();
    run.result.reset();
  } catch (const Error& error) {
    if (error.code() == ErrorCode::usage || error.code() == ErrorCode::cancelled) throw;
    run.failure = error.what();
    run.shape.reset();
    run.result.reset();
  }
  return run;
}

}  // namespace

void run_features(const std::filesystem::path& file, const ShapeOptions& shape, const RunOptions& options,
                  const std::function<void(FeatureRun&&)>& take, Context* context) {
  // Reading takes a hundredth of the time of the runs; their number is what progress refers to.
  const auto pass = [&](PolygonFeature&&) { checkpoint(context, "read", 0); };
  const auto all = static_cast<double>(io::for_each_feature(
      file, pass, [](PolygonFeature&&, const Error&) {}, nullptr));
  checkpoint(context, "read", 1);
  std::vector<Pending> batch;
  std::size_t points = 0;
  double sites = 0, done = 0;
  const auto work = [&] {
    if (batch.empty()) return;
    std::vector<FeatureRun> runs(batch.size());
    const double after = done + static_cast<double>(batch.size());
    base::in_arena(context, [&] {
      base::for_chunks(batch.size(), context, "features", done / all, after / all,
                       [&](std::size_t i) { runs[i] = run_of(std::move(batch[i]), shape, options, context); });
    });
    done = after;
    for (FeatureRun& run : runs) take(std::move(run));
    batch.clear();
    points = 0;
    sites = 0;
  };
  const auto add = [&](Pending&& pending) {
    const double more = expected_sites(pending.feature.polygons, shape);
    if (!batch.empty() && sites + more > kBatchSites) work();
    for (const auto& ring : pending.feature.polygons.rings) points += ring.size();
    sites += more;
    batch.push_back(std::move(pending));
    if (batch.size() >= kBatchFeatures || points >= kBatchPoints) work();
  };
  io::for_each_feature(
      file,
      [&](PolygonFeature&& feature) {
        add({std::move(feature), {}});
      },
      [&](PolygonFeature&& feature, const Error& error) {
        add({std::move(feature), error});
      },
      context);
  work();
}

}  // namespace quench::pipeline
