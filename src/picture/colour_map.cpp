// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "picture/style.h"

namespace quench::picture {

Vec3f colour_at(double t) {
  const double x = std::clamp(t, 0.0, 1.0) * static_cast<double>(kViridis.size() - 1);
  const auto i = std::min(kViridis.size() - 2, static_cast<std::size_t>(x));
  const Vec3f a = rgb(kViridis[i]), b = rgb(kViridis[i + 1]);
  return a + (b - a) * static_cast<float>(x - static_cast<double>(i));
}

}  // namespace quench::picture
