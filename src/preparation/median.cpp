// SPDX-License-Identifier: Apache-2.0
#include <array>

#include "base/parallel.h"
#include "preparation/filters.h"

namespace quench::preparation {
namespace {

constexpr std::int64_t kMedianSlab = 16;  // slices that are done at a time

/// The median of samples that come and go, of 8 bits.
template <class T>
class SlidingMedian {
 public:
  void add(T sample, int by) {
    const int at = sample - int{std::numeric_limits<T>::min()};
    counts_[static_cast<std::size_t>(at)] += by;
    all_ += by;
    if (at < place_) below_ += by;
  }
  T get() {
    const int half = (all_ - 1) / 2;  // so many are below the median, in order
    while (below_ > half) below_ -= counts_[static_cast<std::size_t>(--place_)];
    while (below_ + counts_[static_cast<std::size_t>(place_)] <= half)
      below_ += counts_[static_cast<std::size_t>(place_++)];
    return static_cast<T>(place_ + std::numeric_limits<T>::min());
  }

 private:
  std::array<int, 256> counts_{};
  int all_ = 0, place_ = 0, below_ = 0;
};

/// Medians of one scanline from the scanlines around it.
template <class T>
void medians_of_row(const std::vector<const T*>& rows, std::int64_t nx, std::int64_t radius, T* out) {
  const auto column = [&](std::int64_t x) { return std::clamp<std::int64_t>(x, 0, nx - 1); };
  if constexpr (sizeof(T) == 1) {
    SlidingMedian<T> median;
    const auto add = [&](std::int64_t x, int by) {
      for (const T* row : rows) median.add(row[column(x)], by);
    };
    for (std::int64_t x = -radius; x < radius; ++x) add(x, 1);
    for (std::int64_t x = 0; x < nx; ++x) {
      add(x + radius, 1);
      out[x] = median.get();
      add(x - radius, -1);
    }
  } else {
    std::vector<T> around;
    for (std::int64_t x = 0; x < nx; ++x) {
      around.clear();
      for (const T* row : rows)
        for (std::int64_t i = x - radius; i <= x + radius; ++i)
          if (const T sample = row[column(i)]; is_finite(sample)) around.push_back(sample);
      if (around.empty() || !is_finite(out[x])) continue;
      const auto middle = around.begin() + static_cast<std::ptrdiff_t>((around.size() - 1) / 2);
      std::nth_element(around.begin(), middle, around.end());
      out[x] = *middle;
    }
  }
}

template <class T>
void medians_of(const Grid& grid, std::vector<T>& samples, std::int64_t radius, Context* context) {
  const std::int64_t nx = grid.dims[0], ny = grid.dims[1], nz = grid.dims[2], deep = grid.is_plane() ? 0 : radius;
  const auto slice = static_cast<std::size_t>(nx * ny);
  const std::int64_t kept = 2 * deep + kMedianSlab;  // slices as they were
  std::vector<T> ring(slice * static_cast<std::size_t>(std::min(kept, nz)));
  const auto in_ring = [&](std::int64_t z) { return ring.begin() + static_cast<std::ptrdiff_t>(z % kept * nx * ny); };
  base::in_arena(context, [&] {
    for (std::int64_t z = 0, read = 0; z < nz; z += kMedianSlab) {
      for (; read < std::min(nz, z + kMedianSlab + deep); ++read)
        std::copy_n(samples.begin() + static_cast<std::ptrdiff_t>(read * nx * ny), slice, in_ring(read));
      const auto rows = static_cast<std::size_t>(ny * std::min(kMedianSlab, nz - z));
      const double at = static_cast<double>(z) / static_cast<double>(nz);
      base::for_chunks(rows, context, "median", at, at, [&](std::size_t i) {
        const std::int64_t y = static_cast<std::int64_t>(i) % ny, k = z + static_cast<std::int64_t>(i) / ny;
        std::vector<const T*> around;
        for (std::int64_t dz = -deep; dz <= deep; ++dz)
          for (std::int64_t dy = -radius; dy <= radius; ++dy)
            around.push_back(&*in_ring(std::clamp<std::int64_t>(k + dz, 0, nz - 1)) +
                             nx * std::clamp<std::int64_t>(y + dy, 0, ny - 1));
        medians_of_row(around, nx, radius, samples.data() + static_cast<std::size_t>(k) * slice + nx * y);
      });
    }
  });
  checkpoint(context, "median", 1);
}

}  // namespace

void take_medians(Volume& volume, int radius, Context* context) {
  std::visit([&](auto& samples) { medians_of(volume.grid, samples, radius, context); }, volume.samples);
}

}  // namespace quench::preparation
