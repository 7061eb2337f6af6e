// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>
#include <string>
#include <utility>

namespace quench {

/// What went wrong, as the program's exit code.
enum class ErrorCode : int {
  failed = 1,     ///< I/O or memory: nothing wrong with the input itself
  usage = 2,      ///< an invalid argument
  input = 3,      ///< an input that cannot be used
  invariant = 4,  ///< a promised invariant does not hold
  cancelled = 130
};

/// The only exception the library throws on purpose. what() is one sentence that names the file or the value, the
/// reason, and the way out.
///
/// field() names the parameter that is wrong or would help, as the library calls it ("spacing", "max_triangles"), or is
/// empty. Front ends have their own word for it (--max-triangles). A sentence on a value begins with the name of the
/// field and the value: "lambda '2mm' is not a length".
class Error : public std::runtime_error {
 public:
  Error(ErrorCode code, const std::string& sentence, std::string field = {})
      : std::runtime_error(sentence), code_(code), field_(std::move(field)) {}
  ErrorCode code() const noexcept { return code_; }
  const std::string& field() const noexcept { return field_; }

 private:
  ErrorCode code_;
  std::string field_;
};

}  // namespace quench
