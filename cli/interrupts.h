// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "quench/context.h"

namespace quench::program {

/// What Ctrl-C, SIGTERM and a closed terminal do. The first one cancels the context, and the program ends at its next
/// checkpoint. Where it does not come to one within a second, since a file does not answer or a step is long, it is
/// ended there, with 130 and every output as it was. A second one ends it at once, by the signal. Ignored signals stay
/// ignored.
///
/// A thread of its own waits for the signals: a handler would run in a thread that may be the one that waits for a disk
/// and cannot be interrupted. Threads started later do not take these signals, and programs started must be given
/// their signal mask back. One at a time.
class Interrupts {
 public:
  explicit Interrupts(Context& context);
  ~Interrupts();
  Interrupts(const Interrupts&) = delete;
  Interrupts& operator=(const Interrupts&) = delete;
};

}  // namespace quench::program
