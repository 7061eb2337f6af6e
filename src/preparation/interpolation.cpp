// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <functional>
#include <span>

#include "base/parallel.h"
#include "preparation/filters.h"

namespace quench::preparation {
namespace {

/// Along one axis, between which two samples a new one lies.
struct Between {
  std::int64_t low = 0;
  double part = 0;  ///< of the way to the next one
};

std::array<std::vector<Between>, 3> places_of(const Grid& from, const Grid& to) {
  std::array<std::vector<Between>, 3> places;
  for (std::size_t a = 0; a < 3; ++a) {
    const bool same = to.dims[a] == from.dims[a];
    const double step =
        same ? 1 : to.spacing[static_cast<Eigen::Index>(a)] / from.spacing[static_cast<Eigen::Index>(a)];
    for (std::int64_t i = 0; i < to.dims[a]; ++i) {
      const double at =
          std::clamp((static_cast<double>(i) + 0.5) * step - 0.5, 0.0, static_cast<double>(from.dims[a] - 1));
      const auto low = static_cast<std::int64_t>(at);
      places[a].push_back({low, at - static_cast<double>(low)});
    }
  }
  return places;
}

/// Takes the results from `first` on. Not a template parameter: there are many types of samples.
using StoreResults = std::function<void(std::size_t first, std::span<const double> results)>;

/// Linear along the axes other than `last`, then mix(low, high, part) along that one; samples of no weight do not
/// count.
template <class Value, class Mix>
void resample(const Grid& from, const Grid& to, std::size_t last, const Value& value, const Mix& mix,
              const StoreResults& store, Context* context) {
  const auto places = places_of(from, to);
  const std::array<std::int64_t, 3> stride{1, from.dims[0], from.dims[0] * from.dims[1]};
  const std::size_t u = last == 0 ? 1 : 0, v = last == 2 ? 1 : 2;
  base::in_arena(context, [&] {
    base::for_chunks(static_cast<std::size_t>(to.dims[2]), context, "interpolation", 0, 1, [&](std::size_t z) {
      std::size_t out = z * static_cast<std::size_t>(to.dims[0] * to.dims[1]);
      std::array<Between, 3> at;
      at[2] = places[2][z];
      const auto in_slice = [&](std::int64_t slice) {
        double sum = 0;
        for (const bool j : {false, true})
          for (const bool i : {false, true}) {
            const double weight = (i ? at[u].part : 1 - at[u].part) * (j ? at[v].part : 1 - at[v].part);
            if (weight > 0)
              sum += weight * value(static_cast<std::size_t>(stride[last] * slice + stride[u] * (at[u].low + i) +
                                                             stride[v] * (at[v].low + j)));
          }
        return sum;
      };
      std::vector<double> row(places[0].size());
      for (const Between& y : places[1]) {
        at[1] = y;
        for (std::size_t x = 0; x < row.size(); ++x) {
          at[0] = places[0][x];
          const double low = in_slice(at[last].low), part = at[last].part;
          row[x] = part > 0 ? mix(low, in_slice(at[last].low + 1), part) : low;
        }
        store(out, row);
        out += row.size();
      }
    });
  });
}

double linear(double low, double high, double part) { return low + (high - low) * part; }

/// Squares of the distances to the nearest of samples that are 0, of samples `step` apart, infinite elsewhere; the
/// lower envelope of parabolas (Felzenszwalb and Huttenlocher 2012, Theory of Computing 8).
void transform(std::vector<double>& f, double step, std::vector<std::size_t>& site, std::vector<double>& from,
               std::vector<double>& result) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  site.clear();
  from.clear();
  const auto at = [&](std::size_t i) { return static_cast<double>(i) * step; };
  for (std::size_t i = 0; i < f.size(); ++i) {
    if (f[i] == kFar) continue;
    double begin = -kFar;
    while (!site.empty()) {
      const std::size_t j = site.back();
      begin = (f[i] + at(i) * at(i) - f[j] - at(j) * at(j)) / (2 * (at(i) - at(j)));
      if (begin > from.back()) break;
      site.pop_back();
      from.pop_back();
      begin = -kFar;
    }
    site.push_back(i);
    from.push_back(begin);
  }
  if (site.empty()) return;
  result.resize(f.size());
  for (std::size_t i = 0, k = 0; i < f.size(); ++i) {
    while (k + 1 < site.size() && from[k + 1] < at(i)) ++k;
    const double away = at(i) - at(site[k]);
    result[i] = away * away + f[site[k]];
  }
  f.swap(result);
}

/// Signed distances in a slice to the nearest pixel of the other side, above 0 inside; infinite where there is none.
class SliceDistances {
 public:
  SliceDistances(std::array<std::int64_t, 2> dims, std::array<double, 2> steps) : dims_(dims), steps_(steps) {}

  /// inside(i, j) says what is inside, set(i, j, distance) takes the results.
  template <class Inside, class Set>
  void find(const Inside& inside, const Set& set) {
    for (const bool side : {true, false}) {
      const std::vector<double> square = squares([&](std::int64_t i, std::int64_t j) { return inside(i, j) != side; });
      for (std::int64_t j = 0; j < dims_[1]; ++j)
        for (std::int64_t i = 0; i < dims_[0]; ++i) {
          if (inside(i, j) != side) continue;
          const double distance = std::sqrt(square[static_cast<std::size_t>(i + dims_[0] * j)]);
          set(i, j, side ? distance : -distance);
        }
    }
  }

 private:
  /// To the nearest pixel that is a target.
  template <class Target>
  std::vector<double> squares(const Target& target) {
    const auto nx = static_cast<std::size_t>(dims_[0]), ny = static_cast<std::size_t>(dims_[1]);
    std::vector<double> all(nx * ny), line;
    for (std::size_t j = 0; j < ny; ++j) {
      line.resize(nx);
      for (std::size_t i = 0; i < nx; ++i)
        line[i] = target(static_cast<std::int64_t>(i), static_cast<std::int64_t>(j))
                      ? 0
                      : std::numeric_limits<double>::infinity();
      transform(line, steps_[0], site_, from_, result_);
      std::ranges::copy(line, all.begin() + static_cast<std::ptrdiff_t>(nx * j));
    }
    for (std::size_t i = 0; i < nx; ++i) {
      line.resize(ny);
      for (std::size_t j = 0; j < ny; ++j) line[j] = all[i + nx * j];
      transform(line, steps_[1], site_, from_, result_);
      for (std::size_t j = 0; j < ny; ++j) all[i + nx * j] = line[j];
    }
    return all;
  }

  std::array<std::int64_t, 2> dims_;
  std::array<double, 2> steps_;
  std::vector<std::size_t> site_;
  std::vector<double> from_, result_;
};

/// Between two signed distances; half way where one slice is all inside or all outside.
double between_slices(double low, double high, double part) {
  if (std::isfinite(low) && std::isfinite(high)) return linear(low, high, part);
  return part < 0.5 ? low : high;
}

/// The axis of the largest spacing, the last of equal ones.
std::size_t thick_axis(const Grid& grid) {
  std::size_t thick = 2;
  for (const std::size_t a : {1, 0})
    if (grid.spacing[static_cast<Eigen::Index>(a)] > grid.spacing[static_cast<Eigen::Index>(thick)]) thick = a;
  return thick;
}

/// In the slices along `thick`.
template <class T>
std::vector<float> signed_distances(const Grid& grid, std::size_t thick, const std::vector<T>& samples,
                                    Context* context) {
  const std::size_t u = thick == 0 ? 1 : 0, v = thick == 2 ? 1 : 2;
  const std::array<std::int64_t, 3> stride{1, grid.dims[0], grid.dims[0] * grid.dims[1]};
  const auto step = [&](std::size_t a) { return grid.spacing[static_cast<Eigen::Index>(a)]; };
  std::vector<float> distances(samples.size());
  base::in_arena(context, [&] {
    base::for_chunks(static_cast<std::size_t>(grid.dims[thick]), context, "interpolation", 0, 0, [&](std::size_t k) {
      const auto at = [&](std::int64_t i, std::int64_t j) {
        return static_cast<std::size_t>(static_cast<std::int64_t>(k) * stride[thick] + i * stride[u] + j * stride[v]);
      };
      SliceDistances({grid.dims[u], grid.dims[v]}, {step(u), step(v)})
          .find(
              [&](std::int64_t i, std::int64_t j) {
                const T sample = samples[at(i, j)];
                return sample != T{} && sample == sample;
              },
              [&](std::int64_t i, std::int64_t j, double d) { distances[at(i, j)] = static_cast<float>(d); });
    });
  });
  return distances;
}

std::size_t count_of(const Grid& grid) { return static_cast<std::size_t>(grid.dims[0] * grid.dims[1] * grid.dims[2]); }

}  // namespace

Grid cubes_of(const Grid& grid) {
  Grid cubes = grid;
  const double side = grid.spacing.minCoeff();
  constexpr double kEqual = 1e-6;  // of two spacings
  for (std::size_t a = 0; a < 3; ++a) {
    const double ratio = grid.spacing[static_cast<Eigen::Index>(a)] / side;
    if (ratio > 1 + kEqual)
      cubes.dims[a] = std::max<std::int64_t>(1, std::llround(static_cast<double>(grid.dims[a]) * ratio));
  }
  cubes.spacing = Vec3::Constant(side);
  cubes.origin = grid.world(Vec3::Zero()) + grid.direction * Vec3::Constant(side / 2);
  return cubes;
}

void interpolate(Volume& volume, bool mask, Context* context) {
  const Grid cubes = cubes_of(volume.grid);
  if (cubes.dims != volume.grid.dims) {
    std::visit(
        [&]<class T>(std::vector<T>& samples) {
          if (mask) {
            const std::size_t thick = thick_axis(volume.grid);
            const std::vector<float> distances = signed_distances(volume.grid, thick, samples, context);
            T inside = 1;
            for (const T sample : samples)
              if (sample != T{} && sample == sample) inside = sample;
            samples.assign(count_of(cubes), T{});
            resample(
                volume.grid, cubes, thick, [&](std::size_t i) { return static_cast<double>(distances[i]); },
                between_slices,
                [&](std::size_t first, std::span<const double> results) {
                  for (std::size_t i = 0; i < results.size(); ++i)
                    if (results[i] > 0) samples[first + i] = inside;
                },
                context);
            return;
          }
          const auto fill = [&]<class Out>(std::vector<Out>&& out) {
            resample(
                volume.grid, cubes, 2, [&](std::size_t i) { return static_cast<double>(samples[i]); }, linear,
                [&](std::size_t first, std::span<const double> results) {
                  for (std::size_t i = 0; i < results.size(); ++i) out[first + i] = as_sample<Out>(results[i]);
                },
                context);
            volume.samples = std::move(out);
          };
          if (!std::is_integral_v<T> || stays_whole(samples))
            fill(std::vector<T>(count_of(cubes)));
          else
            fill(std::vector<float>(count_of(cubes)));
        },
        volume.samples);
  }
  volume.grid = cubes;
}

}  // namespace quench::preparation
