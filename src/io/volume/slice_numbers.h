// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

namespace quench::io {

/// Throws Error(input) where the names of the slices in `folder` show that one is missing, occurs twice or does not
/// belong to them. Slices are numbered where more than half of them, and at least 3, or all have names that differ in
/// one number only (without extension; leading zeros do not count): then all must have such a name, and the numbers a
/// constant step, the smallest of their differences. Other names are free, and nothing is checked.
void check_slice_numbers(const std::filesystem::path& folder, const std::vector<std::filesystem::path>& files);

}  // namespace quench::io
