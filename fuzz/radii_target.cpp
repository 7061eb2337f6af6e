// SPDX-License-Identifier: Apache-2.0
// The reader of .r files, which matches its lines with the vertices of a mesh.
#include "memory_file.h"
#include "quench/io.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace quench;
  static const fuzz::MemoryFile file(".r");
  static const std::vector<Vec3> points{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};
  fuzz::reads_or_refuses([&] {
    const std::vector<double> radii = io::read_radii(file.holding(data, size), points);
    if (radii.size() != points.size()) fuzz::defect("there is not one radius for every point");
    for (const double radius : radii)
      if (!(radius >= 0)) fuzz::defect("a radius is negative or no number");
  });
  return 0;
}
