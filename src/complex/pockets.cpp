// SPDX-License-Identifier: Apache-2.0
#include "complex/pockets.h"

#include "base/graph_peeler.h"

namespace quench::complex {

std::vector<char> faces_in_pockets(const CellComplex& complex) {
  base::GraphPeeler peeler(complex.edges.size());
  for (std::uint32_t f = 0; f < complex.face_count(); ++f)
    for (const std::uint32_t e : complex.sides(f)) peeler.add(e, f);
  std::vector<char> alive(complex.face_count(), 1);
  peeler.peel([&](std::uint32_t f) { return complex.sides(f); }, [](std::uint32_t, std::uint32_t) { return true; },
              [&](std::uint32_t, std::uint32_t f) { alive[f] = 0; });
  return alive;
}

}  // namespace quench::complex
