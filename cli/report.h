// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "quench/io.h"
#include "quench/picture.h"
#include "quench/pipeline.h"
#include "session.h"
#include "stage_options.h"

/// Results of the pipeline as sections of a report (--json) and as sentences.
namespace quench::program {

using Json = nlohmann::ordered_json;

/// Writes `report` with seconds, peak memory and version filled in; "-" is stdout.
void write_report(const std::string& file, Json report, Session& session);
/// Ends a command that writes: the report of --json, if any, joins the other outputs, all appear together, and a report
/// for stdout comes last, so that a result is not lost with a reader of stdout that has gone.
void write_report(io::OutputGroup& outputs, const Json& report, Session& session);

/// JSON as text; bytes that are not UTF-8 (names of files may be anything) are replaced.
std::string json_text(const Json& value, int indent = -1);
/// "5 vertices, 1 edge, 0 faces"; in the plane without faces.
std::string cells_text(const pipeline::CellCounts& cells, bool plane = false);
/// The two or three sides of a pixel or voxel.
Json spacing_json(const Grid& grid);

/// The section `shape`.
Json shape_section(const pipeline::LoadedShape& shape);
/// `parameters`, `shape`, `core` and `pruned`.
void add_core_sections(Json& report, const pipeline::LoadedShape& shape, const pipeline::CoreResult& core);
/// What was found on the way: the lambda that was chosen, the memory that was predicted.
void say_core(const pipeline::LoadedShape& shape, const pipeline::CoreResult& core, Session& session);
/// "its balls fill 97 % of the shape", in the plane "its disks".
std::string share_text(double reconstructed, bool plane = false);

/// One line on what was written where, in which units. `report` may be empty.
void say_written(Session& session, const std::string& axis, const std::string& report, const pipeline::CoreResult& core,
                 const pipeline::LoadedShape& shape);

Json parameters_section(const pipeline::BurningOptions& options);
/// `burn`.
void add_burn_section(Json& report, const pipeline::BurnFigures& burned);
/// Of the sheets of a skeleton and of the shape: mean, deviation, extremes, percentiles; null where there are none.
Json thickness_section(const pipeline::RunThickness& thickness, bool plane);

/// What a burning found, and how many of so many vertices it left unburned.
void say_burned(const pipeline::BurnFigures& burned, std::size_t vertices, Session& session);

/// Which options mean nothing for axes of images and polygons.
void say_not_of_plane(const pipeline::SkeletonOptions& skeleton, const pipeline::BurningOptions& burning,
                      Session& session);

/// `burn`, `curves` and `skeleton`.
void add_axis_sections(Json& report, const pipeline::AxisRun& run);

/// Files of the curves; empty names are not written.
struct GraphFiles {
  std::filesystem::path swc, graphml, csv;
};
/// Writes them and adds what they hold to the report's section `skeleton`.
void write_graph(const CurveGraph& graph, const GraphFiles& files, const GraphFileOptions& options, const Vec3& voxel,
                 const Coordinates& coordinates, Json& report, Session& session);

/// Writes a page, as one of `outputs`, and adds the section `page`.
void write_page(const pipeline::PageBuilder& builder, const std::filesystem::path& file, Json& report,
                const io::OutputGroup& outputs);
/// Draws a page into a file and adds the section `picture`.
void write_picture(const Page& page, const PictureOptions& options, const std::filesystem::path& file, Json& report,
                   Session& session);

}  // namespace quench::program
