// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace quench::base {

/// A part of a raw deflate stream, so that parts are compressed at the same time and put one behind the other: the last
/// one ends the stream, the others end at a byte. `strategy`: of zlib. Nothing when zlib cannot, for want of memory.
std::optional<std::string> deflated(std::string_view bytes, int level, int strategy, bool last);

}  // namespace quench::base
