// SPDX-License-Identifier: Apache-2.0
#include "batch_samples.h"

#include <fmt/format.h>
#include <glob.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <map>
#include <set>

#include "base/natural_order.h"
#include "option_checks.h"
#include "quench/error.h"
#include "quench/io.h"
#include "quench/tree.h"

namespace quench::program {
namespace {

namespace fs = std::filesystem;

// -------------------------------------------------------------------------------------------------------------- files

enum class Word { list, table, folder, pattern, file };

Word kind_of_word(const std::string& word) {
  std::error_code ignored;
  if (fs::is_directory(word, ignored)) return Word::folder;
  if (word.find_first_of("*?[") != word.npos && !fs::exists(word, ignored)) return Word::pattern;
  const std::string extension = extension_of(word);
  if (extension == ".txt" || extension == ".lst" || extension == ".list") return Word::list;
  if (extension == ".csv" || extension == ".tsv") return Word::table;
  return Word::file;
}

/// Whether Quench reads it: what is taken of a folder or of the matches of a pattern.
bool is_sample(const fs::path& file, bool trees) {
  constexpr std::string_view kPictures[] = {".png", ".bmp", ".jpg", ".jpeg", ".pbm", ".pgm", ".ppm", ".pnm"};
  if (file.filename().string().starts_with('.')) return false;
  std::error_code ignored;
  const io::Kind kind = io::kind_of(file);
  if (fs::is_directory(file, ignored)) return kind == io::Kind::volume;
  const std::string extension = extension_of(file);
  if (trees && io::is_tree_file(file)) return true;
  if (trees && (kind == io::Kind::polygons || std::ranges::find(kPictures, extension) != std::end(kPictures)))
    return false;  // of the plane
  return kind != io::Kind::unknown && extension != ".json";
}

void sort_naturally(std::vector<fs::path>& files) {
  std::ranges::sort(files, [](const auto& a, const auto& b) { return base::natural_less(a.native(), b.native()); });
}

std::vector<fs::path> files_in(const fs::path& folder, bool trees) {
  std::vector<fs::path> files;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
    if (is_sample(it->path(), trees)) files.push_back(it->path());
  if (error)
    throw Error(ErrorCode::failed, fmt::format("the folder '{}' cannot be read: {}", folder.string(), error.message()));
  sort_naturally(files);
  return files;
}

/// The matches of a pattern.
std::vector<fs::path> files_like(const std::string& pattern, bool trees) {
  glob_t found{};
  std::vector<fs::path> files;
  if (glob(pattern.c_str(), GLOB_NOSORT, nullptr, &found) == 0)
    for (std::size_t i = 0; i < found.gl_pathc; ++i)
      if (is_sample(found.gl_pathv[i], trees)) files.emplace_back(found.gl_pathv[i]);
  globfree(&found);
  if (files.empty()) throw Error(ErrorCode::failed, fmt::format("no file that Quench reads matches '{}'", pattern));
  sort_naturally(files);
  return files;
}

void check_file(const std::string& file, bool trees) {
  std::error_code ignored;
  if (!fs::exists(io::place_of_input(file), ignored)) throw Error(ErrorCode::failed, fmt::format("'{}' does not exist", file));
  if (io::kind_of(file) == io::Kind::unknown && !(trees && io::is_tree_file(file)))
    throw Error(
        ErrorCode::usage,
        fmt::format("'{}' is neither a shape that Quench reads, nor a list of them (.txt, .csv or .tsv)", file));
}

void add_files(BatchInput& input, const std::vector<std::string>& words, bool trees) {
  const auto add = [&](const fs::path& file) { input.samples.push_back({{}, file, {}, {}}); };
  for (const std::string& word : words) switch (kind_of_word(word)) {
      case Word::list:
      case Word::table:
        throw Error(ErrorCode::usage, fmt::format("the list '{}' must be given alone; put the others on it", word));
      case Word::pattern:
        std::ranges::for_each(files_like(word, trees), add);
        break;
      case Word::folder:
        if (words.size() > 1 && is_sample(word, trees)) {
          add(word);
          break;
        }
        std::ranges::for_each(files_in(word, trees), add);
        break;
      case Word::file:
        check_file(word, trees);
        add(word);
    }
}

// -------------------------------------------------------------------------------------------------------------- lists

std::ifstream opened_list(const std::string& file) {
  errno = 0;
  std::ifstream in(file, std::ios::binary);
  if (!in) throw Error(ErrorCode::failed, fmt::format("cannot open '{}': {}", file, std::strerror(errno)));
  return in;
}

fs::path relative_to_list(const std::string& list, const std::string& path) {
  return (fs::path(list).parent_path() / path).lexically_normal();
}

std::string trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r\n"), last = text.find_last_not_of(" \t\r\n");
  return first == text.npos ? std::string() : std::string(text.substr(first, last - first + 1));
}

void read_list(BatchInput& input, const std::string& list) {
  std::ifstream in = opened_list(list);
  bool first = true;
  for (std::string line; std::getline(in, line); first = false) {
    if (first && line.starts_with("\xEF\xBB\xBF")) line.erase(0, 3);
    const std::string path = trimmed(line);
    if (!path.empty() && path[0] != '#') input.samples.push_back({{}, relative_to_list(list, path), {}, {}});
  }
}

/// Words as a shell would divide the text: at blanks outside of quotes; \ takes the next character as it is.
std::vector<std::string> shell_words(const std::string& text, const std::string& where) {
  std::vector<std::string> words;
  bool inside = false;
  char quote = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    char c = text[i];
    if (quote == 0 && (c == ' ' || c == '\t')) {
      inside = false;
      continue;
    }
    if (!inside) words.emplace_back();
    inside = true;
    if (quote == 0 && (c == '\'' || c == '"')) {
      quote = c;
    } else if (c == quote) {
      quote = 0;
    } else {
      if (c == '\\' && quote != '\'' && i + 1 < text.size()) c = text[++i];
      words.back() += c;
    }
  }
  if (quote) throw Error(ErrorCode::input, fmt::format("{}: a quote is opened and not closed in its options", where));
  return words;
}

/// The separator of the header: spreadsheets of many countries write semicolons.
char separator_of(const std::string& table) {
  if (extension_of(table) == ".tsv") return '\t';
  std::string header;
  std::ifstream in = opened_list(table);
  std::getline(in, header);
  return header.find(',') == header.npos && header.find(';') != header.npos ? ';' : ',';
}

/// For comparison: some file systems take names for the same that differ in case.
std::string folded(std::string name) {
  for (char& c : name)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return name;
}

/// Names of what lies beside the samples, and of samples that have theirs already, folded.
using Taken = std::set<std::string>;
Taken names_of_outputs() { return {"samples.csv", "axes.csv", "branches.csv", "index.html"}; }

/// The name of a sample as a list has it; empty: it has none.
std::string listed_name(const std::string& cell, Taken& taken, const std::string& where) {
  const std::string name = trimmed(cell);
  const bool is_text = std::ranges::none_of(name, [](unsigned char c) { return c < ' ' || c == 127 || c == '/'; });
  if (!is_text || name.starts_with('.'))
    throw Error(ErrorCode::input, fmt::format("{}: '{}' cannot be the name of a folder; leave out '/', control "
                                              "characters, and '.' at the beginning",
                                              where, name));
  if (!name.empty() && !taken.insert(folded(name)).second)
    throw Error(ErrorCode::input, fmt::format("{}: the name '{}' is taken; give the sample another one", where, name));
  return name;
}

CsvRow columns_of(CsvRow header, const std::string& table) {
  std::error_code ignored;
  const std::string first = trimmed(header[0]);
  if (!first.empty() && fs::exists(relative_to_list(table, first), ignored))
    throw Error(ErrorCode::input,
                fmt::format("'{}' begins with the file '{}'; its first line must name the columns: file, name ...",
                            table, first));
  header.erase(header.begin());
  for (std::string& column : header) column = trimmed(column);
  for (std::size_t i = 0; i < header.size(); ++i)
    if (header[i].empty() || std::count(header.begin(), header.end(), header[i]) > 1)
      throw Error(ErrorCode::input, header[i].empty()
                                        ? fmt::format("'{}': column {} has no name in the first line", table, i + 2)
                                        : fmt::format("'{}' has two columns '{}'", table, header[i]));
  return header;
}

void read_table(BatchInput& input, const std::string& table) {
  const char separator = separator_of(table);
  std::ifstream in = opened_list(table);
  CsvReader reader(in, table, separator);
  CsvRow row;
  const auto next = [&] {
    while (reader.next(row))
      if (!row[0].starts_with('#')) return true;
    return false;
  };
  if (!next()) return;
  input.columns = columns_of(row, table);
  const auto index_of = [&](const char* name) {
    return std::ranges::find(input.columns, name) - input.columns.begin();
  };
  const auto names = static_cast<std::size_t>(index_of("name")),
             options = static_cast<std::size_t>(index_of("options"));
  Taken taken = names_of_outputs();
  while (next()) {
    const std::string where = fmt::format("'{}' line {}", table, reader.line());
    if (row.size() > input.columns.size() + 1)
      throw Error(ErrorCode::input,
                  fmt::format("{} has {} cells, the first line {}", where, row.size(), input.columns.size() + 1));
    const std::string path = trimmed(row[0]);
    if (path.empty()) throw Error(ErrorCode::input, fmt::format("{} has no path in its first column", where));
    BatchSample sample{{}, relative_to_list(table, path), {}, {row.begin() + 1, row.end()}};
    sample.listed.resize(input.columns.size());
    if (names < sample.listed.size()) sample.name = listed_name(sample.listed[names], taken, where);
    if (options < sample.listed.size()) sample.options = shell_words(sample.listed[options], where);
    input.samples.push_back(std::move(sample));
  }
}

// -------------------------------------------------------------------------------------------------------------- names

/// The file name without its extension (.nii.gz has two).
std::string stem_of(const fs::path& file) {
  const fs::path name = file.filename().empty() ? file.parent_path().filename() : file.filename();
  std::error_code ignored;
  if (fs::is_directory(file, ignored)) return name.string();
  return (extension_of(name) == ".gz" && name.stem().has_extension() ? name.stem().stem() : name.stem()).string();
}

/// Longer and longer names of a file: 0 without its extension, 1 with it, then with folder after folder before both.
std::string name_at(const fs::path& file, std::size_t level) {
  const fs::path whole = fs::absolute(file).lexically_normal();
  const fs::path last = whole.filename().empty() ? whole.parent_path() : whole;
  std::string name = level % 2 == 0 ? stem_of(file) : last.filename().string();
  fs::path folder = last.parent_path();
  for (std::size_t i = 0; i < level / 2 && folder.has_relative_path(); ++i, folder = folder.parent_path())
    name = folder.filename().string() + "_" + name;
  return name;
}

std::string as_folder_name(std::string name) {
  for (char& c : name)
    if (static_cast<unsigned char>(c) < ' ' || c == 127) c = '_';
  while (name.starts_with('.')) name.erase(0, 1);
  return name.empty() ? "sample" : name;
}

/// The least level at which the names of these files differ; 0 when none does it.
std::size_t telling_level(const std::vector<const BatchSample*>& samples) {
  std::size_t most = 1;
  for (const BatchSample* sample : samples) {
    const fs::path whole = fs::absolute(sample->file);
    most = std::max(most, 2 * static_cast<std::size_t>(std::distance(whole.begin(), whole.end())) + 1);
  }
  for (std::size_t level = 0; level <= most; ++level) {
    std::set<std::string> names;
    for (const BatchSample* sample : samples) names.insert(folded(name_at(sample->file, level)));
    if (names.size() == samples.size()) return level;
  }
  return 0;
}

void name_samples(std::vector<BatchSample>& samples) {
  std::map<std::string, std::vector<const BatchSample*>> same;
  for (const BatchSample& sample : samples)
    if (sample.name.empty()) same[folded(stem_of(sample.file))].push_back(&sample);
  std::map<std::string, std::size_t> level;
  for (const auto& [stem, those] : same) level[stem] = those.size() == 1 ? 0 : telling_level(those);

  Taken taken = names_of_outputs();
  for (const BatchSample& sample : samples)
    if (!sample.name.empty()) taken.insert(folded(sample.name));
  for (BatchSample& sample : samples) {
    if (!sample.name.empty()) continue;
    const std::string name = as_folder_name(name_at(sample.file, level[folded(stem_of(sample.file))]));
    sample.name = name;
    for (int i = 2; !taken.insert(folded(sample.name)).second; ++i) sample.name = fmt::format("{}_{}", name, i);
  }
}

}  // namespace

BatchInput read_batch(const std::vector<std::string>& words, bool trees) {
  BatchInput input;
  const Word kind = words.size() == 1 ? kind_of_word(words[0]) : Word::file;
  if (kind == Word::list)
    read_list(input, words[0]);
  else if (kind == Word::table)
    read_table(input, words[0]);
  else
    add_files(input, words, trees);
  if (input.samples.empty())
    throw Error(
        ErrorCode::input,
        fmt::format("there is no sample: '{}' {}", words[0],
                    kind == Word::list || kind == Word::table ? "names no file" : "holds no file that Quench reads"));
  name_samples(input.samples);
  return input;
}

}  // namespace quench::program
