// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "batch_tables.h"

namespace quench::program {

/// Writes the contact sheet of a batch: a page with a card per sample (picture, main figures, links to its page and
/// files) and the table of the samples, both sorted by any column. Pictures and pages are those in the folders of the
/// samples beside it; nothing else is fetched. `command`: as it is typed for one sample.
void write_contact_sheet(const std::filesystem::path& file, const BatchResults& results, const SampleTable& table,
                         const std::string& command);

}  // namespace quench::program
