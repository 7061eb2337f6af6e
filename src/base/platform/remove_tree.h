// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace quench::base {

/// Removes a file, a link, or a folder with all that is in it; what is absent or may not be removed stays. System calls
/// only: for the end of the process, when memory and locks may be out of reach. The depth of folders is that of the
/// recursion, 8 KB each.
void remove_tree(const char* path) noexcept;

}  // namespace quench::base
