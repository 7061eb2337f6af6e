// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ostream>

#include "base/deflated.h"
#include "page/layer.h"
#include "page/pack.h"
#include "quench/error.h"
#include "quench/io.h"

namespace quench {
namespace {

using page::PackedArray;

// Strings of a browser have at most 2^29 - 24 characters.
constexpr std::size_t kMostCharacters = (std::size_t{1} << 29) - 24;
constexpr int kLevel = 6;
constexpr std::size_t kBlock = std::size_t{1} << 20;

/// A piece of text as JSON that is safe inside a script element: `<` is written as its number, bytes that are not
/// UTF-8 as the replacement character.
std::string json_string(std::string_view text) {
  std::string out = "\"";
  for (std::size_t i = 0; i < text.size();) {
    const auto c = static_cast<unsigned char>(text[i]);
    if (c == '"' || c == '\\') {
      out += '\\';
      out += text[i++];
    } else if (c < 0x20 || c == '<' || c == 0x7F) {
      out += fmt::format("\\u{:04x}", c);
      ++i;
    } else if (c < 0x80) {
      out += text[i++];
    } else {
      const std::size_t more = c >= 0xF0 && c < 0xF5 ? 3 : c >= 0xE0 ? 2 : c >= 0xC2 && c < 0xE0 ? 1 : 0;
      bool good = more > 0 && c < 0xF5 && i + more < text.size();
      for (std::size_t k = 1; good && k <= more; ++k) good = (static_cast<unsigned char>(text[i + k]) & 0xC0) == 0x80;
      out += good ? text.substr(i, more + 1) : std::string_view("\\ufffd");
      i += good ? more + 1 : 1;
    }
  }
  return out + '"';
}

std::string number(double value) { return std::isfinite(value) ? fmt::format("{}", value) : "null"; }

std::string list(std::span<const double> values) {
  std::string out = "[";
  for (const double v : values) out += (out.size() > 1 ? ", " : "") + number(v);
  return out + "]";
}

std::string json_of(const std::vector<PageColumn>& list) {
  std::string columns;
  for (const PageColumn& c : list) {
    columns += fmt::format(R"({}{{"table": {}, "name": {}, "unit": {}, "meaning": {})", columns.empty() ? "" : ",\n",
                           json_string(c.table), json_string(c.name), json_string(c.unit), json_string(c.meaning));
    if (c.whole) columns += R"(, "whole": true)";
    std::string words;
    for (const std::string& word : c.words) words += (words.empty() ? "" : ", ") + json_string(word);
    if (!words.empty()) columns += fmt::format(R"(, "words": [{}])", words);
    columns += "}";
  }
  return columns;
}

std::string json_of(const PageTree& tree) {
  return fmt::format(R"({{"down": {}, "to_eye": {}, "up": {}, "columns": [
{}]}})",
                     list({tree.down.data(), 3}), list({tree.to_eye.data(), 3}), list({tree.up.data(), 3}),
                     json_of(tree.columns));
}

std::string meta_of(const Page& page, const std::vector<PackedArray>& packed) {
  std::vector<std::string> members;
  const auto put = [&](const char* name, const std::string& json) {
    members.push_back(fmt::format("{}: {}", json_string(name), json));
  };
  put("format", "2");
  put("title", json_string(page.title));
  put("program", json_string(page.program));
  put("command", json_string(page.command));
  if (!page.state.empty()) put("state", json_string(page.state));
  put("unit", json_string(page.unit));
  put("side", number(page.side));
  if (page.voxel > 0) put("voxel", number(page.voxel));
  put("low", list({page.low.data(), 3}));
  put("high", list({page.high.data(), 3}));
  if (page.plane) {
    put("dimension", "2");
    put("y_axis", json_string(page.y_down ? "down" : "up"));
  }
  if (page.voxel_surface) put("surface", json_string("voxels"));
  if (page.origin != Vec3::Zero()) put("origin", list({page.origin.data(), 3}));
  const auto put_length = [&](const char* name, const std::optional<double>& length) {
    if (length) put(name, number(base::rounded_down(*length)));
  };
  if (page.pruning)
    put("pruning", fmt::format(R"({{"measure": {}, "threshold": {}}})", json_string(page.pruning->measure),
                               number(page.pruning->threshold)));
  if (page.burning)
    put("burning",
        fmt::format(R"({{"omega": {}, "propagation": "{}", "radius": "{}"}})", number(page.burning->omega),
                    page.burning->propagation == Propagation::windows ? "windows" : "segments",
                    page.burning->radius == RadiusRule::linear ? "linear" : "exact"));
  put_length("theta2", page.theta2);
  put_length("theta1", page.theta1);
  if (page.theta1_radii > 0) put("theta1_radii", number(page.theta1_radii));
  std::string floors;
  const auto put_floor = [&](const char* name, const std::optional<double>& floor) {
    if (floor) floors += fmt::format("{}\"{}\": {}", floors.empty() ? "" : ", ", name, number(*floor));
  };
  put_floor("theta2", page.theta2_floor);
  put_floor("theta1", page.theta1_floor);
  put("floor", "{" + floors + "}");
  std::string measures;
  for (const PageMeasure& m : page.measures)
    measures += fmt::format(R"({}{{"name": {}, "floor": {}}})", measures.empty() ? "" : ", ", json_string(m.name),
                            number(m.floor));
  if (!measures.empty()) put("measures", "[" + measures + "]");
  if (page.topology) {
    const auto& t = *page.topology;
    put("topology",
        fmt::format(R"({{"euler": {}, "betti": [{}, {}, {}]}})", t.euler, t.betti[0], t.betti[1], t.betti[2]));
  }
  std::string notes, files, arrays;
  for (const std::string& note : page.notes) notes += (notes.empty() ? "" : ", ") + json_string(note);
  if (!page.note.empty()) put("note", json_string(page.note));
  put("notes", "[" + notes + "]");
  for (const auto& [what, name] : page.files)
    files += (files.empty() ? "" : ", ") + json_string(what) + ": " + json_string(name);
  put("files", "{" + files + "}");
  if (page.sites_to_world) put("sites_to_world", list(*page.sites_to_world));
  if (page.tree) put("tree", json_of(*page.tree));
  if (!page.columns.empty()) put("columns", "[\n" + json_of(page.columns) + "]");
  std::size_t offset = 0;
  for (const PackedArray& array : packed) {
    arrays += fmt::format(R"({}{{"name": {}, "type": "{}", "components": {}, "count": {}, "offset": {}{}{}}})",
                          arrays.empty() ? "" : ",\n", json_string(array.name), array.type, array.components,
                          array.rows, offset, array.code.empty() ? "" : ", ", array.code);
    offset += (array.bytes.size() + 3) / 4 * 4;
  }
  put("arrays", "[\n" + arrays + "]");
  std::string json;
  for (const std::string& member : members) json += (json.empty() ? "{" : ",\n") + member;
  return json + "}";
}

/// All arrays one after the other, as one gzip member: deflated block by block, so that threads share the work and the
/// bytes do not depend on their number.
std::string zipped(const std::vector<PackedArray>& packed) {
  std::string raw;
  std::size_t size = 0;
  for (const PackedArray& array : packed) size += (array.bytes.size() + 3) / 4 * 4;
  raw.reserve(size);
  for (const PackedArray& array : packed) {
    raw += array.bytes;
    while (raw.size() % 4 != 0) raw += '\0';
  }
  const std::size_t blocks = std::max<std::size_t>(1, (raw.size() + kBlock - 1) / kBlock);
  std::vector<std::optional<std::string>> deflated(blocks);
  std::vector<uLong> check(blocks);
  tbb::parallel_for(std::size_t{0}, blocks, [&](std::size_t b) {
    const std::string_view part = std::string_view(raw).substr(b * kBlock, kBlock);
    check[b] = crc32(0, reinterpret_cast<const Bytef*>(part.data()), static_cast<uInt>(part.size()));
    deflated[b] = base::deflated(part, kLevel, Z_DEFAULT_STRATEGY, b + 1 == blocks);
  });
  if (std::find(deflated.begin(), deflated.end(), std::nullopt) != deflated.end())
    throw Error(ErrorCode::failed, "zlib cannot compress the data of the page: not enough memory");
  std::string out("\x1f\x8b\x08\0\0\0\0\0\0\xff", 10);
  uLong crc = 0;
  for (std::size_t b = 0; b < blocks; ++b) {
    out += *deflated[b];
    const std::size_t length = std::min(kBlock, raw.size() - std::min(raw.size(), b * kBlock));
    crc = crc32_combine(crc, check[b], static_cast<z_off_t>(length));
  }
  for (const std::size_t word : {static_cast<std::size_t>(crc), raw.size()})
    for (int shift = 0; shift < 32; shift += 8) out += static_cast<char>(word >> shift & 0xFF);
  return out;
}

std::string base64(std::string_view bytes) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out((bytes.size() + 2) / 3 * 4, '=');
  for (std::size_t i = 0, o = 0; i < bytes.size(); i += 3, o += 4) {
    const auto at = [&](std::size_t k) -> std::uint32_t {
      return k < bytes.size() ? static_cast<unsigned char>(bytes[k]) : 0;
    };
    const std::uint32_t word = at(i) << 16 | at(i + 1) << 8 | at(i + 2);
    out[o] = kDigits[word >> 18];
    out[o + 1] = kDigits[word >> 12 & 63];
    if (i + 1 < bytes.size()) out[o + 2] = kDigits[word >> 6 & 63];
    if (i + 2 < bytes.size()) out[o + 3] = kDigits[word & 63];
  }
  return out;
}

/// Where the data is inserted: in place of the comment made for it, else right after the opening body tag.
std::pair<std::size_t, std::size_t> place_of_data(std::string_view program) {
  constexpr std::string_view kMarker = "<!--quench-data-->";
  if (const std::size_t at = program.find(kMarker); at != std::string_view::npos) return {at, at + kMarker.size()};
  if (const std::size_t body = program.find("<body"); body != std::string_view::npos)
    if (const std::size_t end = program.find('>', body); end != std::string_view::npos) return {end + 1, end + 1};
  throw Error(ErrorCode::invariant, "the program of the page has no body to put the data in");
}

}  // namespace

const PageArray* Page::find(std::string_view name) const {
  for (const PageArray& array : arrays)
    if (array.name == name) return &array;
  return nullptr;
}

void write_page(const std::filesystem::path& file, const Page& page, std::string_view page_program) {
  const auto place = place_of_data(page_program);
  const std::vector<PackedArray> packed = page::packed(page);
  const std::string meta = meta_of(page, packed), data = base64(zipped(packed));
  if (data.size() > kMostCharacters)
    throw Error(
        ErrorCode::failed,
        fmt::format("the page '{}' would be larger than a browser can read; use fewer triangles", file.string()),
        "max_triangles");
  io::write_atomically(file, [&](std::ostream& out) {
    out << page_program.substr(0, place.first) << "<script type=\"application/json\" id=\"quench-meta\">" << meta
        << "</script>\n<script type=\"application/octet-stream\" id=\"quench-data\">" << data << "</script>"
        << page_program.substr(place.second);
  });
}

}  // namespace quench
