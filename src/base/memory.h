// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

namespace quench::base {

/// Memory that is free now, in bytes, with what the system can free at once.
std::int64_t available_memory();

/// Memory this process holds now, in bytes, once it has given back what it does not use; 0 where the system does not
/// say.
std::int64_t held_memory();

/// The most memory this process has held so far, in bytes.
std::int64_t peak_memory();

/// "3.5 GB", "81 MB", "1.0 KB", "12 bytes".
std::string bytes_text(std::int64_t bytes);

}  // namespace quench::base
