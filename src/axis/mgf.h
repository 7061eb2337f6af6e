#pragma once
#include "quench/shape.h"
namespace quench::axis {
std::vector<double> mgf_of_edges(const VoxelShape& shape, std::span<const LatticePoint> sites,
                                 std::span<const std::array<std::uint32_t, 2>> edge_sites);
}
