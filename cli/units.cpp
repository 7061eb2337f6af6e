// SPDX-License-Identifier: Apache-2.0
#include "units.h"

#include <fmt/format.h>

#include <algorithm>

#include "option_checks.h"
#include "printable.h"
#include "quench/error.h"
#include "quench/pipeline.h"

namespace quench::program {
namespace {

/// No number before it, which would be a factor. Letters (also µ and others beyond ASCII), digits, and what joins them:
/// units are written into XML, CSV and JSON.
bool is_unit(const std::string& text) {
  const auto good = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '/' ||
           c == '^' || c == '.' || c == '-' || (static_cast<unsigned char>(c) & 0x80) != 0;
  };
  return text.size() <= 32 && !(text[0] >= '0' && text[0] <= '9') && std::ranges::all_of(text, good) &&
         printable(text) == text;
}

}  // namespace

CLI::Option* add_units(CLI::App& app, std::string& units) {
  return add_parsed(app, "--units",
                    "The unit of the input's coordinates, as results name it, e.g. mm or um, instead of what the file "
                    "says; it is a name only: nothing is scaled [default: what the file says]",
                    [&units](const std::string& option, const std::string& text) {
                      if (!is_unit(text))
                        throw Error(ErrorCode::usage,
                                    fmt::format("{} '{}' is not the name of a unit; give e.g. mm, um or m (up to 32 "
                                                "letters and digits; factors are no part of it)",
                                                option, text));
                      units = text;
                    })
      ->type_name("UNIT")
      ->check(also({"nm", "um", "mm", "cm", "m", "in"}));
}

void take_units(Coordinates& coordinates, const std::string& file, Session& session) {
  const std::string& units = session.options.units;
  if (units.empty()) return;
  if (!coordinates.units.empty() && coordinates.units != units)
    session.say(fmt::format("note: '{}' has coordinates in {}; they are called {}, as --units says, and not scaled",
                            file, coordinates.units, units));
  coordinates.units = units;
}

void take_units(Record& data, const std::string& file, Session& session) {
  if (session.options.units.empty()) return;
  Coordinates coordinates{.units = pipeline::field_text(data, "units").value_or(""), .space = {}};
  take_units(coordinates, file, session);
  std::erase_if(data.field_data, [](const DataArray& array) { return array.name == "units"; });
  data.field_data.push_back({"units", 1, std::vector<std::string>{coordinates.units}});
}

}  // namespace quench::program
