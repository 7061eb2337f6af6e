// SPDX-License-Identifier: Apache-2.0
#include "batch_state.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <ostream>

#include "base/platform/system_files.h"
#include "option_checks.h"
#include "printable.h"
#include "quench/io.h"

namespace quench::program {
namespace {

namespace fs = std::filesystem;

constexpr const char* kStateFile = "batch.json";
constexpr const char* kStatusNames[] = {"running", "ok", "failed"};

/// The files whose content counts; the file itself where there is nothing to be found.
std::vector<fs::path> parts_of(const fs::path& file) {
  std::error_code error;
  const bool is_folder = fs::is_directory(file, error);
  const std::string extension = extension_of(file);
  if (!is_folder && extension != ".mhd" && extension != ".nhdr") return {file};
  std::vector<fs::path> parts;
  const fs::path folder = is_folder ? file : file.has_parent_path() ? file.parent_path() : fs::path(".");
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
    if (is_folder || it->path().stem() == file.stem()) parts.push_back(it->path());
  std::ranges::sort(parts);
  return parts;
}

/// FNV-1a, 64 bits.
std::uint64_t hashed(const std::string& text) {
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const unsigned char c : text) hash = (hash ^ c) * 0x100000001b3;
  return hash;
}

std::string path_from(const fs::path& out, const fs::path& file) {
  std::error_code error;
  const fs::path relative = fs::relative(fs::absolute(file), fs::absolute(out), error);  // `out` may not be there yet
  return printable((error || relative.empty() ? fs::absolute(file) : relative).string());
}

}  // namespace

Json made_of(const fs::path& file, const std::vector<std::string>& words, const fs::path& out) {
  std::int64_t bytes = 0;
  std::string times;
  for (const fs::path& part : parts_of(file)) {
    const std::optional<base::FileFacts> facts = base::facts_of(part);
    if (!facts) continue;
    bytes += facts->size;
    times += fmt::format("{} {} {}.{:09}\n", part.filename().string(), facts->size, facts->seconds, facts->nanoseconds);
  }
  Json command = Json::array();
  for (const std::string& word : words) command.push_back(printable(word));
  return {{"version", QUENCH_VERSION},
          {"command", command},
          {"file", path_from(out, file)},
          {"bytes", bytes},
          {"times", fmt::format("{:016x}", hashed(times))}};
}

bool has_state(const fs::path& folder) {
  std::error_code ignored;
  return fs::exists(folder / kStateFile, ignored);
}

std::optional<SampleState> read_state(const fs::path& folder) {
  std::ifstream in(folder / kStateFile, std::ios::binary);
  if (!in) return {};
  const Json json = Json::parse(in, nullptr, false);
  try {
    SampleState state;
    const auto name = std::ranges::find(kStatusNames, json.at("status").get<std::string>());
    if (name == std::end(kStatusNames)) return {};
    state.status = static_cast<SampleState::Status>(name - kStatusNames);
    state.made_of = json.at("made_of");
    state.code = json.at("code").get<int>();
    state.sentence = json.at("sentence").get<std::string>();
    state.seconds = json.at("seconds").get<double>();
    state.files = json.at("files").get<std::vector<std::string>>();
    return state;
  } catch (const Json::exception&) {
    return {};
  }
}

void write_state(const fs::path& folder, const SampleState& state) {
  const Json json = {{"status", kStatusNames[static_cast<int>(state.status)]},
                     {"code", state.code},
                     {"sentence", printable(state.sentence)},
                     {"seconds", state.seconds},
                     {"made_of", state.made_of},
                     {"files", state.files}};
  io::write_atomically(folder / kStateFile, [&](std::ostream& out) {
    out << json.dump(2, ' ', false, Json::error_handler_t::replace) << '\n';
  });
}

bool is_current(const std::optional<SampleState>& state, const Json& made_of, const fs::path& folder) {
  if (!state || state->status == SampleState::Status::running || state->made_of != made_of) return false;
  std::error_code ignored;
  return std::ranges::all_of(state->files, [&](const std::string& file) { return fs::exists(folder / file, ignored); });
}

bool is_final(const SampleState& state) {
  return state.status == SampleState::Status::ok ||
         (state.code > static_cast<int>(ErrorCode::failed) && state.code <= static_cast<int>(ErrorCode::invariant));
}

std::vector<std::string> with_expected_files(std::vector<std::string> files, const std::string& command) {
  files.insert(files.end(), {"log.txt", "report.json", "view.html", "picture.png", "branches.csv"});
  if (command == "tree")
    files.insert(files.end(), {"tree.swc", "tree.rsml", "tree.mtg", "tree.graphml", "centerlines.vtp", "axes.csv",
                               "traits.csv", "sholl.csv", "depths.csv", "edits.csv", "edited.nrrd"});
  else
    files.insert(files.end(), {"core.vtp", "skeleton.vtp", "skeleton.swc", "skeleton.geojson", "skeleton.svg"});
  std::ranges::sort(files);
  files.erase(std::unique(files.begin(), files.end()), files.end());
  return files;
}

FilesWithTimes files_with_times(const fs::path& folder) {
  FilesWithTimes files;
  std::error_code error, ignored;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
    if (it->is_regular_file(ignored)) files.emplace_back(it->path().filename().string(), it->last_write_time(ignored));
  std::ranges::sort(files);
  return files;
}

std::vector<std::string> written_since(const FilesWithTimes& before, const fs::path& folder) {
  std::vector<std::string> files;
  for (const auto& file : files_with_times(folder))
    if (file.first != kStateFile && !std::ranges::binary_search(before, file)) files.push_back(file.first);
  return files;
}

void remove_leavings(const fs::path& folder, const std::vector<std::string>& files) {
  std::error_code ignored;
  for (const auto& [name, time] : files_with_times(folder))
    if (std::ranges::find(files, name) != files.end() || (name.starts_with(".quench-") && name.ends_with(".tmp")))
      fs::remove(folder / name, ignored);
}

}  // namespace quench::program
