// SPDX-License-Identifier: Apache-2.0
// What happens when one of several threads that triangulate together fails, or is told to stop.
#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>
#include <tbb/task_scheduler_observer.h>

#include <cstdint>
#include <new>
#include <random>
#include <set>
#include <stdexcept>
#include <vector>

#include "delaunay/delaunay.h"
#include "failing_memory.h"
#include "quench/error.h"

namespace quench::delaunay {
namespace delaunay_faults_test {

constexpr int kThreads = 8;

// Only threads that have begun to help: TBB does not survive a thread that fails when it starts.
class Helpers : public tbb::task_scheduler_observer {
 public:
  explicit Helpers(tbb::task_arena& arena) : tbb::task_scheduler_observer(arena) { observe(true); }
  ~Helpers() override { observe(false); }
  void on_scheduler_entry(bool is_worker) override { failing_memory::concern_this_thread(is_worker); }
  void on_scheduler_exit(bool) override { failing_memory::concern_this_thread(false); }
};

// More threads than processors, so that they meet each other's cells at any place.
class Faults : public testing::Test {
 protected:
  void triangulate(Context* context) {
    arena_.execute([&] { Delaunay(sites_, {1, 1, 1}, context).validate(); });
  }
  std::size_t sites() const { return sites_.size(); }

 private:
  static std::vector<LatticePoint> random_sites() {
    std::mt19937 random(1);
    std::set<LatticePoint> sites;
    while (sites.size() < 40000) {
      LatticePoint site;
      for (std::int32_t& x : site) x = static_cast<std::int32_t>(random() % 200);
      sites.insert(site);
    }
    return {sites.begin(), sites.end()};
  }

  const tbb::global_control limit_{tbb::global_control::max_allowed_parallelism, kThreads};
  tbb::task_arena arena_{kThreads};
  const Helpers helpers_{arena_};
  std::vector<LatticePoint> sites_ = random_sites();
};

// The worker that fails has claimed cells, which nobody gives back: the others must not wait for them.
TEST_F(Faults, WithoutMemoryInOneThreadAllEnd) {
  int failed = 0;
  for (int left = 0; left < 40; ++left) {
    failing_memory::begin(left);
    try {
      triangulate(nullptr);
    } catch (const std::bad_alloc&) {
      ++failed;
    }
    failing_memory::end();
  }
  EXPECT_GT(failed, 0);
  EXPECT_NO_THROW(triangulate(nullptr));
}

// Whoever is asked to stop stops, also in the middle of the points of a thread.
TEST_F(Faults, CancelIsSeenWhileThreadsInsert) {
  // The calling thread has a stretch of more than 4 * 1024 points, and tells of every 1024.
  ASSERT_GT(sites(), kThreads * 4200u);
  for (int at = 1; at < 5; ++at) {
    Context context;
    int told = 0;
    context.progress = [&](std::string_view, double) {
      if (++told == at) context.cancel();
    };
    try {
      triangulate(&context);
      ADD_FAILURE() << "cancel at call " << at << " was not seen";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::cancelled);
      EXPECT_EQ(told, at);
    }
  }
}

// An exception of the caller's own comes out as it is, whichever thread ends first.
TEST_F(Faults, ExceptionsComeOutAsTheyWere) {
  for (int at = 1; at < 5; ++at) {
    Context context;
    int told = 0;
    context.progress = [&](std::string_view, double) {
      if (++told == at) throw std::runtime_error("of the caller");
    };
    EXPECT_THROW(triangulate(&context), std::runtime_error) << at;
  }
}

}  // namespace delaunay_faults_test
}  // namespace quench::delaunay
