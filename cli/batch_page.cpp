// SPDX-License-Identifier: Apache-2.0
#include "batch_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ostream>
#include <string_view>

#include "base/text.h"
#include "batch_page_parts.h"
#include "option_checks.h"
#include "printable.h"
#include "quench/io.h"

namespace quench::program {
namespace {

namespace fs = std::filesystem;

/// Text for HTML, also within quotes; bytes that are not UTF-8 and control characters as printable() shows them.
std::string escaped(std::string_view text) {
  std::string result;
  for (const char c : printable(text)) switch (c) {
      case '&':
        result += "&amp;";
        break;
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      case '"':
        result += "&quot;";
        break;
      default:
        result += c;
    }
  return result;
}

/// A file of a sample as a relative address.
std::string address(const std::string& folder, std::string_view file) {
  std::string result;
  for (const char c : folder + "/" + std::string(file)) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                       std::string_view("-_.~/").find(c) != std::string_view::npos;
    result += plain ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return "./" + result;
}

/// "total_length [mm]" as it is read: "total length", "mm".
struct Label {
  explicit Label(const std::string& column) : name(column) {
    if (const std::size_t bracket = column.find(" ["); bracket != column.npos && column.ends_with(']')) {
      unit = column.substr(bracket + 2, column.size() - bracket - 3);
      name = column.substr(0, bracket);
    }
    plain = name;
    std::ranges::replace(name, '_', ' ');
  }
  std::string name, plain, unit;  ///< `plain`: with its underscores
};

/// A cell as it is shown: numbers with five digits, whole ones with all.
std::string shown(const std::string& cell) {
  double value = 0;
  if (!is_number(cell, value) || !std::isfinite(value)) return cell;
  return value == std::floor(value) && std::abs(value) < 1e15 ? fmt::format("{:.0f}", value)
                                                              : fmt::format("{:.5g}", value);
}

bool is_figure(const std::string& cell) {
  double value = 0;
  return is_number(cell, value);
}

/// Which figures a card shows: up to six of those that tell most, of the columns that have a number somewhere.
std::vector<std::size_t> main_figures(const SampleTable& table) {
  constexpr std::string_view kMain[] = {"axes",         "levels",     "total_length", "mean_radius",
                                        "depth",        "width",      "branches",     "ends",
                                        "curve_length", "components", "tunnels",      "reconstructed"};
  constexpr std::size_t kMost = 6;
  std::vector<std::size_t> chosen;
  const auto add = [&](std::size_t column) {
    const bool has_numbers = std::ranges::any_of(table.rows, [&](const CsvRow& row) { return is_figure(row[column]); });
    if (chosen.size() < kMost && has_numbers && std::ranges::find(chosen, column) == chosen.end())
      chosen.push_back(column);
  };
  for (const std::string_view name : kMain)
    for (std::size_t i = table.first_figure; i < table.header.size(); ++i)
      if (Label(table.header[i]).plain == name) add(i);
  for (std::size_t i = table.first_figure; i < table.header.size(); ++i) add(i);
  return chosen;
}

class Sheet {
 public:
  Sheet(std::ostream& out, const BatchResults& results, const SampleTable& table)
      : out_(out), results_(results), table_(table), figures_(main_figures(table)) {}

  void write(const std::string& command) {
    const fs::path whole = fs::absolute(results_.out).lexically_normal();
    const std::string title = escaped((whole.filename().empty() ? whole.parent_path() : whole).filename().string());
    out_ << "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" "
            "content=\"width=device-width, initial-scale=1\">\n<title>"
         << title << "</title>\n<style>" << kContactSheetStyle << "</style>\n</head>\n<body>\n<header>\n<h1>" << title
         << "</h1>\n<p>" << summary() << "</p>\n<p><code>" << escaped(command) << "</code></p>\n</header>\n";
    write_controls();
    out_ << "<main id=\"cards\">\n";
    for (std::size_t i = 0; i < table_.rows.size(); ++i) write_card(i);
    out_ << "</main>\n";
    write_rows();
    out_ << "<script>" << kContactSheetScript << "</script>\n</body>\n</html>\n";
  }

 private:
  std::string summary() const {
    std::string text = base::counted(table_.rows.size(), "sample");
    const char* separator = ": ";
    for (const std::string_view status : {"ok", "failed", "missing"}) {
      const auto count = std::ranges::count(table_.rows, status, [](const CsvRow& row) { return row[2]; });
      if (count == 0) continue;
      text += fmt::format("{}<span class=\"{}\">{} {}</span>", separator, status, count, status);
      separator = ", ";
    }
    return text;
  }

  void write_controls() {
    out_ << "<form>\n<input type=\"search\" id=\"filter\" placeholder=\"Filter\" aria-label=\"Filter\">\n"
            "<label>Sort by <select id=\"by\"><option value=\"-1\">order of the input</option>";
    for (std::size_t i = 0; i < table_.header.size(); ++i) {
      const Label label(table_.header[i]);
      out_ << "<option value=\"" << i << "\">" << escaped(label.name) << "</option>";
    }
    out_ << "</select></label>\n<button type=\"button\" id=\"turn\" aria-label=\"Descending\" "
            "title=\"Ascending or descending\">\xE2\x86\x91</button>\n"
            "<label><input type=\"checkbox\" id=\"bad\"> only failed or missing</label>\n"
            "<span class=\"views\"><button type=\"button\" id=\"as-cards\" aria-pressed=\"true\">Cards</button>"
            "<button type=\"button\" id=\"as-table\" aria-pressed=\"false\">Table</button></span>\n</form>\n";
  }

  bool has_file(std::size_t sample, std::string_view file) const {
    const auto& state = results_.states[sample];
    return state && std::ranges::find(state->files, file) != state->files.end();
  }

  void write_card(std::size_t i) {
    const CsvRow& row = table_.rows[i];
    const std::string& name = row[0];
    const bool ok = results_.is_ok(i), has_page = ok && has_file(i, "view.html");
    const std::string page = has_page ? fmt::format("<a href=\"{}\">", address(name, "view.html")) : "<span>";
    const char* end = has_page ? "</a>" : "</span>";
    out_ << "<article data-row=\"" << i << "\" class=\"" << row[2] << "\">\n<div class=\"picture\">";
    if (ok && has_file(i, "picture.png"))
      out_ << page << "<img src=\"" << address(name, "picture.png") << "\" alt=\"\" loading=\"lazy\">" << end;
    else
      out_ << "<span class=\"none\">" << (ok ? "no picture" : row[2]) << "</span>";
    out_ << "</div>\n<h2>" << page << escaped(name) << end << "</h2>\n<p class=\"chosen\" hidden></p>\n";
    if (!ok) out_ << "<p class=\"sentence\">" << escaped(row[3]) << "</p>\n";
    if (ok) write_figures(row);
    const char* before = "<p class=\"links\">";
    for (const char* file : {"view.html", "traits.csv", joined_file(results_.command), "report.json", "log.txt"})
      if (has_file(i, file)) {
        out_ << before << "<a href=\"" << address(name, file) << "\">" << file << "</a>";
        before = " ";
      }
    out_ << (before[0] == ' ' ? "</p>\n" : "") << "</article>\n";
  }

  void write_figures(const CsvRow& row) {
    out_ << "<dl>";
    for (const std::size_t column : figures_) {
      if (row[column].empty()) continue;
      const Label label(table_.header[column]);
      out_ << "<dt>" << escaped(label.name) << "</dt><dd>" << escaped(shown(row[column]))
           << (label.unit.empty() ? "" : " <i>" + escaped(label.unit) + "</i>") << "</dd>";
    }
    out_ << "</dl>\n";
  }

  void write_rows() {
    out_ << "<div id=\"table\" hidden><table>\n<thead><tr>";
    for (const std::string& column : table_.header) {
      const Label label(column);
      out_ << "<th scope=\"col\"><button type=\"button\">" << escaped(label.name)
           << (label.unit.empty() ? "" : " <i>" + escaped(label.unit) + "</i>") << "</button></th>";
    }
    out_ << "</tr></thead>\n<tbody>\n";
    for (std::size_t i = 0; i < table_.rows.size(); ++i) {
      out_ << "<tr data-row=\"" << i << "\" class=\"" << table_.rows[i][2] << "\">";
      for (std::size_t column = 0; column < table_.header.size(); ++column) write_cell(i, column);
      out_ << "</tr>\n";
    }
    out_ << "</tbody>\n</table></div>\n";
  }

  void write_cell(std::size_t i, std::size_t column) {
    const std::string& cell = table_.rows[i][column];
    const std::string text = column < table_.first_figure ? cell : shown(cell);
    out_ << "<td" << (is_figure(cell) ? " class=\"n\"" : "");
    if (text != cell) out_ << " data-v=\"" << escaped(cell) << '"';
    out_ << '>';
    if (column == 0 && results_.is_ok(i) && has_file(i, "view.html"))
      out_ << "<a href=\"" << address(cell, "view.html") << "\">" << escaped(text) << "</a>";
    else
      out_ << escaped(text);
    out_ << "</td>";
  }

  std::ostream& out_;
  const BatchResults& results_;
  const SampleTable& table_;
  std::vector<std::size_t> figures_;
};

}  // namespace

void write_contact_sheet(const fs::path& file, const BatchResults& results, const SampleTable& table,
                         const std::string& command) {
  io::write_atomically(file, [&](std::ostream& out) { Sheet(out, results, table).write(command); });
}

}  // namespace quench::program
