// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "dual/bricks/part.h"

/// Parts as bytes, for files and messages: what other boxes ask for comes first, then the rest. The same part gives the
/// same bytes. Some 30 bytes per polytope; numbers are differences of 7 bits per byte, checksums are CRC-32.
namespace quench::dual::bricks {

/// Which part it is, so that none is taken for another.
struct PartLabel {
  std::uint64_t plan = 0;  ///< a fingerprint of the plan that it belongs to
  std::uint32_t round = 0, brick = 0;
  friend bool operator==(const PartLabel&, const PartLabel&) = default;
};

/// What other boxes need of a part.
struct LooseSites {
  std::vector<LatticePoint> unfinished;  ///< unfinished_sites()
  std::vector<LatticePoint> pending;     ///< Part::pending
};

std::string encode(const Part& part, const Hulls& hulls, const PartLabel& label);

/// The part again; its hulls are found in `hulls` or added. Throws Error(input), "it ...", when the bytes are not
/// those of the part with this label.
Part decode(std::string_view bytes, Hulls& hulls, const PartLabel& label);

inline constexpr std::size_t kPartHeader = 48;  ///< bytes that loose_bytes() needs
/// How many of the first bytes decode_loose() needs. Throws as decode().
std::size_t loose_bytes(std::string_view header, const PartLabel& label);
LooseSites decode_loose(std::string_view bytes, const PartLabel& label);

}  // namespace quench::dual::bricks
