// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/memory.h"
#include "printable.h"
#include "program.h"
#include "quench/axis.h"
#include "quench/io.h"
#include "quench/polygons.h"
#include "quench/preparation.h"
#include "quench/shape.h"
#include "quench/tree.h"
#include "quench/voxelize.h"
#include "report.h"
#include "shape_input.h"
#include "tree_conversion.h"

namespace quench::program {
namespace {

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

/// A number as JSON; JSON has no infinite ones.
template <class T>
Json number(T value) {
  if constexpr (std::is_floating_point_v<T>) {
    if (std::isnan(value)) return "nan";
    if (std::isinf(value)) return value > 0 ? "inf" : "-inf";
  }
  return value;
}

/// Range and number of each value, while the values are few.
template <class T>
struct Statistics {
  static constexpr std::size_t most = 32;
  T low{}, high{};
  std::int64_t numbers = 0, not_a_number = 0;
  std::map<T, std::int64_t> counts;
  bool few = true;

  explicit Statistics(const std::vector<T>& values) {
    for (std::size_t i = 0; i < values.size();) {  // by stretches of equal values: images are full of them
      const T value = values[i];
      std::size_t end = i + 1;
      if (value != value) {
        ++not_a_number;
        i = end;
        continue;
      }
      while (end < values.size() && values[end] == value) ++end;
      if (numbers == 0) low = high = value;
      low = std::min(low, value);
      high = std::max(high, value);
      numbers += static_cast<std::int64_t>(end - i);
      if (few) counts[value] += static_cast<std::int64_t>(end - i);
      if (counts.size() > most) few = false;
      i = end;
    }
  }
  void add_range(Json& info) const {
    if (numbers > 0) {
      info["min"] = number(low);
      info["max"] = number(high);
    }
    if (not_a_number > 0) info["not_a_number"] = not_a_number;
  }
};

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
          } else if (values.size() <= 12) {
            entry["value"] = Json::array();
            for (const T value : values) entry["value"].push_back(number(value));
          } else {
            Statistics<T>(values).add_range(entry);
          }
        },
        array.values);
    list[array.name] = std::move(entry);
  }
  return list;
}

Json surface_info(const std::string& file, Session& session) {
  const Record data = pipeline::read_surface(file, &session.context);
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
    info["complex"] = {{"vertices", complex.vertex_count},
                       {"edges", complex.edges.size()},
                       {"faces", complex.face_count()},
                       {"euler", t.euler},
                       {"betti", t.betti}};
  } else {
    const SurfaceTopology t = surface_topology(to_triangle_mesh(data));
    info["surface"] = {{"closed", t.boundary_edges == 0},
                       {"boundary_edges", t.boundary_edges},
                       {"components", t.components},
                       {"euler", t.surface_euler},
                       {"closed_2_manifold", t.manifold}};
  }
  info["point_arrays"] = arrays_info(data.point_data);
  info["cell_arrays"] = arrays_info(data.cell_data);
  info["field_arrays"] = arrays_info(data.field_data);
  return info;
}

// Control characters of a foreign file must not reach a terminal as such.
std::string plain(const Json& value) {
  return printable(value.is_string() ? value.get<std::string>() : json_text(value));
}

Json threshold_json(const Threshold& threshold) {
  return std::visit([](auto t) { return Json(t); }, threshold);
}

/// How often values occur, and the thresholds they suggest where they are no labels.
void add_values(Json& info, const Volume& volume, bool is_labels, Session& session) {
  constexpr std::size_t kClasses = 32;
  const Histogram histogram = histogram_of(volume, kClasses);
  if (!histogram.counts.empty())
    info["histogram"] = {{"low", histogram.low}, {"width", histogram.width}, {"counts", histogram.counts}};
  if (is_labels) return;
  const std::vector<ProposedThreshold> proposals = proposed_thresholds(volume, &session.context);
  for (const ProposedThreshold& p : proposals) {
    info["thresholds"][p.rule] = {{"value", threshold_json(p.value)}, {"reason", p.reason}};
    if (p.seed) info["thresholds"][p.rule]["seed"] = threshold_json(*p.seed);
  }
}

/// Lines of an image's histogram: the logarithm of the counts, as what matters may fill little of an image.
std::string histogram_text(const Json& histogram) {
  constexpr double kLongest = 50;
  const auto counts = histogram["counts"].get<std::vector<std::uint64_t>>();
  const double low = histogram["low"], width = histogram["width"];
  const auto most = static_cast<double>(*std::ranges::max_element(counts));
  std::string text = "histogram: from each value on, bars by the logarithm of the number\n";
  const std::size_t longest = fmt::format("{:.4g}", low + width * static_cast<double>(counts.size())).size() + 2;
  for (std::size_t c = 0; c < counts.size(); ++c) {
    const double share = std::log1p(static_cast<double>(counts[c])) / std::log1p(most);
    text += fmt::format("  {:>{}} {:<50} {}\n", fmt::format("{:.4g}", low + width * static_cast<double>(c)), longest,
                        std::string(static_cast<std::size_t>(std::lround(kLongest * share)), '#'), counts[c]);
  }
  return text;
}

/// How a shape can be chosen from the values of an image.
template <class T>
std::string hint_of(const Volume& volume, const Statistics<T>& statistics, const Json& thresholds) {
  const bool two = statistics.few && statistics.counts.size() + (statistics.not_a_number > 0) <= 2;
  const auto proposal = volume.grid.is_plane() ? pipeline::propose_threshold(volume) : std::nullopt;
  if (two && !proposal)
    return fmt::format("the shape is the non-zero {}, or choose with --label",
                       volume.grid.is_plane() ? "pixels" : "voxels");
  if (!proposal && thresholds.is_object())
    return fmt::format("choose a shape with {}--threshold, e.g. {} ({}), which 'auto' takes",
                       statistics.few ? "--label or " : "", plain(thresholds.front()["value"]),
                       thresholds.items().begin().key());
  if (!proposal) return fmt::format("choose a shape with {}", statistics.few ? "--label" : "--threshold");
  const auto value =
      std::visit([](auto t) { return fmt::format("{:.6g}", static_cast<double>(t)); }, proposal->threshold);
  return fmt::format("choose a shape with {}{}: what is bright, with --invert what is dark{}",
                     statistics.few ? "--label or --threshold " : "--threshold ", value,
                     proposal->bright_border ? ", as the bright border suggests" : "");
}

/// A volume of one slice may be an image, too: here that is said, and no reason to stop.
Volume read_to_show(const std::string& file, const io::VolumeReadOptions& options, Session& session) {
  try {
    return io::read_volume(file, options, &session.context);
  } catch (const Error& error) {
    if (error.field() != "dimension" || options.dimension) throw;
    io::VolumeReadOptions as_slab = options;
    as_slab.dimension = 3;
    Volume volume = io::read_volume(file, as_slab, &session.context);
    session.say(fmt::format("note: {} [--dimension]", error.what()));
    return volume;
  }
}

/// What is known of a volume or a stream of slices before its samples are read.
Json place_info(const auto& volume) {
  Json info;
  const Grid& g = volume.grid;
  const auto n = static_cast<std::size_t>(g.dimension);
  info["kind"] = g.is_plane() ? "image" : "volume";
  if (!volume.picture.empty()) info["picture"] = volume.picture;
  const auto first = [n](const auto& values) {
    Json list = Json::array();
    for (std::size_t a = 0; a < n; ++a) list.push_back(values[a]);
    return list;
  };
  info[g.is_plane() ? "pixels" : "dims"] = first(g.dims);
  info["spacing"] = first(std::array{g.spacing[0], g.spacing[1], g.spacing[2]});
  if (!volume.spacing_source.empty()) info["spacing_source"] = volume.spacing_source;
  info["origin"] = first(std::array{g.origin[0], g.origin[1], g.origin[2]});
  info["direction"] = Json::array();
  for (int r = 0; r < g.dimension; ++r)
    for (int c = 0; c < g.dimension; ++c) info["direction"].push_back(g.direction(r, c));
  if (!volume.coordinates.units.empty()) info["units"] = volume.coordinates.units;
  if (!volume.coordinates.space.empty()) info["space"] = volume.coordinates.space;
  if (g.is_plane()) info["y_axis"] = volume.coordinates.y_down ? "down" : "up";
  return info;
}

/// Of a volume whose samples do not fit into memory; nothing where they do, or where it is not read in slices.
std::optional<Json> info_without_samples(const std::string& file, const io::VolumeReadOptions& options,
                                         Session& session) {
  Context quiet;  // all notes were said
  quiet.memory_limit = session.context.memory_limit;
  const auto slices = io::open_slices(file, options, &quiet);
  if (!slices) return {};
  constexpr std::array<const char*, 10> names{"uint8", "int8",   "uint16", "int16",   "uint32",
                                              "int32", "uint64", "int64",  "float32", "float64"};
  constexpr std::array<int, 10> bytes{1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
  const auto type = static_cast<std::size_t>(slices->type);
  double needed = bytes[type];
  for (const std::int64_t side : slices->grid.dims) needed *= static_cast<double>(side);
  const std::int64_t limit = quiet.memory_limit > 0 ? quiet.memory_limit : base::available_memory();
  if (needed <= static_cast<double>(limit)) return {};
  Json info = place_info(*slices);
  info["type"] = names[type];
  return info;
}

Json volume_info(const std::string& file, const io::VolumeReadOptions& options, Session& session) {
  Volume volume;
  try {
    volume = read_to_show(file, options, session);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::failed) throw;
    std::optional<Json> info = info_without_samples(file, options, session);
    if (!info) throw;
    session.say(fmt::format("note: its values are not looked at: {}", error.what()));
    return *info;
  }
  Json info = place_info(volume);
  const Grid& g = volume.grid;
  std::visit(
      [&](const auto& samples) {
        using T = typename std::decay_t<decltype(samples)>::value_type;
        info["type"] = type_name<T>();
        const Statistics<T> statistics(samples);
        statistics.add_range(info);
        if (statistics.few) {
          info["values"] = Json::object();
          for (const auto& [value, count] : statistics.counts) info["values"][fmt::format("{}", value)] = count;
        }
        const auto labels = g.is_plane() ? std::vector<std::int64_t>() : labels_in(volume);
        if (!statistics.few || statistics.counts.size() > 2) add_values(info, volume, !labels.empty(), session);
        info["hint"] = labels.empty()
                           ? hint_of(volume, statistics, info["thresholds"])
                           : fmt::format("these are labels ({}); choose a shape with --label", labels_text(labels));
        if (info["thresholds"].is_null()) info.erase("thresholds");
      },
      volume.samples);
  return info;
}

/// How many polygons a file holds, of what, and where.
Json polygons_info(const std::string& file, Session& session) {
  std::uint64_t bad = 0, rings = 0, points = 0, with_properties = 0;
  Vec2 low = Vec2::Constant(std::numeric_limits<double>::infinity()), high = -low;
  std::string first_bad, first_properties;
  bool y_down = false;
  const std::uint64_t features = io::for_each_feature(
      file,
      [&](PolygonFeature&& feature) {
        y_down = feature.y_down;
        if (!feature.properties.empty() && with_properties++ == 0) first_properties = feature.properties;
        for (const auto& ring : feature.polygons.rings) {
          ++rings;
          points += ring.size();
          for (const Vec2& p : ring) {
            low = low.cwiseMin(p);
            high = high.cwiseMax(p);
          }
        }
      },
      [&](PolygonFeature&&, const Error& error) {
        if (bad++ == 0) first_bad = error.what();
      },
      &session.context);
  Json info = {{"kind", "polygons"}, {"features", features}, {"rings", rings}, {"points", points}};
  if (points > 0) info["box"] = {{number(low[0]), number(low[1])}, {number(high[0]), number(high[1])}};
  info["y_axis"] = y_down ? "down" : "up";
  if (bad > 0) info["unusable"] = {{"features", bad}, {"first", first_bad}};
  if (with_properties > 0) {
    const Json properties = Json::parse(first_properties, nullptr, false);
    info["properties"] = Json::array();
    for (const auto& [name, value] : properties.items()) info["properties"].push_back(name);
  }
  return info;
}

bool is_short(const Json& value) {
  return value.is_object() && value.size() <= 4 &&
         std::none_of(value.begin(), value.end(), [](const Json& entry) { return entry.is_object(); });
}

/// "key: value" lines; small objects, such as an array's type and range, on one line.
std::string text_of(const Json& object, int indent) {
  std::string text;
  for (const auto& [key, entry] : object.items()) {
    if (entry.is_object() && entry.empty()) continue;
    if (key == "histogram" && entry.contains("counts")) {
      text += histogram_text(entry);
      continue;
    }
    text += fmt::format("{:{}}{}:", "", indent, printable(key));
    if (indent > 0 && is_short(entry)) {
      for (const auto& [name, value] : entry.items())
        text += fmt::format("{} {} {}", &value == &entry.front() ? "" : ",", printable(name), plain(value));
      text += '\n';
    } else if (entry.is_object()) {
      text += '\n' + text_of(entry, indent + 2);
    } else {
      text += ' ' + plain(entry) + '\n';
    }
  }
  return text;
}

}  // namespace

Action add_info(CLI::App& app) {
  struct Options {
    std::string file;
    io::VolumeReadOptions how;
  };
  auto o = std::make_shared<Options>();
  app.add_option("FILE", o->file, "A mesh, a medial axis, a volume, an image, polygons or a tree")
      ->type_name("")
      ->required();
  add_channel(app, o->how.channel);
  add_dimension(app, o->how.dimension);
  return [o](Session& session) {
    check_exists(o->file);
    Json info = {{"file", o->file}};
    const io::Kind kind = io::kind_of(o->file);
    const bool tree = io::is_tree_file(o->file);
    if (kind == io::Kind::unknown && !tree) pipeline::refuse_unknown_kind(o->file);
    if (tree)
      info.update(tree_info(o->file, session));
    else if (kind == io::Kind::polygons)
      info.update(polygons_info(o->file, session));
    else
      info.update(kind == io::Kind::volume ? volume_info(o->file, o->how, session) : surface_info(o->file, session));
    session.answer(session.options.report.empty() ? text_of(info, 0) : json_text(info, 2) + "\n");
    return 0;
  };
}

}  // namespace quench::program
