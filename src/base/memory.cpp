// SPDX-License-Identifier: Apache-2.0
#include "base/memory.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <fstream>

#include "base/return_memory.h"

namespace quench::base {

std::int64_t available_memory() {
  std::ifstream file("/proc/meminfo");
  std::string key, unit;
  std::int64_t value = 0;
  while (file >> key >> value) {
    std::getline(file, unit);
    if (key == "MemAvailable:") return value * 1024;
  }
  return static_cast<std::int64_t>(sysconf(_SC_PHYS_PAGES)) * sysconf(_SC_PAGESIZE);
}

std::int64_t held_memory() {
  return_free_memory();
  std::int64_t all = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> all >> resident;
  return resident * sysconf(_SC_PAGESIZE);
}

std::int64_t peak_memory() {
  // Not that of getrusage(), which begins with the peak of the process that started this one.
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;)
    if (word == "VmHWM:")
      if (std::int64_t kilobytes = 0; status >> kilobytes) return kilobytes * 1024;
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::int64_t>(usage.ru_maxrss) * 1024;
}

std::string bytes_text(std::int64_t bytes) {
  const double amount = static_cast<double>(bytes);
  const auto in = [&](double unit, const char* name) {
    return fmt::format("{:.{}f} {}", amount / unit, amount < 10 * unit ? 1 : 0, name);
  };
  if (amount >= 0x1p30) return in(0x1p30, "GB");
  if (amount >= 0x1p20) return in(0x1p20, "MB");
  if (amount >= 0x1p10) return in(0x1p10, "KB");
  return fmt::format("{} byte{}", bytes, bytes == 1 ? "" : "s");
}

}  // namespace quench::base
