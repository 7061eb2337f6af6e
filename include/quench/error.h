// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>
#include <string>

namespace quench {

/// What went wrong, as the program's exit code.
enum class ErrorCode : int {
  failed = 1,     ///< I/O or memory: nothing wrong with the input itself
  usage = 2,      ///< an option that cannot be
  input = 3,      ///< an input that cannot be used
  invariant = 4,  ///< a promised invariant does not hold
  cancelled = 130
};

/// The only exception the library throws on purpose. what() is one sentence that names the file or the value, the
/// reason, and the way out.
class Error : public std::runtime_error {
 public:
  Error(ErrorCode code, const std::string& sentence) : std::runtime_error(sentence), code_(code) {}
  ErrorCode code() const noexcept { return code_; }

 private:
  ErrorCode code_;
};

}  // namespace quench
