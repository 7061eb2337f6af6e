// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <functional>
#include <span>

#include "base/parallel.h"
#include "preparation/filters.h"

namespace quench::preparation {
namespace {

constexpr std::int64_t kSlab = 16;  // slices that are blurred at a time

/// Gives the samples from `first` on as numbers. Not a template parameter: there are many types of samples.
template <class Number>
using LoadRow = std::function<void(std::size_t first, std::span<Number> to)>;
/// Takes the results from `first` on.
template <class Number>
using StoreRow = std::function<void(std::size_t first, std::span<const Number> results)>;

/// Blurs along x, y and z. A sample is loaded before any result that it is part of is stored, and never afterwards.
template <class Number>
void blur_separably(const Grid& grid, double sigma, const LoadRow<Number>& load, const StoreRow<Number>& store,
                    Context* context) {
  std::array<std::vector<Number>, 3> kernel;
  for (std::size_t a = 0; a < 3; ++a) {
    const double least = grid.spacing.minCoeff(), step = grid.spacing[static_cast<Eigen::Index>(a)];
    for (const double w : gaussian_kernel(a == 2 && grid.is_plane() ? 0 : sigma * least / step))
      kernel[a].push_back(static_cast<Number>(w));
  }
  const std::int64_t nx = grid.dims[0], ny = grid.dims[1], nz = grid.dims[2];
  const auto reach = [&](std::size_t a) { return static_cast<std::int64_t>(kernel[a].size()) - 1; };
  const std::int64_t kept = 2 * reach(2) + kSlab;  // slices, blurred along x and y
  const auto slice = static_cast<std::size_t>(nx * ny);
  std::vector<Number> ring(slice * static_cast<std::size_t>(std::min(kept, nz)));
  const auto row_of = [&](std::int64_t y, std::int64_t z) {
    return ring.data() + static_cast<std::size_t>(z % kept) * slice + static_cast<std::size_t>(nx * y);
  };

  const auto blur_slice = [&](std::int64_t z) {
    std::vector<Number> along_x(slice), line(static_cast<std::size_t>(nx + 2 * reach(0)));
    for (std::int64_t y = 0; y < ny; ++y) {
      const std::size_t first = static_cast<std::size_t>(z) * slice + static_cast<std::size_t>(nx * y);
      Number* in = line.data() + reach(0);
      load(first, {in, static_cast<std::size_t>(nx)});
      std::fill_n(line.data(), reach(0), in[0]);
      std::fill_n(in + nx, reach(0), in[nx - 1]);
      Number* out = along_x.data() + nx * y;
      for (std::int64_t x = 0; x < nx; ++x) out[x] = kernel[0][0] * in[x];
      for (std::int64_t k = 1; k <= reach(0); ++k)
        for (std::int64_t x = 0; x < nx; ++x)
          out[x] += kernel[0][static_cast<std::size_t>(k)] * (in[x - k] + in[x + k]);
    }
    for (std::int64_t y = 0; y < ny; ++y) {
      Number* out = row_of(y, z);
      const auto in = [&](std::int64_t at) { return along_x.data() + nx * std::clamp<std::int64_t>(at, 0, ny - 1); };
      for (std::int64_t x = 0; x < nx; ++x) out[x] = kernel[1][0] * in(y)[x];
      for (std::int64_t k = 1; k <= reach(1); ++k) {
        const Number *below = in(y - k), *above = in(y + k);
        for (std::int64_t x = 0; x < nx; ++x) out[x] += kernel[1][static_cast<std::size_t>(k)] * (below[x] + above[x]);
      }
    }
  };
  const auto store_slice = [&](std::int64_t z) {
    std::vector<Number> out(static_cast<std::size_t>(nx));
    for (std::int64_t y = 0; y < ny; ++y) {
      const auto in = [&](std::int64_t at) { return row_of(y, std::clamp<std::int64_t>(at, 0, nz - 1)); };
      for (std::int64_t x = 0; x < nx; ++x) out[static_cast<std::size_t>(x)] = kernel[2][0] * in(z)[x];
      for (std::int64_t k = 1; k <= reach(2); ++k) {
        const Number *below = in(z - k), *above = in(z + k);
        for (std::int64_t x = 0; x < nx; ++x)
          out[static_cast<std::size_t>(x)] += kernel[2][static_cast<std::size_t>(k)] * (below[x] + above[x]);
      }
      const std::size_t first = static_cast<std::size_t>(z) * slice + static_cast<std::size_t>(nx * y);
      store(first, out);
    }
  };
  const auto for_slices = [&](std::int64_t begin, std::int64_t end, double at, const auto& work) {
    if (begin >= end) return;
    base::for_chunks(static_cast<std::size_t>(end - begin), context, "blur", at, at,
                     [&](std::size_t i) { work(begin + static_cast<std::int64_t>(i)); });
  };
  base::in_arena(context, [&] {
    for (std::int64_t z = 0, read = 0; z < nz; z += kSlab) {
      const double at = static_cast<double>(z) / static_cast<double>(nz);
      const std::int64_t next = std::min(nz, z + kSlab + reach(2));
      for_slices(read, next, at, blur_slice);
      read = next;
      for_slices(z, std::min(nz, z + kSlab), at, store_slice);
    }
  });
  checkpoint(context, "blur", 1);
}

/// Samples that are not finite stay, and weigh nothing.
template <class T, class Out>
void blur_all(const Grid& grid, std::vector<T>& samples, std::vector<Out>& out, double sigma, Context* context) {
  using Number = Work<T>;
  const auto load = [&](const auto& number_of) {
    return [&samples, number_of](std::size_t first, std::span<Number> to) {
      for (std::size_t i = 0; i < to.size(); ++i) to[i] = number_of(samples[first + i]);
    };
  };
  if (std::ranges::all_of(samples, is_finite<T>))
    return blur_separably<Number>(
        grid, sigma, load([](T sample) { return static_cast<Number>(sample); }),
        [&](std::size_t first, std::span<const Number> results) {
          for (std::size_t i = 0; i < results.size(); ++i) out[first + i] = as_sample<Out>(results[i]);
        },
        context);
  std::vector<Number> weight(samples.size());
  blur_separably<Number>(
      grid, sigma, load([](T sample) { return is_finite(sample) ? Number{1} : Number{0}; }),
      [&](std::size_t first, std::span<const Number> results) {
        for (std::size_t i = 0; i < results.size(); ++i)
          weight[first + i] = is_finite(samples[first + i]) ? results[i] : Number{0};
      },
      context);
  blur_separably<Number>(
      grid, sigma, load([](T sample) { return is_finite(sample) ? static_cast<Number>(sample) : Number{0}; }),
      [&](std::size_t first, std::span<const Number> results) {
        for (std::size_t i = 0; i < results.size(); ++i)
          if (weight[first + i] > 0) out[first + i] = as_sample<Out>(results[i] / weight[first + i]);
      },
      context);
}

}  // namespace

std::vector<double> gaussian_kernel(double sigma) {
  const double t = sigma * sigma;
  if (!(t > 1e-12)) return {1};
  // I_{n-1} = 2n/t I_n + I_{n+1}, downwards from where it is next to nothing (Miller).
  const auto far = static_cast<std::size_t>(std::ceil(8 * sigma + 16));
  std::vector<double> kernel(far + 1, 0.0);
  double last = 0, here = 1e-300, sum = 0;
  for (std::size_t n = far; n > 0; --n) {
    kernel[n] = here;
    sum += 2 * here;
    last = std::exchange(here, 2 * static_cast<double>(n) / t * here + last);
    if (here > 1e200) {
      for (double& w : kernel) w *= 1e-300;
      here *= 1e-300;
      last *= 1e-300;
      sum *= 1e-300;
    }
  }
  kernel[0] = here;
  sum += here;
  double tail = 0;
  while (kernel.size() > 1 && tail + kernel.back() < 1e-5 * sum) {
    tail += kernel.back();
    kernel.pop_back();
  }
  for (double& w : kernel) w /= sum - 2 * tail;
  return kernel;
}

void blur(Volume& volume, double sigma, Context* context) {
  with_results(volume, [&](auto& samples, auto& out) { blur_all(volume.grid, samples, out, sigma, context); });
}

}  // namespace quench::preparation
