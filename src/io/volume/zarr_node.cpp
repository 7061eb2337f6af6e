// SPDX-License-Identifier: Apache-2.0
#include "io/volume/zarr_node.h"

#include <fmt/format.h>

#include <cmath>

#include "base/text.h"
#include "io/common/formats.h"
#include "io/volume/stored_volume.h"
#include "io/volume/volume_formats.h"
#include "quench/error.h"

namespace quench::io {
namespace {

bool is_there(const std::filesystem::path& file) {
  std::error_code ignored;
  return std::filesystem::exists(file, ignored);
}

nlohmann::json object_in(const std::filesystem::path& file) {
  constexpr std::uintmax_t kLargest = std::uintmax_t{1} << 26;
  check_regular_file(file);
  std::error_code error;
  if (const auto size = std::filesystem::file_size(file, error); !error && size > kLargest)
    refuse_volume(file, "it has more than 64 MB, and metadata are a few lines");
  nlohmann::json object = nlohmann::json::parse(load_file(file, nullptr).bytes, nullptr, false);
  if (!object.is_object()) refuse_volume(file, "it is not a JSON object; it is damaged");
  return object;
}

}  // namespace

std::optional<ZarrNode> zarr_node(const std::filesystem::path& folder) {
  ZarrNode node;
  node.folder = folder;
  if (is_there(folder / "zarr.json")) {
    node.format = ZarrFormat::zarr3;
    node.meta = object_in(folder / "zarr.json");
    node.array = json_text(json_member(node.meta, "node_type")) == "array";
    const nlohmann::json* attributes = json_member(node.meta, "attributes");
    node.attributes = attributes && attributes->is_object() ? *attributes : nlohmann::json::object();
    return node;
  }
  for (const char* name : {".zarray", ".zgroup"}) {
    if (!is_there(folder / name)) continue;
    node.meta = object_in(folder / name);
    node.array = name == std::string_view(".zarray");
    node.attributes = is_there(folder / ".zattrs") ? object_in(folder / ".zattrs") : nlohmann::json::object();
    return node;
  }
  if (!is_there(folder / "attributes.json")) return {};
  node.format = ZarrFormat::n5;
  node.meta = node.attributes = object_in(folder / "attributes.json");
  node.array = node.meta.contains("dimensions");
  return node;
}

const nlohmann::json* json_member(const nlohmann::json& object, std::string_view name) {
  if (!object.is_object()) return nullptr;
  const auto found = object.find(name);
  return found == object.end() ? nullptr : &*found;
}

std::string json_text(const nlohmann::json* value) {
  return value && value->is_string() ? value->get<std::string>() : std::string();
}

std::optional<std::vector<double>> json_numbers(const nlohmann::json* value) {
  if (!value || !value->is_array()) return {};
  std::vector<double> numbers;
  for (const nlohmann::json& number : *value) {
    if (!number.is_number() || !std::isfinite(number.get<double>())) return {};
    numbers.push_back(number.get<double>());
  }
  return numbers;
}

}  // namespace quench::io
