// SPDX-License-Identifier: Apache-2.0
#pragma once

/// Memory that runs out when told: operator new of a program with failing_memory.cpp.
namespace failing_memory {

/// From now on the first `allocations` by the threads that are concerned succeed, the rest throw std::bad_alloc.
void begin(int allocations);
void end();
/// Whether the calling thread is concerned; at first none is.
void concern_this_thread(bool concerned);

}  // namespace failing_memory
