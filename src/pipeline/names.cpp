// SPDX-License-Identifier: Apache-2.0
#include "quench/pipeline.h"

namespace quench::pipeline {
namespace {

/// Of two values of an enum, the one whose name it is.
template <class Enum>
std::optional<Enum> named(std::string_view name, Enum a, Enum b) {
  if (name == name_of(a)) return a;
  if (name == name_of(b)) return b;
  return {};
}

}  // namespace

std::string_view name_of(LambdaRule rule) { return rule == LambdaRule::ball ? "ball" : "coface"; }
std::string_view name_of(RadiusRule rule) { return rule == RadiusRule::linear ? "linear" : "exact"; }
std::string_view name_of(Propagation propagation) {
  return propagation == Propagation::windows ? "windows" : "segments";
}

std::optional<LambdaRule> lambda_rule_of(std::string_view name) {
  return named(name, LambdaRule::coface, LambdaRule::ball);
}
std::optional<RadiusRule> radius_rule_of(std::string_view name) {
  return named(name, RadiusRule::exact, RadiusRule::linear);
}
std::optional<Propagation> propagation_of(std::string_view name) {
  return named(name, Propagation::segments, Propagation::windows);
}

}  // namespace quench::pipeline
