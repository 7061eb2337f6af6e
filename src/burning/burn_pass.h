// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "burning/labels.h"

namespace quench::burning {

/// The tolerance of labels that burn() takes.
double label_tolerance(const CellComplex& complex, std::span<const Vec3> points, double omega);

/// The burn pass (geometry): burns states until none is queued. Two neighbouring burned nodes send the unfolded source
/// of their front through the segment between them.
void propagate_by_segments(const BurnDomain& domain, Labels& labels, Context* context);

/// The burn pass without nodes: fire as windows on edges, exact up to rounding (docs/algorithms/burning.md).
BurnTimes propagate_by_windows(const BurnDomain& domain, Context* context);

/// The order pass (topology): the burn sequence over the times of the burn pass, and from it the parents of prime
/// sectors. Throws Error(invariant) when a sector outside the pockets has no place in it.
void order_pass(const BurnDomain& domain, const std::vector<char>& opened, const Times& time, BurnedSectors& result,
                Context* context);

/// The result of burning from the times of a finished burn pass, `sectors` being the one whose network is that of the
/// domain; with the order pass where options.parents asks for it.
Burning finish_burning(const BurnDomain& domain, BurnTimes burned, std::shared_ptr<BurnedSectors> sectors,
                       const BurnOptions& options, Context* context);

/// burn() with another schedule, which changes times by a small part of the spacing where fronts meet.
Burning burn_scheduled(const CellComplex& complex, std::span<const Vec3> points, std::span<const double> radius,
                       const BurnOptions& options, const BlockSchedule& schedule, Context* context);

}  // namespace quench::burning
