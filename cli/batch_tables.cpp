// SPDX-License-Identifier: Apache-2.0
#include "batch_tables.h"

#include <algorithm>
#include <fstream>
#include <map>
#include <ostream>

#include "quench/io.h"

namespace quench::program {
namespace {

namespace fs = std::filesystem;

/// Columns of several tables, in the order in which they come up.
class Columns {
 public:
  std::size_t index_of(const std::string& name) {
    const auto [found, is_new] = index_.emplace(name, names_.size());
    if (is_new) names_.push_back(name);
    return found->second;
  }
  bool has(const std::string& name) const { return index_.contains(name); }
  const CsvRow& names() const { return names_; }

 private:
  CsvRow names_;
  std::map<std::string, std::size_t> index_;
};

using Figures = std::vector<std::pair<std::string, std::string>>;  // column and cell

Figures figures_of_table(const fs::path& file) {
  Figures figures;
  std::ifstream in(file, std::ios::binary);
  CsvReader reader(in, file.string());
  CsvRow header, row;
  if (!in || !reader.next(header) || !reader.next(row)) return {};
  for (std::size_t i = 0; i < std::min(header.size(), row.size()); ++i) figures.emplace_back(header[i], row[i]);
  return figures;
}

/// What a report of `quench run` says in numbers.
Figures figures_of_report(const fs::path& file) {
  constexpr struct {
    const char *column, *place;
  } kFigures[] = {{"voxels", "/shape/voxels"},
                  {"pixels", "/shape/pixels"},
                  {"components", "/shape/betti/0"},
                  {"tunnels", "/shape/betti/1"},
                  {"cavities", "/shape/betti/2"},
                  {"detail", "/pruned/detail"},
                  {"lambda", "/pruned/lambda"},
                  {"theta2", "/skeleton/theta2"},
                  {"theta1", "/skeleton/theta1"},
                  {"sheets", "/skeleton/sheets"},
                  {"branches", "/skeleton/branches"},
                  {"ends", "/skeleton/ends"},
                  {"junctions", "/skeleton/junctions"},
                  {"curve_length", "/skeleton/curve_length"},
                  {"reconstructed", "/skeleton/reconstructed"}};
  std::ifstream in(file, std::ios::binary);
  const Json report = Json::parse(in, nullptr, false);
  Figures figures;
  if (report.is_discarded()) return figures;
  for (const auto& [column, place] : kFigures)
    if (const Json::json_pointer pointer(place); report.contains(pointer)) {
      const Json& value = report.at(pointer);
      figures.emplace_back(column, value.is_string() ? value.get<std::string>() : value.dump());
    }
  return figures;
}

Figures figures_of(const BatchResults& results, std::size_t sample) {
  if (!results.is_ok(sample)) return {};
  const fs::path folder = results.folder_of(sample);
  return results.command == "run" ? figures_of_report(folder / "report.json") : figures_of_table(folder / "traits.csv");
}

/// The columns of a list as they are called beside others of the same name.
CsvRow listed_columns(const BatchInput& input, const Columns& figures) {
  CsvRow columns = input.columns;
  for (std::string& column : columns)
    while (column == "file" || column == "status" || column == "sentence" || figures.has(column))
      column = "listed_" + column;
  return columns;
}

}  // namespace

bool BatchResults::is_ok(std::size_t sample) const {
  return states[sample] && states[sample]->status == SampleState::Status::ok;
}

const char* BatchResults::status_of(std::size_t sample) const {
  return is_ok(sample) ? "ok" : states[sample] ? "failed" : "missing";
}

void find_damaged(BatchResults& results) {
  for (std::size_t i = 0; i < results.states.size(); ++i) {
    if (!results.is_ok(i)) continue;
    std::vector<std::string> tables{joined_file(results.command)};
    if (results.command == "tree") tables.emplace_back("traits.csv");
    try {
      for (const std::string& table : tables) {
        const fs::path file = results.folder_of(i) / table;
        std::ifstream in(file, std::ios::binary);
        CsvReader reader(in, file.string());
        CsvRow row;
        while (in && reader.next(row)) {
        }
      }
    } catch (const Error& error) {
      SampleState& state = *results.states[i];
      state.status = SampleState::Status::failed;
      state.code = static_cast<int>(ErrorCode::failed);
      state.sentence = error.what();
      write_state(results.folder_of(i), state);
    }
  }
}

SampleTable table_of(const BatchResults& results) {
  const BatchInput& input = results.input;
  Columns columns;
  std::vector<Figures> figures;
  for (std::size_t i = 0; i < input.samples.size(); ++i) {
    figures.push_back(figures_of(results, i));
    for (const auto& [column, cell] : figures.back()) columns.index_of(column);
  }

  SampleTable table;
  table.header = {"name", "file", "status", "sentence"};
  const auto names = std::ranges::find(input.columns, "name") - input.columns.begin();  // the first column already
  const auto without_names = [&](CsvRow row) {
    if (static_cast<std::size_t>(names) < row.size()) row.erase(row.begin() + names);
    return row;
  };
  const auto append = [](CsvRow& row, const CsvRow& more) { row.insert(row.end(), more.begin(), more.end()); };
  append(table.header, without_names(listed_columns(input, columns)));
  table.first_figure = table.header.size();
  append(table.header, columns.names());
  for (std::size_t i = 0; i < input.samples.size(); ++i) {
    const BatchSample& sample = input.samples[i];
    const auto& state = results.states[i];
    CsvRow& row = table.rows.emplace_back();
    row = {sample.name, sample.file.string(), results.status_of(i), state ? state->sentence : std::string()};
    append(row, without_names(sample.listed));
    row.resize(table.header.size());
    for (const auto& [column, cell] : figures[i]) row[table.first_figure + columns.index_of(column)] = cell;
  }
  return table;
}

void write_table(const fs::path& file, const SampleTable& table) {
  io::write_atomically(file, [&](std::ostream& out) {
    write_row(out, table.header);
    for (const CsvRow& row : table.rows) write_row(out, row);
  });
}

const char* joined_file(const std::string& command) { return command == "run" ? "branches.csv" : "axes.csv"; }

std::size_t write_joined(const BatchResults& results) {
  const std::string name = joined_file(results.command);
  /// Calls `row` with every row of every sample, the first of each being its header.
  const auto for_each_row = [&](const auto& use) {
    for (std::size_t i = 0; i < results.input.samples.size(); ++i) {
      if (!results.is_ok(i)) continue;
      const fs::path file = results.folder_of(i) / name;
      std::ifstream in(file, std::ios::binary);
      if (!in) continue;
      CsvReader reader(in, file.string());
      CsvRow row;
      for (bool is_header = true; reader.next(row); is_header = false)
        if (!use(i, row, is_header)) break;
    }
  };
  Columns columns;
  for_each_row([&](std::size_t, const CsvRow& row, bool) {
    for (const std::string& column : row) columns.index_of(column);
    return false;
  });
  std::size_t rows = 0;
  io::write_atomically(results.out / name, [&](std::ostream& out) {
    CsvRow header{"name"}, joined;
    header.insert(header.end(), columns.names().begin(), columns.names().end());
    write_row(out, header);
    std::vector<std::size_t> places;
    for_each_row([&](std::size_t sample, const CsvRow& row, bool is_header) {
      if (is_header) {
        places.clear();
        for (const std::string& column : row) places.push_back(1 + columns.index_of(column));
        return true;
      }
      joined.assign(header.size(), {});
      joined[0] = results.input.samples[sample].name;
      for (std::size_t i = 0; i < std::min(row.size(), places.size()); ++i) joined[places[i]] = row[i];
      write_row(out, joined);
      ++rows;
      return true;
    });
  });
  return rows;
}

}  // namespace quench::program
