// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <type_traits>

#include "quench/preparation.h"

namespace quench {
namespace {

constexpr std::size_t kMostLabels = 64, kLargestLabel = 2 * kMostLabels - 1;

}  // namespace

std::vector<std::int64_t> labels_in(const Volume& volume) {
  return std::visit(
      [&]<class T>(const std::vector<T>& samples) {
        std::vector<std::int64_t> labels;
        if constexpr (std::is_integral_v<T>) {
          std::array<bool, kLargestLabel + 1> there{};
          std::size_t changes = 0;
          for (std::size_t i = 0; i < samples.size(); ++i) {
            if (samples[i] < 0 || static_cast<std::uint64_t>(samples[i]) > kLargestLabel) return labels;
            there[static_cast<std::size_t>(samples[i])] = true;
            changes += i > 0 && samples[i] != samples[i - 1];
          }
          for (std::size_t value = 0; value < there.size(); ++value)
            if (there[value]) labels.push_back(static_cast<std::int64_t>(value));
          constexpr std::size_t kOneOf = 10;
          if (!there[0] || labels.size() < 3 || labels.size() > kMostLabels || kOneOf * changes > samples.size() ||
              2 * labels.size() < static_cast<std::size_t>(labels.back()) + 1)
            labels.clear();
        }
        return labels;
      },
      volume.samples);
}

std::string labels_text(const std::vector<std::int64_t>& labels) {
  constexpr std::size_t kMost = 12;
  if (labels.size() <= kMost) return fmt::format("{}", fmt::join(labels, ", "));
  return fmt::format("{}, {}, {} ... {}", labels[0], labels[1], labels[2], labels.back());
}

}  // namespace quench
