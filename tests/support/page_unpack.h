// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

/// The codes of arrays of a page (viewer/FORMAT.md), without any clever structure.
namespace quench::testing_page {

using Arrays = std::map<std::string, std::vector<double>>;

inline std::vector<std::uint32_t> words_of(const std::string& bytes, std::size_t planes, std::size_t count) {
  std::vector<std::uint32_t> words(count, 0);
  for (std::size_t p = 0; p < planes; ++p)
    for (std::size_t i = 0; i < count; ++i)
      words[i] |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[p * count + i])) << (8 * p);
  return words;
}

inline std::uint32_t difference_of(std::uint32_t code) { return (code >> 1) ^ (0U - (code & 1)); }

/// An array with a code. `arrays`: those before it.
inline std::vector<double> decoded(const nlohmann::json& entry, const std::string& bytes, const Arrays& arrays) {
  const std::string code = entry["code"], type = entry["type"], name = entry["name"];
  const std::size_t components = entry["components"], count = entry["count"].get<std::size_t>() * components;
  std::vector<std::uint32_t> words = words_of(bytes, entry["planes"], count);
  std::vector<double> values;
  const auto as_value = [&](std::uint32_t w) {
    return type == "f32" ? std::bit_cast<float>(w) : static_cast<double>(w);
  };
  if (code == "delta") {
    for (std::size_t i = 0; i < count; ++i) {
      words[i] = difference_of(words[i]) + (i < components ? 0 : words[i - components]);
      values.push_back(as_value(words[i]));
    }
  } else if (code == "fresh") {
    std::uint32_t next = 0;
    for (const std::uint32_t w : words) {
      values.push_back(next - w);
      next += w == 0;
    }
  } else if (code == "steps") {
    const std::uint32_t bits = entry["bits"], mask = (1U << bits) - 1;
    for (std::size_t i = 0; i < count; ++i) {
      words[i] = (difference_of(words[i]) + (i < components ? 0 : words[i - components])) & mask;
      const double low = entry["low"][i % components], step = entry["step"][i % components];
      values.push_back(words[i] == mask       ? std::numeric_limits<double>::infinity()
                       : words[i] == mask - 1 ? std::numeric_limits<double>::quiet_NaN()
                                              : low + step * words[i]);
    }
  } else if (code == "difference") {
    const std::vector<double>&a = arrays.at(entry["of"][0]), &b = arrays.at(entry["of"][1]);
    for (std::size_t i = 0; i < count; ++i) values.push_back(std::isfinite(a[i]) ? std::max(0.0, a[i] - b[i]) : a[i]);
  } else {
    EXPECT_EQ(code, "again");
    const std::string layer = name.substr(0, name.find('/'));
    const auto &face = arrays.at(layer + "/face_level"), &offsets = arrays.at(layer + "/polygon_offsets"),
               &corners = arrays.at(layer + "/polygon_corners");
    std::map<double, std::uint32_t> last;
    for (std::size_t f = 0; f < face.size(); ++f)
      for (auto i = static_cast<std::size_t>(offsets[f]); i < static_cast<std::size_t>(offsets[f + 1]); ++i) {
        const std::uint32_t most = std::bit_cast<std::uint32_t>(static_cast<float>(face[f]));
        const auto found = last.find(corners[i]);
        const std::uint32_t level =
            difference_of(words[i]) + (found == last.end() ? most : std::min(most, found->second));
        last[corners[i]] = level;
        values.push_back(std::bit_cast<float>(level));
      }
  }
  return values;
}

/// Adds edges and sides of a layer and its levels; its faces stay in the order of the file.
inline void complete(const std::string& layer, const std::vector<std::string>& measures, Arrays& arrays) {
  const auto name = [&](const std::string& what) { return layer + "/" + what; };
  if (!arrays.contains(name("lone_edges"))) return;
  const std::vector<double>&corners = arrays[name("polygon_corners")], &offsets = arrays[name("polygon_offsets")];
  std::vector<double> edges, sides(corners.size());
  std::map<std::pair<double, double>, std::size_t> first;
  for (std::size_t f = 0; f + 1 < offsets.size(); ++f)
    for (auto i = static_cast<std::size_t>(offsets[f]), end = static_cast<std::size_t>(offsets[f + 1]); i < end; ++i) {
      const double a = corners[i], b = corners[i + 1 < end ? i + 1 : static_cast<std::size_t>(offsets[f])];
      const auto [found, fresh] = first.emplace(std::minmax(a, b), edges.size() / 2);
      if (fresh) edges.insert(edges.end(), {std::min(a, b), std::max(a, b)});
      sides[i] = static_cast<double>(found->second);
    }
  const double lone = static_cast<double>(edges.size() / 2);
  edges.insert(edges.end(), arrays[name("lone_edges")].begin(), arrays[name("lone_edges")].end());
  const std::vector<double>& others = arrays[name("other_sides")];
  for (std::size_t i = 0; i < others.size(); i += 2)
    sides.at(static_cast<std::size_t>(others[i])) = lone + others[i + 1];
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const auto settle = [&](std::vector<double>& levels, const std::string& array, const std::string& suffix) {
    for (double& level : levels)
      if (level == -kInfinity) level = kInfinity;
    const auto &rows = arrays.at(name(array + "_rows" + suffix)), &values = arrays.at(name(array + "_values" + suffix));
    for (std::size_t i = 0; i < rows.size(); ++i) levels.at(static_cast<std::size_t>(rows[i])) = values[i];
  };
  std::vector<std::string> suffixes{""};
  for (const std::string& measure : measures) suffixes.push_back("/" + measure);
  for (const std::string& suffix : suffixes) {
    if (!arrays.contains(name("face_level" + suffix))) continue;
    const std::vector<double>& face = arrays[name("face_level" + suffix)];
    std::vector<double> edge(edges.size() / 2, -kInfinity), vertex(arrays[name("points")].size() / 3, -kInfinity);
    for (std::size_t f = 0; f < face.size(); ++f)
      for (auto i = static_cast<std::size_t>(offsets[f]); i < static_cast<std::size_t>(offsets[f + 1]); ++i)
        edge[static_cast<std::size_t>(sides[i])] = std::max(edge[static_cast<std::size_t>(sides[i])], face[f]);
    if (suffix.empty() && arrays.contains(name("curve_edges")))
      for (const double e : arrays[name("curve_edges")]) edge.at(static_cast<std::size_t>(e)) = kInfinity;
    settle(edge, "edge_level", suffix);
    for (std::size_t e = 0; e < edges.size(); ++e)
      vertex[static_cast<std::size_t>(edges[e])] = std::max(vertex[static_cast<std::size_t>(edges[e])], edge[e / 2]);
    settle(vertex, "vertex_level", suffix);
    arrays[name("edge_level" + suffix)] = std::move(edge);
    arrays[name("vertex_level" + suffix)] = std::move(vertex);
  }
  arrays[name("edges")] = std::move(edges);
  arrays[name("polygon_edges")] = std::move(sides);
}

}  // namespace quench::testing_page
