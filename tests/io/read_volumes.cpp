// SPDX-License-Identifier: Apache-2.0
// Reads the files whose names stand on standard input, one per line, whole ("volume NAME") or slice by slice ("slices
// NAME"), with options ("volume:channel=red:dimension=3 NAME"), and prints a line about each: what volume_formats.py
// compares with what it wrote.
#include <fmt/format.h>
#include <unistd.h>

#include <iostream>
#include <span>
#include <sstream>
#include <string>

#include "quench/error.h"
#include "quench/io.h"
#include "quench/shape.h"
#include "shape/sample_type.h"

namespace {

using namespace quench;

constexpr std::array sample_names{"uint8", "int8",   "uint16", "int16",   "uint32",
                                  "int32", "uint64", "int64",  "float32", "float64"};
constexpr std::size_t most_bytes = 1 << 16;  // larger results are described, not printed

std::string hexadecimal(std::span<const std::byte> bytes) {
  std::string text;
  for (const std::byte b : bytes) text += fmt::format("{:02x}", static_cast<unsigned>(b));
  return text.empty() || bytes.size() > most_bytes ? "-" : text;
}

// What has no value of its own is "-", so that every line has as many words.
std::string word(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) <= ' ') c = '_';
  return text.empty() ? "-" : text;
}

std::string line_about(const auto& image, SampleType type, std::span<const std::byte> samples) {
  const Grid& g = image.grid;
  std::string line =
      fmt::format("read {} {} {} {}", sample_names.at(static_cast<std::size_t>(type)), g.dims[0], g.dims[1], g.dims[2]);
  for (const Vec3& v : {g.spacing, g.origin}) line += fmt::format(" {:.17g} {:.17g} {:.17g}", v[0], v[1], v[2]);
  for (int row = 0; row < 3; ++row)
    line += fmt::format(" {:.17g} {:.17g} {:.17g}", g.direction(row, 0), g.direction(row, 1), g.direction(row, 2));
  return line + fmt::format(" {} {} {} {} {} {}", word(image.coordinates.units), word(image.coordinates.space),
                            word(image.spacing_source), hexadecimal(samples), g.dimension,
                            image.coordinates.y_down ? "down" : "up");
}

/// The options behind the first word of a request.
io::VolumeReadOptions options_in(const std::string& how) {
  io::VolumeReadOptions options;
  std::istringstream words(how);
  for (std::string text; std::getline(words, text, ':');) {
    const std::string name = text.substr(0, text.find('=')), value = text.substr(text.find('=') + 1);
    if (name == "channel") options.channel = value;
    if (name == "dimension") options.dimension = std::stoi(value);
  }
  return options;
}

std::string whole(const std::string& file, const io::VolumeReadOptions& options) {
  const Volume volume = io::read_volume(file, options);
  const auto type = static_cast<SampleType>(volume.samples.index());
  return std::visit([&](const auto& all) { return line_about(volume, type, std::as_bytes(std::span(all))); },
                    volume.samples);
}

std::string by_slices(const std::string& file, const io::VolumeReadOptions& options) {
  const auto stream = io::open_slices(file, options);
  if (!stream) return "whole only";
  const auto& dims = stream->grid.dims;
  const std::size_t slice = static_cast<std::size_t>(dims[0] * dims[1]) * shape::size_of(stream->type);
  std::vector<std::byte> all, one(slice);
  for (std::int64_t z = 0; z < dims[2]; ++z) {
    stream->next(one);
    if (all.size() <= most_bytes) all.insert(all.end(), one.begin(), one.end());
  }
  return line_about(*stream, stream->type, all);
}

std::string outcome(const std::string& how, const std::string& file) {
  try {
    return how.starts_with("slices") ? by_slices(file, options_in(how)) : whole(file, options_in(how));
  } catch (const Error& error) {
    return fmt::format("refused {} {}", static_cast<int>(error.code()), error.what());
  } catch (const std::exception& error) {
    return fmt::format("thrown {}", error.what());
  }
}

}  // namespace

int main() {
  constexpr unsigned patience = 120;  // seconds per file: what never ends is ended by SIGALRM, and seen as a crash
  for (std::string how, file; std::cin >> how && std::getline(std::cin >> std::ws, file);) {
    alarm(patience);
    std::cout << outcome(how, file) << std::endl;  // flushed: the lines before a crash count
  }
  return 0;
}
