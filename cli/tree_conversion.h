// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "report.h"

/// Trees of files in `quench info` and `quench convert`.
namespace quench::program {

/// What a tree holds: nodes, tips, forks, length.
Json tree_info(const std::filesystem::path& file, Session& session);

/// Throws Error(usage) for a format that trees are not written in: to be called before they are read.
void check_tree_format(const std::filesystem::path& output);
/// Reads a tree, finds its axes where the file does not say them, and writes it.
void convert_tree(const std::filesystem::path& input, const std::filesystem::path& output, Session& session);

}  // namespace quench::program
