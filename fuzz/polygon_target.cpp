// SPDX-License-Identifier: Apache-2.0
// A reader of polygons: QUENCH_FUZZ_EXTENSION says which. What it hands over must be digitized, or refused in a
// sentence.
#include "memory_file.h"
#include "quench/polygons.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace quench;
  static const fuzz::MemoryFile file(QUENCH_FUZZ_EXTENSION);
  fuzz::reads_or_refuses([&] {
    Context context;
    context.note = [](const std::string&) {};
    std::uint64_t next = 0;
    const auto count = [&](std::uint64_t number) {
      if (number < next) fuzz::defect("the numbers of features do not grow");
      next = number + 1;
    };
    const auto take = [&](PolygonFeature&& feature) {
      count(feature.number);
      fuzz::reads_or_refuses([&] {
        const DigitizeOptions options{.resolution = 4, .pixel = {}, .fill = feature.fill};
        const VoxelShape shape = digitize(feature.polygons, options, &context);
        shape.validate();
        if (boundary_rings(shape).rings.empty()) fuzz::defect("a shape has no boundary");
      });
    };
    const auto bad = [&](PolygonFeature&& feature, const Error& error) {
      count(feature.number);
      if (!feature.polygons.rings.empty()) fuzz::defect("a feature that cannot be used has rings");
      fuzz::reads_or_refuses([&] { throw error; });
    };
    const std::uint64_t features = io::for_each_feature(file.holding(data, size), take, bad, &context);
    if (features < next) fuzz::defect("fewer features are counted than handed over");
  });
  return 0;
}
