// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// The files that say what a folder of Zarr (version 2 or 3) or N5 is.
namespace quench::io {

enum class ZarrFormat { zarr2, zarr3, n5 };

struct ZarrNode {
  std::filesystem::path folder;
  ZarrFormat format = ZarrFormat::zarr2;
  bool array = false;         ///< else a group
  nlohmann::json meta;        ///< an object; of a group of version 2 `.zgroup`
  nlohmann::json attributes;  ///< an object, of N5 the same as `meta`
};

/// Nothing where the folder is none of these. Throws Error(input) where its files are damaged.
std::optional<ZarrNode> zarr_node(const std::filesystem::path& folder);

/// The member of an object; null where there is none, or no object.
const nlohmann::json* json_member(const nlohmann::json& object, std::string_view name);
/// A text; empty for anything else.
std::string json_text(const nlohmann::json* value);
/// Finite numbers; nothing for anything else.
std::optional<std::vector<double>> json_numbers(const nlohmann::json* value);

}  // namespace quench::io
