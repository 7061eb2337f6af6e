// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "quench/polygons.h"

/// All that a file of polygons hands over.
struct ReadPolygons {
  std::vector<quench::PolygonFeature> features;
  std::vector<std::pair<quench::PolygonFeature, std::string>> bad;
  std::vector<std::string> notes;
  std::uint64_t count = 0;
};

inline ReadPolygons read_polygons(const std::filesystem::path& file) {
  ReadPolygons read;
  quench::Context context;
  context.note = [&](const std::string& sentence) { read.notes.push_back(sentence); };
  read.count = quench::io::for_each_feature(
      file, [&](quench::PolygonFeature&& feature) { read.features.push_back(std::move(feature)); },
      [&](quench::PolygonFeature&& feature, const quench::Error& error) {
        read.bad.emplace_back(std::move(feature), error.what());
      },
      &context);
  return read;
}
