// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <set>
#include <string>

#include "quench/verify.h"

/// What a certificate says, for failures of tests.
namespace quench::testing_certificates {

using Names = std::set<std::string>;

inline std::string text(const Certificate& certificate) {
  std::string all;
  for (const Check& check : certificate.checks)
    all += (check.passed ? "  ok   " : "  FAIL ") + check.name + ": " + check.detail + "\n";
  return all;
}

inline Names failed(const Certificate& certificate) {
  Names names;
  for (const Check& check : certificate.checks)
    if (!check.passed) names.insert(check.name);
  return names;
}

}  // namespace quench::testing_certificates
