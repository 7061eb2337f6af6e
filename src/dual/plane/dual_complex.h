#pragma once
#include <span>
#include "dual/dual_complex.h"
#include "quench/context.h"
#include "quench/shape.h"
namespace quench::dual::plane {
DualComplex dual_complex(const VoxelShape& shape, std::span<const LatticePoint> sites,
                         const std::array<std::int64_t, 3>& spacing, Context* context);
}
