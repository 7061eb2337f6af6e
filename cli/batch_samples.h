// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "csv.h"

namespace quench::program {

/// A sample of a batch.
struct BatchSample {
  std::string name;                  ///< of its folder: unique, also where case does not count
  std::filesystem::path file;        ///< relative to the working folder, as the user would name it
  std::vector<std::string> options;  ///< of this sample alone
  CsvRow listed;                     ///< what the list says about it: a cell per column
};

struct BatchInput {
  CsvRow columns;  ///< of the list, but for its path; empty where there is no list with columns
  std::vector<BatchSample> samples;
};

/// The samples that the words of a command line name: files; folders; patterns with * ? [ ]; or one list.
///
/// A folder that is named alone stands for the files in it that Quench reads as shapes (`trees`: or as trees), and for
/// the folders in it that hold slices, in natural order; hidden ones, .json (seldom polygons) and, of trees, what is
/// of the plane left out. Beside
/// others, or as a match of a pattern, a folder of slices is a sample itself.
///
/// A list is a .txt, .lst or .list file with a path per line, or a .csv or .tsv file whose first column holds paths,
/// under a header. Paths are relative to the list; lines that begin with # are comments. The column `name` names
/// samples, `options` holds options of their own.
///
/// Names are those of the files without extension. Where several agree they become, for all of these, the first that
/// tells them apart: the file name, folder_name, folder_file name, and so on outwards; files that are the same get
/// _2, _3 ... in their order.
///
/// Throws Error(usage, input or failed) where there is no sample, or for what cannot be one.
BatchInput read_batch(const std::vector<std::string>& words, bool trees);

}  // namespace quench::program
