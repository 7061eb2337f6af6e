#include "quench/polygons.h"
namespace quench { VoxelShape digitize(const Polygons&, const DigitizeOptions&, Context*) { return {}; }
namespace io { std::uint64_t for_each_feature(const std::filesystem::path&, const std::function<void(PolygonFeature&&)>&, const std::function<void(std::uint64_t, const Error&)>&, Context*, const PolygonReadOptions&) { return 0; } } }
