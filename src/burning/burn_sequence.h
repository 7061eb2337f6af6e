// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "burning/domain.h"

namespace quench::burning {

/// The result of burning from the times of its sectors.
Burning burning_with(const BurnDomain& domain, std::shared_ptr<BurnedSectors> sectors, const BurnOptions& options);

/// Rounds finite times as BurnOptions::rounded says; sets `sectors.step`.
void round_times(const BurnDomain& domain, Times& times, BurnedSectors& sectors);

/// A number of 64 bits for the axis, its radii, its network of nodes and the radius rule: what a sequence refers to.
std::uint64_t fingerprint(const BurnDomain& domain);
/// The same for the arrays of a sequence among those of a file.
std::uint64_t fingerprint(const std::vector<DataArray>& arrays);

/// Removes the arrays of a sequence.
void drop_sequence(Record& data);

}  // namespace quench::burning
