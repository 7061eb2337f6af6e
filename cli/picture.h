// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "session.h"

namespace quench::program {

/// A folder of its own, removed at the end.
struct TemporaryFolder {
  TidiesUp tidies;
  std::filesystem::path path;
  TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder();
};

/// Chromium or Google Chrome: $QUENCH_CHROMIUM, else the first that is found on the PATH. Throws Error(failed) with a
/// sentence when there is none.
std::filesystem::path find_chromium();

/// A picture of a page without a window: `state` is what stands behind # in its address. Written atomically. Throws
/// Error(failed) when the browser does not draw it.
struct Picture {
  int width = 1600, height = 1000;
  std::string state;
};
void take_picture(const std::filesystem::path& chromium, const std::filesystem::path& page,
                  const std::filesystem::path& png, const Picture& picture, Session& session);

}  // namespace quench::program
