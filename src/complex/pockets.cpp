// SPDX-License-Identifier: Apache-2.0
#include "complex/pockets.h"

namespace quench::complex {

std::vector<char> faces_in_pockets(const CellComplex& complex) {
  std::vector<std::uint32_t> degree(complex.edges.size(), 0), faces_xor(complex.edges.size(), 0);
  for (std::uint32_t f = 0; f < complex.face_count(); ++f)
    for (std::uint32_t e : complex.sides(f)) {
      ++degree[e];
      faces_xor[e] ^= f;  // with degree 1 this is the only face
    }
  std::vector<char> alive(complex.face_count(), 1);
  std::vector<std::uint32_t> stack;
  for (std::uint32_t e = 0; e < degree.size(); ++e)
    if (degree[e] == 1) stack.push_back(e);
  while (!stack.empty()) {
    const std::uint32_t free = stack.back();
    stack.pop_back();
    if (degree[free] != 1) continue;
    const std::uint32_t f = faces_xor[free];
    alive[f] = 0;
    for (std::uint32_t e : complex.sides(f)) {
      --degree[e];
      faces_xor[e] ^= f;
      if (degree[e] == 1) stack.push_back(e);
    }
  }
  return alive;
}

}  // namespace quench::complex
