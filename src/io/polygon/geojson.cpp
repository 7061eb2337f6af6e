// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>
#include <string_view>
#include <vector>

#include "base/text.h"
#include "io/polygon/polygon_formats.h"

/// GeoJSON (RFC 7946) as a stream of events: of a collection, one feature is in memory at a time. Members come in any
/// order, so what a geometry is may be known only at its end.
namespace quench::io {
namespace {

using Json = nlohmann::json;

constexpr int kDeepest = 64;  // geometries in geometry collections; brackets in properties

/// A geometry object. Its coordinates are taken as rings of positions however deep they are nested.
struct Geometry {
  std::string type;
  std::vector<std::vector<Vec2>> rings;
  int position_depth = 0;  ///< arrays from `coordinates` to a position; 0: no position yet
  bool malformed = false;
};

struct Feature {
  std::string id, properties;
  Polygons polygons;
  bool no_geometry = false;  ///< null
  std::string other_type;    ///< of a geometry without an area
  std::string problem;
};

/// Why the text is not GeoJSON.
struct Damaged {
  std::string reason;
};

int depth_of_positions(std::string_view type) {
  if (type == "Polygon" || type == "MultiLineString") return 3;
  if (type == "MultiPolygon") return 4;
  if (type == "LineString" || type == "MultiPoint") return 2;
  return type == "Point" ? 1 : 0;
}

/// JSON text from events.
class JsonText {
 public:
  void value(std::string_view text) {
    separate();
    text_ += text;
  }
  void key(const std::string& name) {
    separate();
    text_ += quoted(name) + ":";
  }
  void open(char bracket) {
    separate();
    text_ += bracket;
  }
  void close(char bracket) { text_ += bracket; }
  std::string take() { return std::exchange(text_, {}); }
  static std::string quoted(const std::string& text) {
    return Json(text).dump(-1, ' ', false, Json::error_handler_t::replace);
  }

 private:
  void separate() {
    if (!text_.empty() && std::string_view("{[:").find(text_.back()) == std::string_view::npos) text_ += ',';
  }
  std::string text_;
};

/// Takes the events of nlohmann's parser for one object. Throws Damaged, and what the sink throws.
class GeoJsonEvents {
 public:
  explicit GeoJsonEvents(FeatureSink& sink) : sink_(sink) {}

  Reference reference() const { return reference_; }

  bool null() {
    if (mode_ == Mode::none && in_object() && key_ == "geometry") feature_.no_geometry = true;
    return scalar("null");
  }
  bool boolean(bool value) { return scalar(value ? "true" : "false"); }
  bool number_integer(std::int64_t value) { return number(static_cast<double>(value), std::to_string(value)); }
  bool number_unsigned(std::uint64_t value) { return number(static_cast<double>(value), std::to_string(value)); }
  bool number_float(double value, const std::string& text) { return number(value, text); }
  bool binary(Json::binary_t&) { return true; }  // JSON has none
  bool string(std::string& value) {
    if (mode_ == Mode::none && in_object() && key_ == "type") {
      geometries_.back().type = value;
      return true;
    }
    const bool wanted = mode_ == Mode::capture || (mode_ == Mode::none && key_ == "id");
    const std::string text = wanted ? JsonText::quoted(value) : std::string();
    if (wanted && takes_id()) feature_.id = text;
    return scalar(text);
  }

  bool key(const std::string& name) {
    if (mode_ == Mode::capture) captured_.key(name);
    if (mode_ == Mode::none) key_ = name;
    return true;
  }

  bool start_object(std::size_t) {
    if (mode_ != Mode::none) {
      geometries_.back().malformed |= mode_ == Mode::coordinates;
      return nested('{');
    }
    if (places_.empty() || places_.back() == Place::features) {
      begin_feature();
    } else if (places_.back() == Place::geometries || key_ == "geometry") {
      if (geometries_.size() > std::size_t{kDeepest}) throw Damaged{"geometries are nested too deep"};
      places_.push_back(Place::geometry);
      geometries_.emplace_back();
    } else {
      captures_crs_ = places_.size() == 1 && key_ == "crs";
      begin(captures_crs_ || takes("properties") ? Mode::capture : Mode::skip, '{');
    }
    return true;
  }

  bool end_object() {
    if (mode_ != Mode::none) return left('}');
    if (places_.back() == Place::feature) {
      finish_feature();
    } else {
      take_geometry(geometries_.back());
    }
    geometries_.pop_back();
    places_.pop_back();
    return true;
  }

  bool start_array(std::size_t) {
    if (mode_ == Mode::coordinates) geometries_.back().malformed |= ordinates_ > 0;  // numbers beside arrays
    if (mode_ != Mode::none) return nested('[');
    if (places_.empty()) throw Damaged{"it is an array, not an object of GeoJSON"};
    if (in_object() && key_ == "coordinates") {
      geometries_.back().rings.clear();
      geometries_.back().position_depth = 0;
      ring_.clear();
      begin(Mode::coordinates, '[');
    } else if (in_object() && key_ == "geometries") {
      places_.push_back(Place::geometries);
    } else if (places_.size() == 1 && key_ == "features") {
      has_features_ = true;
      places_.push_back(Place::features);
    } else {
      not_an_object();
      begin(Mode::skip, '[');
    }
    return true;
  }

  bool end_array() {
    if (mode_ == Mode::coordinates) end_coordinates();
    if (mode_ != Mode::none) return left(']');
    places_.pop_back();
    return true;
  }

  bool parse_error(std::size_t position, const std::string&, const Json::exception& error) {
    constexpr int number_too_large = 406;
    throw Damaged{fmt::format("the JSON is incomplete or damaged at byte {}{}", position,
                              error.id == number_too_large ? ": a number is beyond the range of doubles" : "")};
  }

 private:
  enum class Place { features, feature, geometries, geometry };  // of what has begun and is looked into
  enum class Mode { none, capture, skip, coordinates };          // what is done with all of a value

  bool in_object() const {
    return !places_.empty() && (places_.back() == Place::feature || places_.back() == Place::geometry);
  }
  bool takes(const char* name) const { return places_.back() == Place::feature && key_ == name; }
  bool takes_id() const { return mode_ == Mode::none && !places_.empty() && takes("id"); }

  void begin(Mode mode, char bracket) {
    mode_ = mode;
    nested(bracket);
  }
  bool nested(char bracket) {
    ++depth_;
    if (mode_ == Mode::capture && depth_ > kDeepest) {  // who reads the text may do so by recursion
      if (!captures_crs_) fail("its properties are nested too deeply");
      captured_.take();
      mode_ = Mode::skip;
    }
    if (mode_ == Mode::capture) captured_.open(bracket);
    return true;
  }
  bool left(char bracket) {
    if (mode_ == Mode::capture) captured_.close(bracket);
    if (--depth_ > 0) return true;
    if (mode_ == Mode::capture) {
      const std::string text = captured_.take();
      if (captures_crs_)
        reference_ = text.find("CRS84") != std::string::npos || text.find("4326") != std::string::npos
                         ? Reference::degrees
                         : Reference::other;
      else
        feature_.properties = text == "{}" ? std::string() : text;
    }
    mode_ = Mode::none;
    return true;
  }

  bool scalar(const std::string& text) {
    if (mode_ == Mode::capture) captured_.value(text);
    if (mode_ == Mode::coordinates) geometries_.back().malformed = true;
    if (mode_ != Mode::none) return true;
    if (places_.empty()) throw Damaged{"it is a single value, not an object of GeoJSON"};
    if (in_object() && key_ == "coordinates") geometries_.back().malformed = true;
    not_an_object();
    return true;
  }
  bool number(double value, const std::string& text) {
    if (mode_ != Mode::coordinates) {
      if (takes_id()) feature_.id = text;
      return scalar(text);
    }
    Geometry& geometry = geometries_.back();
    if (geometry.position_depth == 0) geometry.position_depth = depth_;
    geometry.malformed |= geometry.position_depth != depth_;
    if (ordinates_ < 2) position_[ordinates_] = value;
    ++ordinates_;
    return true;
  }

  /// An element of a list of features or geometries that is none.
  void not_an_object() {
    if (places_.back() == Place::features) sink_.refuse("it is not an object");
    if (places_.back() == Place::geometries) fail("a member of its geometry is not an object");
  }
  void fail(const std::string& problem) {
    if (feature_.problem.empty()) feature_.problem = problem;
  }

  void end_coordinates() {
    Geometry& geometry = geometries_.back();
    if (ordinates_ > 0) {
      geometry.malformed |= ordinates_ < 2;
      ring_.push_back(position_);
      ordinates_ = 0;
    } else if (depth_ == geometry.position_depth - 1) {
      geometry.rings.push_back(std::move(ring_));
      ring_.clear();
    }
  }

  void begin_feature() {
    places_.push_back(Place::feature);
    geometries_.emplace_back();
    feature_ = {};
  }

  void take_geometry(Geometry& geometry) {
    const std::string& type = geometry.type;
    if (type == "GeometryCollection") return;
    const int depth = depth_of_positions(type);
    if (depth == 0) {
      fail(type.empty() ? "its geometry has no type" : fmt::format("its geometry is of the unknown type '{}'", type));
    } else if (type != "Polygon" && type != "MultiPolygon") {
      feature_.other_type = type;
    } else if (geometry.malformed || (geometry.position_depth != 0 && geometry.position_depth != depth)) {
      fail(fmt::format("its coordinates are not those of a {}", type));
    } else {
      for (auto& ring : geometry.rings) feature_.polygons.rings.push_back(std::move(ring));
    }
  }

  void finish_feature() {
    Geometry& own = geometries_.back();
    const bool root = places_.size() == 1;
    if (root && (has_features_ || own.type == "FeatureCollection")) return;
    if (own.type != "Feature" && !(own.type.empty() && !root)) {
      if (root && own.type != "GeometryCollection" && depth_of_positions(own.type) == 0)
        throw Damaged{own.type.empty() ? "it is JSON, but not GeoJSON: it has no type"
                                       : fmt::format("it is of the type '{}', which GeoJSON does not have", own.type)};
      take_geometry(own);
    }
    PolygonFeature feature;
    feature.id = std::move(feature_.id);
    feature.properties = std::move(feature_.properties);
    if (!feature_.problem.empty()) return sink_.refuse(feature_.problem, std::move(feature));
    if (feature_.polygons.rings.empty())
      return sink_.refuse(feature_.no_geometry ? "it has no geometry"
                          : feature_.other_type.empty()
                              ? "its polygon is empty"
                              : fmt::format("its geometry is a {}, not a polygon", feature_.other_type),
                          std::move(feature));
    feature.polygons = std::move(feature_.polygons);
    sink_.take(std::move(feature));
  }

  FeatureSink& sink_;
  std::vector<Place> places_;
  std::vector<Geometry> geometries_;  // of every feature (it may be a bare geometry) and geometry that has begun
  std::string key_;                   // the last one outside of what a mode takes
  Mode mode_ = Mode::none;
  int depth_ = 0;  // of brackets in what a mode takes
  bool captures_crs_ = false, has_features_ = false;
  JsonText captured_;
  Feature feature_;
  std::vector<Vec2> ring_;
  Vec2 position_{0, 0};
  int ordinates_ = 0;  // numbers of the present position
  Reference reference_ = Reference::degrees;
};

}  // namespace

Reference read_geojson(std::istream& in, FeatureSink& sink) {
  GeoJsonEvents events(sink);
  try {
    Json::sax_parse(in, &events);
  } catch (const Damaged& damaged) {
    throw Error(ErrorCode::input, fmt::format("'{}': {}", sink.file(), base::plain(damaged.reason)));
  }
  return events.reference();
}

Reference read_geojson_lines(std::istream& in, FeatureSink& sink) {
  Reference reference = Reference::degrees;
  for (std::string line; std::getline(in, line);) {
    if (!line.empty() && line.front() == '\x1E') line.erase(0, 1);  // RFC 8142
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    GeoJsonEvents events(sink);
    try {
      Json::sax_parse(line, &events);
      if (events.reference() == Reference::other) reference = Reference::other;
    } catch (const Damaged& damaged) {
      sink.refuse(damaged.reason);
    }
  }
  return reference;
}

}  // namespace quench::io
