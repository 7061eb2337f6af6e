// SPDX-License-Identifier: Apache-2.0
#include <string_view>
#include <vector>

#include "base/text.h"
#include "io/common/words.h"
#include "io/polygon/polygon_formats.h"

/// Well-known text (OGC 06-103r4), with the `SRID=...;` of PostGIS: one geometry after the other.
namespace quench::io {
namespace {

/// Why a geometry cannot be read, and where.
struct WktDamage {
  std::string reason;
};

/// Brackets, commas and other single characters, and words between them.
class WktTokens {
 public:
  explicit WktTokens(std::istream& in) : in_(*in.rdbuf()) {}

  /// The next token without taking it; empty at the end.
  const std::string& peek() {
    if (!filled_) fill();
    filled_ = true;
    return token_;
  }
  std::string next() {
    peek();
    filled_ = false;
    return token_;
  }
  bool take(std::string_view wanted) {
    if (peek() != wanted) return false;
    filled_ = false;
    return true;
  }
  void expect(char wanted) {
    if (!take(std::string_view(&wanted, 1))) fail(fmt::format("'{}' is missing", wanted));
  }
  [[noreturn]] void fail(const std::string& what) {
    const std::string at = peek().substr(0, 20);
    throw WktDamage{at.empty() ? what + " at the end" : fmt::format("{} before '{}' in line {}", what, at, line_)};
  }
  /// The rest of the line of the present token, and that.
  void skip_line() {
    for (int c = in_.sgetc(); c != kEnd && c != '\n'; c = in_.snextc()) {
    }
    filled_ = false;
  }

 private:
  static constexpr int kEnd = std::streambuf::traits_type::eof();
  static bool blank(int c) { return c == ' ' || (c >= '\t' && c <= '\r') || c == 0; }
  static bool single(int c) { return c == '(' || c == ')' || c == ',' || c == ';' || c == '='; }

  void fill() {
    token_.clear();
    int c = in_.sgetc();
    for (; c != kEnd && blank(c); c = in_.snextc()) line_ += c == '\n';
    if (c == kEnd) return;
    if (single(c)) {
      token_ = static_cast<char>(in_.sbumpc());
      return;
    }
    constexpr std::size_t longest = 1000;
    for (; c != kEnd && !blank(c) && !single(c) && token_.size() < longest; c = in_.snextc())
      token_ += static_cast<char>(c >= 'a' && c <= 'z' ? c - 'a' + 'A' : c);
  }

  std::streambuf& in_;
  std::string token_;
  bool filled_ = false;
  std::size_t line_ = 1;
};

class WktReader {
 public:
  WktReader(std::istream& in, FeatureSink& sink) : tokens_(in), sink_(sink) {}

  Reference read() {
    while (tokens_.take("\xEF\xBB\xBF") || tokens_.take(";") || tokens_.take(",")) {
    }
    while (!tokens_.peek().empty()) {
      read_feature();
      while (tokens_.take(";") || tokens_.take(",")) {
      }
    }
    return reference_;
  }

 private:
  void read_feature() {
    PolygonFeature feature;
    other_type_.clear();
    try {
      read_srid();
      read_geometry(feature.polygons, 0);
    } catch (const WktDamage& damage) {
      const std::string reason = base::plain(damage.reason);
      if (sink_.count() == 0)
        throw Error(ErrorCode::input, fmt::format("'{}' is not WKT, or damaged: {}", sink_.file(), reason));
      if (type_of(tokens_.peek()).empty() && tokens_.peek() != "SRID") tokens_.skip_line();
      return sink_.refuse(reason);
    }
    if (!feature.polygons.rings.empty()) return sink_.take(std::move(feature));
    sink_.refuse(other_type_.empty() ? "its polygon is empty"
                                     : fmt::format("its geometry is a {}, not a polygon", other_type_));
  }

  void read_srid() {
    if (!tokens_.take("SRID")) return;
    tokens_.expect('=');
    reference_ = tokens_.next() == "4326" && reference_ != Reference::other ? Reference::degrees : Reference::other;
    tokens_.expect(';');
  }

  void read_geometry(Polygons& polygons, int depth) {
    constexpr int deepest = 64;
    if (depth > deepest) tokens_.fail("geometries are nested too deep");
    const std::string type = read_type();
    if (tokens_.take("EMPTY")) return;
    if (type == "POLYGON") {
      read_polygon(polygons);
    } else if (type == "MULTIPOLYGON") {
      read_list([&] { tokens_.take("EMPTY") ? void() : read_polygon(polygons); });
    } else if (type == "GEOMETRYCOLLECTION") {
      read_list([&] { read_geometry(polygons, depth + 1); });
    } else {
      other_type_ = type;
      skip_brackets();
    }
  }

  /// The name of a geometry, without Z, M or ZM behind it; empty for another word.
  static std::string type_of(std::string word) {
    constexpr std::string_view known[] = {"POLYGON",         "MULTIPOLYGON",      "GEOMETRYCOLLECTION",
                                          "POINT",           "LINESTRING",        "MULTIPOINT",
                                          "MULTILINESTRING", "CIRCULARSTRING",    "COMPOUNDCURVE",
                                          "CURVEPOLYGON",    "MULTICURVE",        "MULTISURFACE",
                                          "TRIANGLE",        "POLYHEDRALSURFACE", "TIN"};
    for (const std::string_view end : {"M", "Z"})
      if (word.ends_with(end)) word.pop_back();
    return std::find(std::begin(known), std::end(known), word) == std::end(known) ? std::string() : word;
  }

  std::string read_type() {
    const std::string type = type_of(tokens_.peek());
    if (type.empty()) tokens_.fail("the name of a geometry, such as POLYGON, is missing");
    tokens_.next();
    tokens_.take("Z") || tokens_.take("M") || tokens_.take("ZM");
    return type;
  }

  void read_polygon(Polygons& polygons) {
    read_list([&] {
      auto& ring = polygons.rings.emplace_back();
      read_list([&] { ring.push_back(read_position()); });
    });
  }

  /// Two numbers; others are z and m.
  Vec2 read_position() {
    Vec2 position(read_number(), 0);
    position[1] = read_number();
    for (int others = 0; others < 2 && tokens_.peek() != "," && tokens_.peek() != ")"; ++others) read_number();
    return position;
  }
  double read_number() {
    double value = 0;
    if (!parse_number(tokens_.peek(), value) || !std::isfinite(value)) tokens_.fail("a number is missing");
    tokens_.next();
    return value;
  }

  void skip_brackets() {
    int depth = 0;
    do {
      depth += tokens_.peek() == "(" ? 1 : tokens_.peek() == ")" ? -1 : 0;
      if (depth == 0 && tokens_.peek() != ")") tokens_.fail("'(' is missing");
      if (tokens_.next().empty()) tokens_.fail("')' is missing");
    } while (depth > 0);
  }

  template <class Read>
  void read_list(const Read& read) {
    tokens_.expect('(');
    do read();
    while (tokens_.take(","));
    tokens_.expect(')');
  }

  WktTokens tokens_;
  FeatureSink& sink_;
  Reference reference_ = Reference::unknown;
  std::string other_type_;
};

}  // namespace

Reference read_wkt(std::istream& in, FeatureSink& sink) { return WktReader(in, sink).read(); }

}  // namespace quench::io
