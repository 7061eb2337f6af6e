// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

namespace quench {

/// Memory that is free now, in bytes, with what the system can free at once.
std::int64_t available_memory();

/// "3.5 GB", "81 MB", "1.0 KB", "12 bytes".
std::string bytes_text(std::int64_t bytes);

}  // namespace quench
