// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>

#include "program.h"
#include "quench/io.h"
#include "quench/medial_axis.h"
#include "quench/topology.h"
#include "quench/voxelize.h"

namespace quench::program {
namespace {

using Json = nlohmann::ordered_json;

template <class T>
const char* type_name() {
  if constexpr (std::is_same_v<T, std::string>) return "text";
  if constexpr (std::is_same_v<T, float>) return "float32";
  if constexpr (std::is_same_v<T, double>) return "float64";
  if constexpr (std::is_integral_v<T>) {
    constexpr const char* names[2][4] = {{"uint8", "uint16", "uint32", "uint64"}, {"int8", "int16", "int32", "int64"}};
    return names[std::is_signed_v<T>][sizeof(T) == 1 ? 0 : sizeof(T) == 2 ? 1 : sizeof(T) == 4 ? 2 : 3];
  }
  return "";
}

Json arrays_info(const std::vector<DataArray>& arrays) {
  Json list = Json::object();
  for (const DataArray& array : arrays) {
    Json entry;
    std::visit(
        [&](const auto& values) {
          using T = typename std::decay_t<decltype(values)>::value_type;
          entry["type"] = type_name<T>();
          entry["components"] = array.components;
          if constexpr (std::is_same_v<T, std::string>) {
            entry["value"] = values;
          } else if (!values.empty()) {
            const auto [low, high] = std::minmax_element(values.begin(), values.end());
            entry["min"] = *low;
            entry["max"] = *high;
            if (values.size() <= 12) entry["value"] = values;
          }
        },
        array.values);
    list[array.name] = std::move(entry);
  }
  return list;
}

Json surface_info(const std::string& file) {
  const PolyData data = io::read_poly_data(file);
  Json info;
  const bool axis = find_array(data.point_data, "radius") || !data.lines.empty() || data.poly_count() == 0;
  info["kind"] = axis ? "medial axis" : "mesh";
  info["points"] = data.points.size();
  info["vertex_cells"] = data.verts.size();
  info["lines"] = data.lines.size();
  info["polygons"] = data.poly_count();
  if (!data.points.empty()) {
    Vec3 low = data.points[0], high = low;
    for (const Vec3& p : data.points) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    info["box"] = {{low[0], low[1], low[2]}, {high[0], high[1], high[2]}};
  }
  if (axis) {
    const CellComplex complex = complex_of(data);
    const Topology t = topology(complex);
    info["complex"] = {{"vertices", complex.vertex_count}, {"edges", complex.edges.size()}, {"faces", complex.face_count()},
                       {"euler", t.euler}, {"betti", t.betti}};
  } else {
    const SurfaceTopology t = surface_topology(to_triangle_mesh(data));
    info["surface"] = {{"euler", 2 * t.euler}, {"components", t.components}, {"closed_2_manifold", t.manifold}};
  }
  info["point_arrays"] = arrays_info(data.point_data);
  info["cell_arrays"] = arrays_info(data.cell_data);
  info["field_arrays"] = arrays_info(data.field_data);
  return info;
}

Json volume_info(const std::string& file, Session& session) {
  const Volume volume = io::read_volume(file, {}, &session.context);
  Json info;
  info["kind"] = "volume";
  const Grid& g = volume.grid;
  info["dims"] = g.dims;
  info["spacing"] = {g.spacing[0], g.spacing[1], g.spacing[2]};
  info["origin"] = {g.origin[0], g.origin[1], g.origin[2]};
  info["direction"] = Json::array();
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) info["direction"].push_back(g.direction(r, c));
  if (!volume.units.empty()) info["units"] = volume.units;
  std::visit(
      [&](const auto& samples) {
        using T = typename std::decay_t<decltype(samples)>::value_type;
        info["type"] = type_name<T>();
        constexpr std::size_t most = 32;
        std::map<T, std::int64_t> counts;  // of the values, while they are few
        T low = samples.empty() ? T{} : samples[0], high = low;
        for (const T& s : samples) {
          low = std::min(low, s);
          high = std::max(high, s);
          if (counts.size() <= most) ++counts[s];
        }
        info["min"] = low;
        info["max"] = high;
        if (counts.size() <= most) {
          info["values"] = Json::object();
          for (const auto& [value, count] : counts) info["values"][fmt::format("{}", value)] = count;
        }
        info["hint"] = counts.size() <= 2 ? "non-zero voxels are the shape" : counts.size() <= most ? "choose a shape with --label" : "choose a shape with --threshold";
      },
      volume.samples);
  return info;
}

void print(const Json& value, int indent) {
  for (const auto& [key, entry] : value.items()) {
    if (entry.is_object() && !entry.empty()) {
      fmt::print("{:{}}{}:\n", "", indent, key);
      print(entry, indent + 2);
    } else if (!entry.empty() || !entry.is_object()) {
      fmt::print("{:{}}{}: {}\n", "", indent, key, entry.is_string() ? entry.get<std::string>() : entry.dump());
    }
  }
}

}  // namespace

Action add_info(CLI::App& app) {
  struct Options {
    std::string file;
  };
  auto o = std::make_shared<Options>();
  app.add_option("FILE", o->file, "A mesh, a medial axis or a volume")->required();
  return [o](Session& session) {
    if (!std::filesystem::exists(o->file)) throw Error(ErrorCode::failed, fmt::format("{} does not exist", o->file));
    Json info = {{"file", o->file}};
    const io::Kind kind = io::kind_of(o->file);
    if (kind == io::Kind::unknown) throw Error(ErrorCode::input, fmt::format("{} is of no kind Quench knows by its name", o->file));
    info.update(kind == io::Kind::volume ? volume_info(o->file, session) : surface_info(o->file));
    if (session.options.report.empty())
      print(info, 0);
    else
      fmt::print("{}\n", info.dump(2));
    return 0;
  };
}

}  // namespace quench::program
