// SPDX-License-Identifier: Apache-2.0
#include "dual/bricks/part_bytes.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cstring>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "base/packed_numbers.h"
#include "quench/error.h"

namespace quench::dual::bricks {
namespace {

using base::NumberPacker;
using base::NumberReader;

constexpr std::uint32_t kVersion = 1;

// In the byte order of the machine, which all that work on one plan share.
struct Header {
  char magic[8] = {'q', 'u', 'e', 'n', 'c', 'h', 'p', 't'};
  std::uint32_t version = kVersion, round = 0, brick = 0, head_crc = 0;
  std::uint64_t plan = 0, head_bytes = 0;
  std::uint32_t body_crc = 0, header_crc = 0;  // the latter of all before it

  std::uint32_t crc() const;
};
static_assert(sizeof(Header) == kPartHeader);

std::uint32_t crc_of(std::string_view bytes) {
  return static_cast<std::uint32_t>(crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

std::uint32_t Header::crc() const {
  return crc_of({reinterpret_cast<const char*>(this), offsetof(Header, header_crc)});
}

Header header_of(std::string_view bytes, const PartLabel& label) {
  Header header;
  if (bytes.size() < sizeof header || std::memcmp(bytes.data(), header.magic, sizeof header.magic) != 0)
    throw Error(ErrorCode::input, "it is not a part of a core, or is cut off");
  std::memcpy(static_cast<void*>(&header), bytes.data(), sizeof header);
  if (header.version != kVersion)
    throw Error(ErrorCode::input, fmt::format("it has version {} of the format, this is a program for version {}",
                                              header.version, kVersion));
  if (header.header_crc != header.crc()) NumberReader::damaged();
  if (PartLabel{header.plan, header.round, header.brick} != label)
    throw Error(ErrorCode::input, "it belongs to another plan or another place in it");
  return header;
}

std::string_view head_in(std::string_view bytes, const Header& header) {
  bytes.remove_prefix(sizeof header);
  if (bytes.size() < header.head_bytes || crc_of(bytes.substr(0, header.head_bytes)) != header.head_crc)
    NumberReader::damaged();
  return bytes.substr(0, header.head_bytes);
}

double or_none(const std::vector<double>& values, std::size_t i) { return i < values.size() ? values[i] : -1; }

// Two values each of the few that have any, with how many others lie before.
void add_values(NumberPacker& to, std::size_t count, const std::vector<double>& lambda,
                const std::vector<double>& detail) {
  std::size_t next = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (or_none(lambda, i) == -1 && or_none(detail, i) == -1) continue;
    to.add(i - next + 1);
    to.add_double(or_none(lambda, i));
    to.add_double(or_none(detail, i));
    next = i + 1;
  }
  to.add(0);
}

// None where there are none.
void take_values(NumberReader& from, std::size_t count, std::vector<double>& lambda, std::vector<double>& detail) {
  for (std::size_t next = 0; const std::uint64_t skip = from.next_up_to(count - next);) {
    if (lambda.empty()) {
      lambda.assign(count, -1);
      detail.assign(count, -1);
    }
    next += skip;
    lambda[next - 1] = from.next_double();
    detail[next - 1] = from.next_double();
  }
}

// The hulls that occur, in order of the first polytope that has them, and the place of each polytope's among them.
void add_hulls(NumberPacker& to, const Cells& cells, const Hulls& hulls) {
  std::unordered_map<std::uint32_t, std::uint32_t> place;
  std::vector<std::uint32_t> used;
  for (const std::uint32_t id : cells.hull)
    if (place.emplace(id, static_cast<std::uint32_t>(used.size())).second) used.push_back(id);
  to.add(used.size());
  for (const std::uint32_t id : used) {
    const Hull& hull = hulls[id];
    to.add(hull.corners);
    to.add(hull.facets());
    for (std::uint32_t f = 0; f < hull.facets(); ++f) {
      to.add(hull.corners_of(f).size());
      for (const std::uint32_t c : hull.corners_of(f)) to.add(c);
    }
  }
  to.add(cells.count());
  for (const std::uint32_t id : cells.hull) to.add(place[id]);
}

std::vector<std::uint32_t> take_hulls(NumberReader& from, Hulls& hulls) {
  std::vector<std::uint32_t> used(from.next_count());
  for (std::uint32_t& id : used) {
    const std::size_t corners = from.next_count();
    std::vector<HullFacet> facets(from.next_count());
    for (HullFacet& facet : facets) {
      facet.corners.resize(from.next_count());
      if (facet.corners.size() < 3) NumberReader::damaged();
      for (std::uint32_t& c : facet.corners) {
        c = static_cast<std::uint32_t>(from.next());
        if (c >= corners) NumberReader::damaged();
      }
    }
    if (facets.size() < 4) NumberReader::damaged();
    sort_facets(facets);
    id = hulls.intern(static_cast<std::uint32_t>(corners), facets);
  }
  std::vector<std::uint32_t> hull(from.next_count());
  for (std::uint32_t& id : hull) {
    const std::uint64_t place = from.next();
    if (place >= used.size()) NumberReader::damaged();
    id = used[place];
  }
  return hull;
}

void add_polytopes(NumberPacker& to, const Cells& cells) {
  std::int64_t first = 0;
  for (std::uint32_t p = 0; p < cells.count(); ++p) {
    const auto sites = cells.sites_of(p);
    to.add_signed(sites[0] - first);
    first = sites[0];
    for (std::size_t i = 1; i < sites.size(); ++i) to.add(sites[i] - sites[i - 1]);
    for (const std::uint32_t n : cells.neighbours_of(p)) {
      if (n >= kPruned)
        to.add(kNone - n);
      else
        to.add((static_cast<std::uint64_t>(n > p ? n - p : p - n) << 1 | (n > p)) + 3);
    }
  }
}

void take_polytopes(NumberReader& from, std::size_t site_count, std::span<const std::uint32_t> hull_of,
                    const Hulls& hulls, Cells& cells) {
  std::vector<std::uint32_t> corners;
  std::int64_t first = 0;
  for (const std::uint32_t id : hull_of) {
    const Hull& hull = hulls[id];
    corners.clear();
    first += from.next_signed();
    std::uint64_t site = static_cast<std::uint64_t>(first);
    for (std::uint32_t i = 0; i < hull.corners; ++i) {
      if (i > 0) site += from.next_up_to(site_count);
      if (site >= site_count) NumberReader::damaged();
      corners.push_back(static_cast<std::uint32_t>(site));
    }
    const std::uint32_t p = cells.add(corners, id, hull.facets());
    for (std::uint32_t& n : cells.neighbours_of(p)) {
      const std::uint64_t code = from.next();
      if (code < 3) {
        n = static_cast<std::uint32_t>(kNone - code);
        continue;
      }
      const std::uint64_t step = (code - 3) >> 1, to = (code - 3) & 1 ? p + step : p - step;
      if (to >= hull_of.size()) NumberReader::damaged();
      n = static_cast<std::uint32_t>(to);
    }
  }
}

void add_squares(NumberPacker& to, const CellsPart& found) {
  std::vector<Square> squares;
  for (const UnmatchedFacet& f : found.unmatched)
    if (f.polytope == kNone) squares.push_back(found.squares[f.facet]);
  to.add(squares.size());
  std::int64_t last = 0;
  for (const Square& square : squares)
    for (const std::uint32_t s : square) {
      to.add_signed(s - last);
      last = s;
    }
}

void take_squares(NumberReader& from, std::size_t site_count, std::vector<Square>& squares) {
  squares.resize(from.next_count());
  std::int64_t last = 0;
  for (Square& square : squares)
    for (std::uint32_t& s : square) {
      last += from.next_signed();
      if (last < 0 || last >= static_cast<std::int64_t>(site_count)) NumberReader::damaged();
      s = static_cast<std::uint32_t>(last);
    }
}

// They follow from the rest; in order of their sites.
void list_unmatched(CellsPart& found, const Hulls& hulls) {
  for (std::uint32_t p = 0; p < found.cells.count(); ++p) {
    const auto neighbours = found.cells.neighbours_of(p);
    for (std::uint32_t f = 0; f < neighbours.size(); ++f)
      if (neighbours[f] == kUnmatched)
        found.unmatched.push_back({key_of(hulls[found.cells.hull[p]], f, found.cells.sites_of(p)), p, f});
  }
  for (std::uint32_t s = 0; s < found.squares.size(); ++s) {
    FacetKey key;
    std::ranges::partial_sort_copy(found.squares[s], key);
    found.unmatched.push_back({key, kNone, s});
  }
  std::ranges::sort(found.unmatched, {}, [](const UnmatchedFacet& f) { return std::tuple(f.key, f.polytope); });
}

void add_bits(NumberPacker& to, std::span<const std::uint8_t> bits) {
  for (std::size_t i = 0; i < bits.size(); i += 8) {
    unsigned byte = 0;
    for (std::size_t k = 0; k < 8 && i + k < bits.size(); ++k) byte |= (bits[i + k] ? 1u : 0u) << k;
    to.bytes.push_back(static_cast<char>(byte));
  }
}

void take_bits(NumberReader& from, std::vector<std::uint8_t>& bits) {
  for (std::size_t i = 0; i < bits.size(); i += 8) {
    const unsigned byte = from.next_byte();
    for (std::size_t k = 0; k < 8 && i + k < bits.size(); ++k) bits[i + k] = byte >> k & 1;
  }
}

void add_faces(NumberPacker& to, const std::vector<FaceValue>& faces) {
  to.add(faces.size());
  std::int64_t last = 0;
  for (const FaceValue& face : faces) {
    to.add_signed(face.sites[0] - last);
    to.add(std::uint64_t{face.sites[1] - face.sites[0]} << 1 | (face.final ? 1 : 0));
    to.add_double(face.value);
    last = face.sites[0];
  }
}

void take_faces(NumberReader& from, std::size_t site_count, std::vector<FaceValue>& faces) {
  faces.resize(from.next_count());
  std::int64_t last = 0;
  for (FaceValue& face : faces) {
    last += from.next_signed();
    const std::uint64_t rest = from.next();
    const std::uint64_t other = static_cast<std::uint64_t>(last) + (rest >> 1);
    if (last < 0 || rest >> 1 >= site_count || other >= site_count) NumberReader::damaged();
    face = {{static_cast<std::uint32_t>(last), static_cast<std::uint32_t>(other)}, from.next_double(), (rest & 1) != 0};
  }
}

void add_unfinished(NumberPacker& to, const Unfinished& unfinished) {
  to.add_points(unfinished.sites);
  to.add(unfinished.size());
  std::int64_t last = 0;
  for (std::size_t f = 0; f < unfinished.size(); ++f) {
    const auto corners = unfinished.corners_of(f);
    to.add(corners.size());
    for (const std::uint32_t c : corners) {
      to.add_signed(c - last);
      last = c;
    }
  }
}

Unfinished take_unfinished(NumberReader& from) {
  Unfinished unfinished;
  unfinished.sites = from.next_points();
  std::int64_t last = 0;
  for (std::size_t facets = from.next_count(); facets > 0; --facets) {
    for (std::size_t corners = from.next_count(); corners > 0; --corners) {
      last += from.next_signed();
      if (last < 0 || last >= static_cast<std::int64_t>(unfinished.sites.size())) NumberReader::damaged();
      unfinished.corners.push_back(static_cast<std::uint32_t>(last));
    }
    unfinished.begin.push_back(static_cast<std::uint32_t>(unfinished.corners.size()));
  }
  return unfinished;
}

std::string head_of(const Part& part, const Hulls& hulls) {
  NumberPacker to;
  add_unfinished(to, unfinished(part, hulls));
  to.add_points(part.pending);
  return std::move(to.bytes);
}

std::string body_of(const Part& part, const Hulls& hulls) {
  const Cells& cells = part.found.cells;
  NumberPacker to;
  to.add_points(part.sites);
  add_hulls(to, cells, hulls);
  add_polytopes(to, cells);
  add_squares(to, part.found);
  add_values(to, cells.neighbours.size(), part.link_lambda, part.link_detail);
  add_values(to, cells.count(), part.vertex_lambda, part.vertex_detail);
  to.add(part.contact.size());
  add_bits(to, part.contact);
  add_faces(to, part.faces);
  to.add(part.pruned.vertices);
  to.add(part.pruned.edges);
  to.add(part.pruned.faces);
  return std::move(to.bytes);
}

LooseEnds loose_in(std::string_view head) {
  NumberReader from(head);
  LooseEnds loose;
  loose.unfinished = take_unfinished(from);
  loose.pending = from.next_points();
  return loose;
}

Part part_in(std::string_view body, Hulls& hulls) {
  NumberReader from(body);
  Part part;
  Cells& cells = part.found.cells;
  part.sites = from.next_points();
  const std::vector<std::uint32_t> hull_of = take_hulls(from, hulls);
  take_polytopes(from, part.sites.size(), hull_of, hulls, cells);
  take_squares(from, part.sites.size(), part.found.squares);
  list_unmatched(part.found, hulls);
  take_values(from, cells.neighbours.size(), part.link_lambda, part.link_detail);
  take_values(from, cells.count(), part.vertex_lambda, part.vertex_detail);
  part.contact.resize(from.next_up_to(cells.sites.size()));
  take_bits(from, part.contact);
  if (!part.contact.empty()) part.extend();
  take_faces(from, part.sites.size(), part.faces);
  part.pruned.vertices = from.next();
  part.pruned.edges = from.next();
  part.pruned.faces = from.next();
  if (!from.at_end()) NumberReader::damaged();
  return part;
}

}  // namespace

std::string encode(const Part& part, const Hulls& hulls, const PartLabel& label) {
  const std::string head = head_of(part, hulls), body = body_of(part, hulls);
  Header header;
  header.round = label.round;
  header.brick = label.brick;
  header.plan = label.plan;
  header.head_bytes = head.size();
  header.head_crc = crc_of(head);
  header.body_crc = crc_of(body);
  header.header_crc = header.crc();
  std::string bytes;
  bytes.reserve(sizeof header + head.size() + body.size());
  bytes.append(reinterpret_cast<const char*>(&header), sizeof header);
  return bytes.append(head).append(body);
}

Part decode(std::string_view bytes, Hulls& hulls, const PartLabel& label) {
  const Header header = header_of(bytes, label);
  const std::string_view head = head_in(bytes, header);
  const std::string_view body = bytes.substr(sizeof header + head.size());
  if (crc_of(body) != header.body_crc) NumberReader::damaged();
  Part part = part_in(body, hulls);
  part.pending = loose_in(head).pending;
  return part;
}

std::size_t loose_bytes(std::string_view header, const PartLabel& label) {
  return sizeof(Header) + header_of(header, label).head_bytes;
}

LooseEnds decode_loose(std::string_view bytes, const PartLabel& label) {
  return loose_in(head_in(bytes, header_of(bytes, label)));
}

}  // namespace quench::dual::bricks
