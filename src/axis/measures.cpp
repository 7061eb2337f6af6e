// SPDX-License-Identifier: Apache-2.0
#include "axis/measures.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <string>

#include "quench/error.h"

namespace quench::axis {
namespace {

constexpr DerivedMeasure kDerivedMeasures[] = {{"object_angle", kLambda, false, object_angles},
                                               {kCapHeight, kLambda, true, cap_heights}};

}  // namespace

std::vector<DerivedMeasure> derivable(const MedialAxis& axis) {
  std::vector<DerivedMeasure> list;
  for (const DerivedMeasure& derived : kDerivedMeasures)
    if (const Measure* from = axis.find_measure(derived.from);
        from && !from->value.empty() && from->value.complete(axis.complex))
      list.push_back(derived);
  return list;
}

}  // namespace quench::axis

namespace quench {

const Measure* MedialAxis::find_measure(std::string_view name) const {
  const auto found = std::ranges::find(measures, name, &Measure::name);
  return found == measures.end() ? nullptr : &*found;
}

const Measure& MedialAxis::measure(std::string_view name) const {
  if (const Measure* found = find_measure(name)) return *found;
  throw Error(ErrorCode::usage,
              fmt::format("the medial axis has no measure '{}'; voxel_core() makes one that has 'lambda'", name));
}

Measure& MedialAxis::measure(std::string_view name) {
  return const_cast<Measure&>(static_cast<const MedialAxis&>(*this).measure(name));
}

std::vector<std::string> derived_measures(const MedialAxis& axis) {
  std::vector<std::string> names;
  for (const auto& derived : axis::derivable(axis)) names.emplace_back(derived.name);
  return names;
}

Measure derived_measure(const MedialAxis& axis, std::string_view name) {
  const std::vector<axis::DerivedMeasure> known = axis::derivable(axis);
  const auto found = std::ranges::find(known, name, &axis::DerivedMeasure::name);
  if (found == known.end())
    throw Error(ErrorCode::usage, fmt::format("there is no measure '{}' to derive from what the medial axis has; there "
                                              "are: {}",
                                              name, fmt::join(derived_measures(axis), ", ")));
  return {std::string(name), found->values(axis, axis.measure(found->from).value), {}};
}

}  // namespace quench
