// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "quench/geometry.h"

namespace quench::io {

/// The header of an NRRD file with gzip samples, up to and with its empty line. `type`: of samples. `comment`: a line.
std::string nrrd_lines(const Grid& grid, const Coordinates& coordinates, const std::string& type,
                       const std::string& comment);

}  // namespace quench::io
