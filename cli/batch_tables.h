// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "batch_samples.h"
#include "batch_state.h"

/// The tables of a batch, collected from the folders of its samples. They depend on the samples and their order only,
/// not on when and in which pieces the work was done.
namespace quench::program {

/// What is known of a batch; `states` has an entry per sample, and nothing for one that is not done.
struct BatchResults {
  std::filesystem::path out;
  std::string command;  ///< "tree" or "run"
  BatchInput input;
  std::vector<std::optional<SampleState>> states;

  std::filesystem::path folder_of(std::size_t sample) const { return out / input.samples[sample].name; }
  /// Whether the sample is done, without failure.
  bool is_ok(std::size_t sample) const;
  /// "ok", "failed" or "missing".
  const char* status_of(std::size_t sample) const;
};

/// Samples with a table that cannot be read have failed, with a sentence that says so; also in their folders, so that
/// the same batch makes them again. O(bytes of the tables).
void find_damaged(BatchResults& results);

/// A row per sample, in the order of the input: name, file, status and sentence, what the list says, and the figures:
/// of trees the row of traits.csv, of runs those of report.json. Samples that lack a column have an empty cell.
struct SampleTable {
  CsvRow header;
  std::vector<CsvRow> rows;
  std::size_t first_figure = 0;  ///< index of the first column of figures
};
SampleTable table_of(const BatchResults& results);
void write_table(const std::filesystem::path& file, const SampleTable& table);

/// Which table of the samples is joined to one: "axes.csv" of trees, "branches.csv" of runs.
const char* joined_file(const std::string& command);
/// Writes it: the rows of all samples, the name of the sample first; the union of their columns. Returns the number of
/// rows. Memory: a row.
std::size_t write_joined(const BatchResults& results);

}  // namespace quench::program
