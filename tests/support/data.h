// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <filesystem>

/// Real data lies beside the checkout; tests that use it are skipped, visibly, where it is absent.
inline std::filesystem::path data_file(const char* name) { return std::filesystem::path(QUENCH_DATA) / name; }

#define REQUIRE_DATA(name) \
  if (!std::filesystem::exists(data_file(name))) GTEST_SKIP() << "no real data beside the checkout: " << name
