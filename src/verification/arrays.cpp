// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <set>
#include <span>

#include "quench/measures.h"
#include "verification/checks.h"

namespace quench::verification {

namespace {

constexpr const char* kTold = "told, not computed";
constexpr const char* kShapeOnly = "the voxels or pixels alone do not tell";
constexpr const char* kBoundsOnly = "only bounds are checked: the fire is not burned again";
constexpr const char* kFireOfTheAxis =
    "only bounds are checked: the fire is that of the medial axis, which the file does not hold";
constexpr const char* kSequence = "a burn sequence is checked as a whole only";
constexpr const char* kOfTheAxis = "it is of the medial axis, which the file does not hold";
constexpr const char* kOfTheChoice = "a choice that these cells do not depend on";
constexpr const char* kDetailsBounded =
    "only bounds are checked where a value was raised, or may be: what is raised for the balls to cover is not chosen "
    "again";
constexpr const char* kNoStage = "the file does not say what it is";
constexpr const char* kOtherMeasure = "how this measure is computed is not known here";
constexpr const char* kNoSurface = "the surface that points and radii refer to was not given";
constexpr const char* kLinear = "only bounds are checked: between the vertices of the medial axis it is interpolated";
constexpr const char* kNothingToCompare = "the file has nothing to compare it with";

/// An array that the format defines: how many numbers a field array has (0: any), the words a text may be (none: any),
/// and why no check may be about it.
struct Known {
  std::string name;
  std::size_t numbers;
  std::vector<std::string> words;
  const char* reason;
};

const std::vector<std::string>& known_point_arrays() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all{"radius",
                                 "voxel_radius",
                                 "burn_time",
                                 "unburned",
                                 "erosion_thickness",
                                 "curve_burn_time",
                                 "curve_unburned",
                                 "curve_erosion_thickness",
                                 "seam",
                                 "junction"};
    for (const MeasureKind& measure : kMeasures) all.emplace_back(measure.name);
    return all;
  }();
  return names;
}
const std::vector<std::string>& known_cell_arrays() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all{"kind",
                                 "component",
                                 "branch",
                                 "sheet",
                                 "site_a",
                                 "site_b",
                                 "sheet_level",
                                 "curve_level",
                                 "erosion_thickness",
                                 "curve_erosion_thickness"};
    for (const MeasureKind& measure : kMeasures) {
      all.emplace_back(measure.name);
      all.push_back(std::string(measure.name) + "_level");
    }
    return all;
  }();
  return names;
}
const std::vector<Known>& known_field_numbers() {
  static const std::vector<Known> arrays = [] {
    std::vector<Known> all{{"sites", 0, {}, kNothingToCompare},
                           {"dims", 3, {}, kNothingToCompare},
                           {"spacing", 3, {}, kNothingToCompare},
                           {"origin", 3, {}, kNothingToCompare},
                           {"direction", 9, {}, kNothingToCompare},
                           {"dimension", 1, {}, kNothingToCompare},
                           {"coverage", 1, {}, kNothingToCompare},
                           {"longest_side", 1, {}, kShapeOnly},
                           {"reconstructed", 1, {}, kNothingToCompare},
                           {"euler", 1, {}, kNothingToCompare},
                           {"betti", 3, {}, kNothingToCompare},
                           {"omega", 1, {}, kOfTheAxis},
                           {"burn_nodes", 1, {}, kOfTheAxis},
                           {"max_burn_time", 1, {}, kNothingToCompare},
                           {"theta2", 1, {}, "only bounds are checked: levels are of the medial axis"},
                           {"theta1", 1, {}, "only bounds are checked: levels are of the medial axis"},
                           {"smooth", 1, {}, kTold},
                           {"rims_above", 1, {}, "only bounds are checked: levels are of the medial axis"},
                           {"main_axes", 1, {}, kTold},
                           {"theta1_radii", 1, {}, "only bounds are checked: fires end on the medial axis"},
                           {"sequence_steps", 0, {}, kSequence},
                           {"sequence_parents", 0, {}, kSequence},
                           {"sequence_order", 0, {}, kSequence},
                           {"sequence_large", 0, {}, kSequence},
                           {"sequence_step", 1, {}, kSequence},
                           {"sequence_of", 2, {}, kSequence},
                           {"format_version", 1, {}, kNothingToCompare}};
    for (const MeasureKind& measure : kMeasures) {
      all.push_back({std::string(measure.name), 1, {}, kOfTheAxis});
      all.push_back({std::string(measure.name) + "_chosen", 1, {}, kOfTheChoice});
    }
    return all;
  }();
  return arrays;
}
const std::vector<Known>& known_field_texts() {
  static const std::vector<Known> arrays{{"stage", 1, {"core", "skeleton"}, kNothingToCompare},
                                         {"lambda_rule", 1, {"coface", "ball"}, kNothingToCompare},
                                         {"propagation", 1, {"segments", "windows", "nodes"}, kTold},
                                         {"radius_rule", 1, {"exact", "linear"}, kTold},
                                         {"surface", 1, {"mesh", "grey", "smooth"}, kNoSurface},
                                         {"tips", 1, {"full", "pruned"}, kTold},
                                         {"y_axis", 1, {"down", "up"}, "which way y of the shape grows was not given"},
                                         {"units", 1, {}, kTold},
                                         {"SPACE", 1, {}, kTold},
                                         {"parameters", 1, {}, "the shape was made with them"},
                                         {"version", 1, {}, kTold}};
  return arrays;
}

std::string repeated_name(const std::vector<DataArray>& arrays, const char* of) {
  std::set<std::string> names;
  for (const DataArray& array : arrays)
    if (!names.insert(array.name).second) return fmt::format("there are two {} arrays '{}'", of, array.name);
  return {};
}

std::string defect_of_rows(const std::vector<DataArray>& arrays, const auto& known, const char* of) {
  for (const auto& name : known)
    if (const DataArray* array = find_array(arrays, name); array && (!has_numbers(*array) || array->components != 1))
      return fmt::format("the {} array '{}' is not one number per {}", of, name, of);
  return {};
}

std::string defect_of_fields(const std::vector<DataArray>& arrays) {
  for (const Known& known : known_field_numbers()) {
    const DataArray* array = find_array(arrays, known.name);
    if (!array) continue;
    if (!has_numbers(*array))
      return fmt::format("the field array '{}' holds text where numbers are needed", known.name);
    if (known.numbers > 0 && array->size() != known.numbers)
      return fmt::format("the field array '{}' has {} numbers instead of {}", known.name, array->size(), known.numbers);
    if (known.numbers != 1 || known.name == std::string_view("euler")) continue;  // that can be negative
    if (const double number = array->numbers()[0]; !(number >= 0))
      return fmt::format("the field array '{}' is {:.9g}, which can only be 0 or more", known.name, number);
  }
  if (const DataArray* sites = find_array(arrays, "sites"); sites && (sites->components != 3 || sites->size() % 3 != 0))
    return "the field array 'sites' is not of three numbers per site";
  if (const DataArray* measures = find_array(arrays, "measures"); measures && has_numbers(*measures))
    return "the field array 'measures' is not text";
  std::string_view threshold;
  for (const MeasureKind& measure : kMeasures) {
    if (!find_array(arrays, measure.name)) continue;
    if (!threshold.empty())
      return fmt::format("there are two thresholds, the field arrays '{}' and '{}'", measure.name, threshold);
    threshold = measure.name;
  }
  for (const Known& known : known_field_texts()) {
    const DataArray* array = find_array(arrays, known.name);
    if (!array) continue;
    if (has_numbers(*array) || array->size() != 1)
      return fmt::format("the field array '{}' is not one text", known.name);
    const std::string word = text_or_empty(arrays, known.name);
    if (!known.words.empty() && std::find(known.words.begin(), known.words.end(), word) == known.words.end())
      return fmt::format("the field array '{}' is '{}'; it can be '{}'", known.name, word,
                         fmt::join(known.words, "' or '"));
  }
  return {};
}

// Why an array is in no check.
std::string reason_for(const char* of, const std::string& name, const Record& data) {
  const std::string stage = text_or_empty(data.field_data, "stage");
  if (stage.empty()) return kNoStage;
  if (of == std::string("field") && name == "omega" && find_array(data.field_data, "burn_nodes"))
    return "only that it gives burn_nodes is checked";
  if (stage == "core" && of == std::string("field") && (name == kLambda || name == kDetail))
    return text_or_empty(data.field_data, "surface").empty() || name == kLambda ? "another threshold was given"
                                                                                : kBorneOutBySurface;
  if (stage == "core" && of == std::string("field") && is_measure_of_cores(name))
    return "only that no level is below it is checked";
  if (of == std::string("field")) {
    for (const auto* known : {&known_field_numbers(), &known_field_texts()})
      for (const Known& array : *known)
        if (array.name == name) return array.reason;
    return "unknown here";
  }
  if (name == "radius" && find_array(data.field_data, "surface")) return stage == "skeleton" ? kLinear : kNoSurface;
  if (name.find("burn") != std::string::npos || name.find("erosion") != std::string::npos)
    return find_array(data.field_data, "dimension") ? kFireOfTheAxis : kBoundsOnly;
  if (name == "sheet_level" || name == "curve_level") return "only bounds are checked: levels are of the medial axis";
  if (stage == "core" && name == kDetail)
    return find_array(data.field_data, kDetail) ? kDetailsBounded
                                                : "it is checked where it is what the core is pruned by";
  if (stage == "skeleton" && name == kMgf) return kOfTheAxis;
  for (const std::string& measure : texts_or_empty(data.field_data, "measures"))
    if (!is_measure_of_cores(measure) && (name == measure || name == measure + "_level")) return kOtherMeasure;
  const auto& known = of == std::string("point") ? known_point_arrays() : known_cell_arrays();
  const bool is_known = std::find(known.begin(), known.end(), name) != known.end();
  return is_known ? kNothingToCompare : "unknown here";
}

}  // namespace

std::string array_defect(const Record& data) {
  std::string defect = repeated_name(data.point_data, "point");
  if (defect.empty()) defect = repeated_name(data.cell_data, "cell");
  if (defect.empty()) defect = repeated_name(data.field_data, "field");
  if (defect.empty() && find_array(data.field_data, "stage")) {  // other programs may use the names as they like
    defect = defect_of_rows(data.point_data, known_point_arrays(), "point");
    if (const DataArray* array = find_array(data.point_data, "voxel_point");
        array && defect.empty() && (!has_numbers(*array) || array->components != 3))
      defect = "the point array 'voxel_point' is not three numbers per point";
    if (defect.empty()) defect = defect_of_rows(data.cell_data, known_cell_arrays(), "cell");
    std::vector<std::string> measures = texts_or_empty(data.field_data, "measures");
    if (defect.empty()) defect = defect_of_rows(data.point_data, measures, "point");
    if (defect.empty()) defect = defect_of_rows(data.cell_data, measures, "cell");
    for (std::string& measure : measures) measure += "_level";
    if (defect.empty()) defect = defect_of_rows(data.cell_data, measures, "cell");
    if (defect.empty()) defect = defect_of_fields(data.field_data);
  }
  return defect;
}

std::vector<UncheckedArray> unchecked_arrays(const Record& data, const std::vector<Check>& checks) {
  std::set<std::string> checked;
  for (const Check& check : checks) checked.insert(check.arrays.begin(), check.arrays.end());
  std::vector<UncheckedArray> left;
  const auto list = [&](const std::vector<DataArray>& arrays, const char* of) {
    for (const DataArray& array : arrays)
      if (const std::string name = fmt::format("{} {}", of, array.name); !checked.contains(name))
        left.push_back({name, reason_for(of, array.name, data)});
  };
  list(data.point_data, "point");
  list(data.cell_data, "cell");
  list(data.field_data, "field");
  return left;
}

Check arrays_left(const std::vector<UncheckedArray>& arrays, const std::vector<std::string>& absent) {
  const std::string name = "other arrays";
  const std::string missing = absent.empty() ? "" : fmt::format("not in the file: {}", fmt::join(absent, ", "));
  if (arrays.empty()) return {name, true, absent.empty() ? "there are none" : missing, {}};
  std::vector<std::string> reasons;
  std::map<std::string, std::string> names;
  for (const auto& [array, reason] : arrays) {
    std::string& list = names[reason];
    if (list.empty()) reasons.push_back(reason);
    list += (list.empty() ? "" : ", ") + array;
  }
  std::string text;
  for (const std::string& reason : reasons)
    text += fmt::format("{}{} ({})", text.empty() ? "" : "; ", names[reason], reason);
  return not_checked(name, missing.empty() ? text : text + "; " + missing);
}

}  // namespace quench::verification
