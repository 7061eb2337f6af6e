// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <span>

#include "io/volume/stored_volume.h"

namespace quench::io {

/// The samples of one block, in order, as they are stored but for the encoding.
class SampleSource {
 public:
  virtual ~SampleSource() = default;
  /// Fills `out`; false where the data end before, or are damaged.
  virtual bool read(std::span<std::byte> out) = 0;
  /// After read() has failed: whether the data are damaged rather than too short.
  virtual bool damaged() const { return false; }
  /// To be called after the last sample: false where what follows (the checksum of compressed data) shows that the
  /// samples are damaged or incomplete.
  virtual bool ends_well() { return true; }
};

/// Text is parsed into samples of `type` in the byte order of this machine. Throws Error(failed) when the file cannot
/// be opened.
std::unique_ptr<SampleSource> open_block(const SampleBlock& block, Encoding encoding, SampleType type);

}  // namespace quench::io
