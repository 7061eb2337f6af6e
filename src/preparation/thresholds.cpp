// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <functional>
#include <numeric>
#include <optional>
#include <span>

#include "base/parallel.h"
#include "preparation/classes.h"
#include "preparation/filters.h"
#include "quench/preparation.h"

namespace quench {
namespace {

using preparation::Classes;
using preparation::Range;
using Counts = std::vector<std::uint64_t>;

constexpr double kClasses = 4096;  // squares of differences, times samples, fit 64 bits
constexpr double kNoiseSteps = 3;  // what exceeds this many deviations of noise is no noise

constexpr auto kNoClass = static_cast<std::uint16_t>(-1);

/// Calls visit(low, high) for the classes of pairs of samples, in two lists, that are finite.
template <class Visit>
void for_pairs(const std::uint16_t* here, const std::uint16_t* there, std::size_t count, const Visit& visit) {
  for (std::size_t i = 0; i < count; ++i)
    if (here[i] != kNoClass && there[i] != kNoClass) visit(std::min(here[i], there[i]), std::max(here[i], there[i]));
}

/// Gives the classes of the samples from `first` on. Not a template parameter: there are many types of samples.
using ReadClasses = std::function<void(std::size_t first, std::span<std::uint16_t> to)>;

template <class T>
ReadClasses reader_of(const std::vector<T>& samples, const Classes<T>& classes) {
  return [&](std::size_t first, std::span<std::uint16_t> to) {
    for (std::size_t i = 0; i < to.size(); ++i) {
      const T sample = samples[first + i];
      to[i] = preparation::is_finite(sample) ? static_cast<std::uint16_t>(classes.of(sample)) : kNoClass;
    }
  };
}

/// Visits the pairs of neighbouring finite samples with the classes of both, along the axes of nearly the smallest
/// spacing (between thick slices differences are of other lengths), in parts on all threads, each with sums of its own;
/// returns their sum. Progress is from `begin` on, for one half.
template <class Visit>
Counts over_pairs(const Grid& grid, const ReadClasses& read, std::size_t sums, Context* context, double begin,
                  const Visit& visit) {
  constexpr double kNearly = 1.5;
  const auto used = [&](int axis) { return grid.spacing[axis] <= kNearly * grid.spacing.minCoeff(); };
  const auto nx = static_cast<std::size_t>(grid.dims[0]), ny = static_cast<std::size_t>(grid.dims[1]),
             nz = static_cast<std::size_t>(grid.dims[2]), slice = nx * ny;
  constexpr std::size_t kParts = 16;  // whole numbers: their sums do not depend on the parts
  const std::size_t parts = std::min(nz, kParts);
  std::vector<Counts> all(parts, Counts(sums));
  base::in_arena(context, [&] {
    base::for_chunks(parts, context, "thresholds", begin, begin + 0.5, [&](std::size_t part) {
      Counts& counts = all[part];
      const auto count = [&](std::size_t low, std::size_t high) { visit(counts, low, high); };
      std::vector<std::uint16_t> here(slice), above(slice);
      const auto [first, last] = base::part_of(nz, part, parts);
      for (std::size_t z = first; z < last; ++z) {
        if (z == first)
          read(z * slice, here);
        else
          here.swap(above);
        if (z + 1 < nz) read((z + 1) * slice, above);
        if (used(0))
          for (std::size_t y = 0; y < ny; ++y) for_pairs(&here[nx * y], &here[nx * y] + 1, nx - 1, count);
        if (used(1)) for_pairs(here.data(), here.data() + nx, slice - nx, count);
        if (used(2) && z + 1 < nz) for_pairs(here.data(), above.data(), slice, count);
      }
    });
  });
  for (std::size_t part = 1; part < parts; ++part)
    std::transform(all[0].begin(), all[0].end(), all[part].begin(), all[0].begin(), std::plus<>());
  return all[0];
}

/// The median of counted differences, interpolated within the class in which it lies; 0 counts for half a class.
double median_of(const Counts& differences) {
  const auto half = static_cast<double>(std::accumulate(differences.begin(), differences.end(), std::uint64_t{0})) / 2;
  double below = 0;
  for (std::size_t d = 0; d < differences.size(); ++d) {
    const auto here = static_cast<double>(differences[d]);
    if (here > 0 && below + here >= half) {
      const double part = (half - below) / here;
      return d == 0 ? part / 2 : static_cast<double>(d) - 0.5 + part;
    }
    below += here;
  }
  return 0;
}

/// The class whose lower end cuts most of the edges, from the numbers of samples in the classes.
std::optional<std::size_t> best_cut(const Grid& grid, const ReadClasses& read, const std::vector<double>& counts,
                                    Context* context) {
  const Counts differences = over_pairs(grid, read, counts.size(), context, 0,
                                        [](Counts& sums, std::size_t low, std::size_t high) { ++sums[high - low]; });
  constexpr double kDeviations = 0.6745;                      // in which half of a normal distribution lies
  const double noise = median_of(differences) / kDeviations;  // of differences
  // What is added where a step begins to be cut, and taken away where it ends.
  const Counts changes =
      over_pairs(grid, read, 2 * counts.size(), context, 0.5, [&](Counts& sums, std::size_t low, std::size_t high) {
        const std::size_t step = high - low;
        if (static_cast<double>(step) <= kNoiseSteps * noise) return;
        sums[2 * low] += step * step;
        sums[2 * high + 1] += step * step;
      });
  const auto most = static_cast<double>(std::max_element(counts.begin(), counts.end()) - counts.begin());
  std::uint64_t cut = 0, best = 0;
  std::size_t first = 0, last = 0;
  for (std::size_t c = 1; c < counts.size(); ++c) {
    cut += changes[2 * (c - 1)];
    cut -= changes[2 * (c - 1) + 1];
    if (std::abs(static_cast<double>(c) - most) < kNoiseSteps * noise / std::sqrt(2)) continue;
    if (cut > best) first = c;
    if (cut >= best) last = c;
    best = std::max(best, cut);
  }
  if (best == 0) return {};
  return first + (last - first) / 2;
}

/// The place, in classes, below which a share of what is counted in the classes from `first` to `end` lies, evenly
/// spread in every class, of which a whole number is the middle.
double quantile(const std::vector<double>& counts, std::size_t first, std::size_t end, double share) {
  double left = share * std::accumulate(counts.begin() + static_cast<std::ptrdiff_t>(first),
                                        counts.begin() + static_cast<std::ptrdiff_t>(end), 0.0);
  for (std::size_t c = first; c < end; ++c) {
    if (counts[c] > 0 && counts[c] >= left) return static_cast<double>(c) - 0.5 + left / counts[c];
    left -= counts[c];
  }
  return static_cast<double>(end);
}

/// Two thresholds, in classes.
struct TwoCuts {
  double low, high;
};

/// The two thresholds for thin things, by the one that cuts most of the edges, if noise leaves room between them.
std::optional<TwoCuts> cuts_of_thin(const std::vector<double>& counts, std::size_t edges) {
  constexpr double kOneDeviationBelow = 0.1587;  // share of a normal distribution
  constexpr double kBright = 0.9;                // as bright as thick things are, but for outliers
  const double dark = quantile(counts, 0, edges, 0.5), noise = dark - quantile(counts, 0, edges, kOneDeviationBelow);
  const double high = (dark + quantile(counts, edges, counts.size(), kBright)) / 2;
  const double low = std::max(dark + kNoiseSteps * noise, (dark + high) / 2);
  if (!(low < high)) return {};
  return TwoCuts{low, high};
}

template <class T>
Threshold threshold_at(double value) {
  if constexpr (std::is_integral_v<T>)
    return static_cast<std::int64_t>(std::clamp(std::ceil(value), -0x1p62, 0x1p62));
  else
    return value;
}

}  // namespace

std::vector<ProposedThreshold> proposed_thresholds(const Volume& volume, Context* context) {
  return std::visit(
      [&]<class T>(const std::vector<T>& samples) {
        std::vector<ProposedThreshold> proposals;
        const Range<T> range(samples);
        if (!range.third) return proposals;
        const Classes<T> fine(range, kClasses, kClasses), coarse = preparation::otsu_classes(range);
        if (fine.count == 0) return proposals;
        const std::vector<double> counts = fine.counts(samples);
        const auto cut = best_cut(volume.grid, reader_of(samples, fine), counts, context);
        if (cut)
          proposals.push_back({"edges", threshold_at<T>(fine.low + static_cast<double>(*cut) * fine.step),
                               "cuts most of the edges between dark and bright, also of things that fill little of the "
                               "image"});
        const std::size_t otsu = preparation::otsu(coarse.counts(samples));
        proposals.push_back({"otsu", threshold_at<T>(coarse.low + static_cast<double>(otsu) * coarse.step),
                             "parts dark from bright voxels best, where there are many of both (Otsu)"});
        if (const auto thin = cut ? cuts_of_thin(counts, *cut) : std::nullopt) {
          const auto at = [&](double place) { return threshold_at<T>(fine.low + place * fine.step); };
          proposals.push_back({"thin", at(thin->low),
                               "half way up what is thick, and from there along thin things that are less bright, down "
                               "to half of that, above the noise",
                               at(thin->high)});
        }
        return proposals;
      },
      volume.samples);
}

Histogram histogram_of(const Volume& volume, std::size_t classes) {
  return std::visit(
      [&]<class T>(const std::vector<T>& samples) {
        const Range<T> range(samples);
        Histogram histogram;
        histogram.not_finite = range.not_finite;
        if (!range.any || !std::isfinite(range.width())) return histogram;
        histogram.low = static_cast<double>(range.low);
        histogram.high = static_cast<double>(range.high);
        if constexpr (std::is_integral_v<T>)
          histogram.width = std::max(1.0, std::ceil((range.width() + 1) / static_cast<double>(classes)));
        else
          histogram.width = range.width() > 0 ? range.width() / static_cast<double>(classes) : 1;
        const double count = std::floor(range.width() / histogram.width) + 1;
        histogram.counts.resize(std::min(classes, static_cast<std::size_t>(count)));
        for (const T sample : samples)
          if (preparation::is_finite(sample)) {
            const double at = (static_cast<double>(sample) - histogram.low) / histogram.width;
            ++histogram.counts[std::min(histogram.counts.size() - 1, static_cast<std::size_t>(at))];
          }
        return histogram;
      },
      volume.samples);
}

}  // namespace quench

namespace quench::preparation {

std::size_t otsu(const std::vector<double>& counts) {
  double all = 0, sum = 0;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    all += counts[i];
    sum += counts[i] * static_cast<double>(i);
  }
  double below = 0, sum_below = 0, best = -1;
  std::size_t first = 1, last = 1;
  for (std::size_t i = 1; i < counts.size(); ++i) {
    below += counts[i - 1];
    sum_below += counts[i - 1] * static_cast<double>(i - 1);
    if (below <= 0 || below >= all) continue;
    const double apart = sum_below / below - (sum - sum_below) / (all - below);
    const double between = below * (all - below) * apart * apart;
    if (between > best) first = i;
    if (between >= best) last = i;
    best = std::max(best, between);
  }
  return first + (last - first) / 2;
}

}  // namespace quench::preparation
