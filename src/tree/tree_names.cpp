// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "quench/tree.h"

namespace quench {
namespace {

template <class Value>
using NamesOf = std::pair<Value, std::string_view>;

constexpr std::array<NamesOf<AxisRule>, 5> kAxisRules{{{AxisRule::depth, "depth"},
                                                       {AxisRule::length, "length"},
                                                       {AxisRule::radius, "radius"},
                                                       {AxisRule::strahler, "strahler"},
                                                       {AxisRule::continuation, "continuation"}}};
constexpr std::array<NamesOf<RepairRule>, 4> kRepairRules{
    {{RepairRule::off, "off"}, {RepairRule::loops, "loops"}, {RepairRule::gaps, "gaps"}, {RepairRule::all, "all"}}};
constexpr std::array<NamesOf<RootRule>, 3> kRootRules{
    {{RootRule::thickest, "thickest"}, {RootRule::end, "end"}, {RootRule::top, "top"}}};
constexpr std::array<NamesOf<SomaRule>, 3> kSomaRules{
    {{SomaRule::none, "none"}, {SomaRule::automatic, "auto"}, {SomaRule::thickest, "thickest"}}};

template <class Names, class Value>
std::string_view name_in(const Names& names, Value value) {
  return std::ranges::find(names, value, &NamesOf<Value>::first)->second;
}
template <class Value, std::size_t N>
std::optional<Value> value_in(const std::array<NamesOf<Value>, N>& names, std::string_view name) {
  const auto found = std::ranges::find(names, name, &NamesOf<Value>::second);
  return found == names.end() ? std::nullopt : std::optional<Value>(found->first);
}

}  // namespace

std::string direction_text(const Vec3& direction) {
  for (int a = 0; a < 3; ++a)
    if (std::abs(direction[a]) == 1) return fmt::format("{}{}", direction[a] < 0 ? '-' : '+', "xyz"[a]);
  return fmt::format("{:.4g},{:.4g},{:.4g}", direction[0], direction[1], direction[2]);
}

std::string_view name_of(AxisRule rule) { return name_in(kAxisRules, rule); }
std::optional<AxisRule> axis_rule_of(std::string_view name) { return value_in(kAxisRules, name); }
std::string_view name_of(RepairRule rule) { return name_in(kRepairRules, rule); }
std::optional<RepairRule> repair_rule_of(std::string_view name) { return value_in(kRepairRules, name); }
std::string_view name_of(RootRule rule) { return name_in(kRootRules, rule); }
std::optional<RootRule> root_rule_of(std::string_view name) { return value_in(kRootRules, name); }
std::string_view name_of(SomaRule rule) { return name_in(kSomaRules, rule); }
std::optional<SomaRule> soma_rule_of(std::string_view name) { return value_in(kSomaRules, name); }

}  // namespace quench
