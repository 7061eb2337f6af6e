// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace quench::base {

/// Whether somebody looks at stderr.
bool stderr_is_terminal();

/// A caller may close stdin, stdout or stderr; the first files opened would take their numbers, and messages would be
/// written into them. To be called first of all.
void keep_standard_streams();

/// Writing beyond a limit of the size of files, or to a pipe that nobody reads, is then an error of the writer, which
/// tidies up, and not the end of the process.
void let_writers_see_errors();

}  // namespace quench::base
