// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>
#include <span>
#include <string_view>

#include "quench/measures.h"
#include "verification/checks.h"

namespace quench::verification {

namespace {

/// An array that Quench writes into files of a stage.
struct Expected {
  const char* of;  ///< "point", "cell" or "field"
  std::string name;
  bool needed;  ///< without it the file cannot be placed, or checked as what it claims to be
};

const Expected kOfCores[]{{"point", "radius", true},
                          {"cell", "kind", false},
                          {"cell", "component", false},
                          {"cell", "site_a", true},
                          {"cell", "site_b", true},
                          {"field", "sites", true},
                          {"field", "dims", true},
                          {"field", "spacing", true},
                          {"field", "origin", true},
                          {"field", "direction", true},
                          {"field", "lambda_rule", true},
                          {"field", "longest_side", false},
                          {"field", "reconstructed", false},
                          {"field", "euler", false},
                          {"field", "betti", false},
                          {"field", "units", false},
                          {"field", "parameters", false},
                          {"field", "version", false},
                          {"field", "format_version", false},
                          {"field", "measures", false}};

// In the plane beside these.
const Expected kOfPlane[]{{"field", "dimension", true}, {"field", "y_axis", false}};

const Expected kOfFittedCores[]{
    {"point", "voxel_point", true}, {"point", "voxel_radius", true}, {"field", "surface", true}};
// Of a threshold.
std::vector<Expected> of_prunings_by(std::string_view measure, bool needed) {
  return {{"field", std::string(measure), needed}, {"field", fmt::format("{}_chosen", measure), false}};
}
const Expected kOfPruningsByDetail[]{{"field", "coverage", false}};

// Of cores once they are burned: when there is one of them, all are expected.
const Expected kOfBurning[]{{"point", "burn_time", false},
                            {"point", "erosion_thickness", false},
                            {"point", "unburned", false},
                            {"field", "max_burn_time", false}};
// In space beside these.
const Expected kOfBurningOfSheets[]{{"field", "omega", false},
                                    {"field", "propagation", false},
                                    {"field", "radius_rule", false},
                                    {"field", "burn_nodes", false}};

// The same of the burn sequence.
const Expected kOfSequence[]{{"field", "sequence_steps", false}, {"field", "sequence_parents", false},
                             {"field", "sequence_order", false}, {"field", "sequence_large", false},
                             {"field", "sequence_step", false},  {"field", "sequence_of", false}};

const Expected kOfSkeletons[]{{"point", "radius", true},
                              {"point", "burn_time", false},
                              {"point", "erosion_thickness", false},
                              {"point", "unburned", false},
                              {"cell", "kind", false},
                              {"cell", "component", false},
                              {"cell", "curve_level", true},
                              {"cell", "erosion_thickness", true},
                              {"field", "theta1", true},
                              {"field", "theta1_radii", false},
                              {"field", "tips", false},
                              {"cell", "branch", false},
                              {"field", "smooth", false},
                              {"field", "euler", false},
                              {"field", "betti", false},
                              {"field", "version", false},
                              {"field", "format_version", false}};
// In space, where they have sheets, beside these.
const Expected kOfSkeletonsInSpace[]{{"point", "curve_burn_time", false},
                                     {"point", "curve_erosion_thickness", false},
                                     {"point", "curve_unburned", false},
                                     {"cell", "sheet_level", true},
                                     {"cell", "curve_erosion_thickness", true},
                                     {"field", "theta2", true},
                                     {"cell", "sheet", false},
                                     {"point", "seam", false},
                                     {"point", "junction", false},
                                     {"field", "rims_above", false},
                                     {"field", "omega", false},
                                     {"field", "propagation", false},
                                     {"field", "radius_rule", false}};

// Skeletons have these from their core; one of a medial axis of another program has none of them.
const Expected kOfSkeletonsOfCores[]{{"field", "dims", true},          {"field", "spacing", true},
                                     {"field", "origin", true},        {"field", "direction", true},
                                     {"field", "longest_side", false}, {"field", "units", false},
                                     {"field", "parameters", false}};

// Arrays by which a skeleton of a core is recognized: other programs may give a medial axis a spacing and an origin.
const Expected kOnlyOfCores[]{{"field", "dims", true}, {"field", "parameters", false}};

bool is_there(const Record& data, const Expected& array) {
  const std::string_view of = array.of;
  const auto& arrays = of == "point" ? data.point_data : of == "cell" ? data.cell_data : data.field_data;
  return find_array(arrays, array.name) != nullptr;
}

// Adds those of `arrays` that the file does not have to `absent`.
void look_for(std::span<const Expected> arrays, const Record& data, std::vector<Expected>& absent) {
  std::copy_if(arrays.begin(), arrays.end(), std::back_inserter(absent),
               [&](const Expected& array) { return !is_there(data, array); });
}

bool has_one_of(std::span<const Expected> arrays, const Record& data) {
  return std::any_of(arrays.begin(), arrays.end(), [&](const Expected& array) { return is_there(data, array); });
}

// The arrays of measures that a core has: unasked, and of what it is pruned by.
std::vector<Expected> of_measures(const Result& result) {
  std::vector<Expected> arrays;
  for (const MeasureKind& measure : kMeasures) {
    const bool prunes = measure.name == result.pruned_by();
    if (!prunes && !is_in_every_file(measure, result.plane)) continue;
    const std::string name(measure.name);
    const bool needed = prunes || name == kLambda;
    arrays.push_back({"point", name, needed});
    arrays.push_back({"cell", name, needed});
    if (prunes) arrays.push_back({"cell", name + "_level", true});
  }
  return arrays;
}

// The measure whose threshold the fields of a skeleton tell, or null.
const MeasureKind* threshold_of(const Record& data) {
  const auto found = std::ranges::find_if(
      kMeasures, [&](const MeasureKind& m) { return has_one_of(of_prunings_by(m.name, false), data); });
  return found == kMeasures.end() ? nullptr : &*found;
}

std::vector<Expected> absent_of(const Result& result) {
  const Record& data = result.data;
  std::vector<Expected> absent;
  if (result.stage == "core") {
    look_for(of_measures(result), data, absent);
    look_for(kOfCores, data, absent);
    if (result.plane) look_for(kOfPlane, data, absent);
    look_for(of_prunings_by(result.pruned_by(), true), data, absent);
    if (has_one_of(kOfFittedCores, data)) look_for(kOfFittedCores, data, absent);
    if (result.by_detail && result.detail > 0) look_for(kOfPruningsByDetail, data, absent);
    if (has_one_of(kOfBurning, data) || (!result.plane && has_one_of(kOfBurningOfSheets, data))) {
      look_for(kOfBurning, data, absent);
      if (!result.plane) look_for(kOfBurningOfSheets, data, absent);
    }
    if (has_one_of(kOfSequence, data)) look_for(kOfSequence, data, absent);
  } else if (result.stage == "skeleton") {
    look_for(kOfSkeletons, data, absent);
    if (!result.plane) look_for(kOfSkeletonsInSpace, data, absent);
    const MeasureKind* by = threshold_of(data);
    if (by || has_one_of(kOnlyOfCores, data)) {
      look_for(kOfSkeletonsOfCores, data, absent);
      if (result.plane) look_for(kOfPlane, data, absent);
      look_for(of_prunings_by(by ? by->name : kLambda, false), data, absent);
    }
  } else {
    absent.push_back({"field", "stage", false});
  }
  return absent;
}

}  // namespace

std::vector<std::string> absent_arrays(const Result& result) {
  std::vector<std::string> names;
  for (const Expected& array : absent_of(result)) names.push_back(fmt::format("{} {}", array.of, array.name));
  return names;
}

Check check_expected(const Result& result, const VerifyOptions& options) {
  const std::string name = "arrays";
  if (result.stage.empty()) return not_checked(name, "no FieldData 'stage'");
  std::vector<std::string> needed;
  const auto is_given = [&](const Expected& array) {
    return std::string_view(array.of) == "field" &&
           ((options.lambda && array.name == kLambda) || (options.detail && array.name == kDetail));
  };
  for (const Expected& array : absent_of(result))
    if (array.needed && !is_given(array)) needed.push_back(fmt::format("{} {}", array.of, array.name));
  if (needed.empty()) return {name, true, fmt::format("the file has what a {} needs", result.stage), {}};
  const std::string list = fmt::format("{}", fmt::join(needed, ", "));
  if (!options.format_holds_all)
    return not_checked(name, "the file does not have what a " + result.stage + " needs: " + list);
  return failed(name, fmt::format("missing: {}; a {} cannot be checked without, write it again from its input", list,
                                  result.stage));
}

}  // namespace quench::verification
