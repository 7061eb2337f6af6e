// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <barrier>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "full_run.h"
#include "quench/bricks.h"
#include "quench/error.h"
#include "quench/io.h"
#include "quench/samples.h"
#include "random_shapes.h"
#include "temporary_folder.h"

// Processes that send each other their parts, here threads: the core is that of one piece, whatever their number.

namespace quench::pipeline {
namespace brick_messages_test {

// What threads have laid down for each other: mail[to][from].
struct MailRoom {
  explicit MailRoom(std::size_t ranks)
      : mail(ranks, std::vector<std::vector<std::string>>(ranks)), barrier(static_cast<std::ptrdiff_t>(ranks)) {}
  std::vector<std::vector<std::vector<std::string>>> mail;
  std::barrier<> barrier;
};

class ThreadMessenger : public Messenger {
 public:
  ThreadMessenger(MailRoom& room, std::size_t rank) : room_(room), rank_(rank) {}
  std::size_t rank() const override { return rank_; }
  std::size_t ranks() const override { return room_.mail.size(); }
  std::vector<std::vector<std::string>> exchange(const std::vector<std::vector<std::string_view>>& to) override {
    for (std::size_t r = 0; r < ranks(); ++r) room_.mail[r][rank_].assign(to[r].begin(), to[r].end());
    room_.barrier.arrive_and_wait();
    auto from = room_.mail[rank_];
    room_.barrier.arrive_and_wait();
    return from;
  }

 private:
  MailRoom& room_;
  std::size_t rank_;
};

// What a process ends with.
struct RankEnd {
  std::optional<MergedBricks> merged;
  std::string error;
  int code = 0;
  std::vector<std::size_t> rounds;  // bricks of each that began
};

template <class Work>
std::vector<RankEnd> on_ranks(std::size_t ranks, const Work& work) {
  MailRoom room(ranks);
  std::vector<RankEnd> ends(ranks);
  std::vector<std::thread> threads;
  for (std::size_t r = 0; r < ranks; ++r)
    threads.emplace_back([&, r] {
      ThreadMessenger messenger(room, r);
      try {
        work(messenger, ends[r]);
      } catch (const Error& error) {
        ends[r].error = error.what();
        ends[r].code = static_cast<int>(error.code());
      }
    });
  for (std::thread& thread : threads) thread.join();
  return ends;
}

std::vector<RankEnd> cores_on_ranks(std::size_t ranks, const std::filesystem::path& work) {
  return on_ranks(ranks, [&](Messenger& messenger, RankEnd& end) {
    end.merged = core_by_messages(work, messenger, [&](std::size_t round, std::size_t bricks) {
      end.rounds.push_back(bricks);
      EXPECT_EQ(end.rounds.size(), round);
    });
  });
}

std::string vtp_of(const CoreResult& core) {
  const TemporaryFolder folder;
  io::write_record(folder / "core.vtp", core_file(core));
  std::ifstream in(folder / "core.vtp", std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

// Plans the shape, and compares the core of so many ranks with that of one piece.
void expect_core_by_messages(const LoadedShape& shape, std::int64_t size, const std::vector<std::size_t>& ranks,
                             const std::string& what) {
  const TemporaryFolder folder;
  const BrickStatus planned = plan_bricks(shape, {}, size, folder / "work", R"({"of": 1})");
  const std::string whole = vtp_of(core_of(shape, {}));
  for (const std::size_t n : ranks) {
    const std::vector<RankEnd> ends = cores_on_ranks(n, folder / "work");
    ASSERT_TRUE(ends[0].merged) << what << ", " << n << " ranks: " << ends[0].error;
    EXPECT_TRUE(vtp_of(ends[0].merged->core) == whole) << what << ", " << n << " ranks";
    EXPECT_GT(ends[0].merged->figures.peak_bytes, 0);
    EXPECT_EQ(ends[0].merged->report, R"({"of":1})");
    for (std::size_t r = 1; r < n; ++r) EXPECT_FALSE(ends[r].merged);
    for (const RankEnd& end : ends) {
      ASSERT_EQ(end.rounds.size(), planned.rounds.size());
      for (std::size_t i = 0; i < end.rounds.size(); ++i) EXPECT_EQ(end.rounds[i], planned.rounds[i].bricks);
    }
  }
}

TEST(BrickMessages, MakeTheCoreOfAMeshOnAnyNumberOfRanks) {
  ShapeOptions options;
  options.resolution = repeats(48, 32);
  expect_core_by_messages(shape_of(make_sample("torus").mesh, options), 8, {1, 2, 3, 4, 5, 6, 7, 8}, "torus");
}

TEST(BrickMessages, MakeTheCoreOfRandomShapes) {
  for (std::uint64_t seed = 0; seed < 24; ++seed) {
    const VoxelShape voxels = testing_shapes::random_shape(seed, 26, seed % 3 == 1);
    expect_core_by_messages(shape_of(VoxelShape(voxels), voxels.grid(), {}), 8, {1 + seed % 8},
                            "seed " + std::to_string(seed));
  }
}

TEST(BrickMessages, MoreRanksThanBricks) {
  const VoxelShape voxels = testing_shapes::box_shape(5, 4, 3);
  expect_core_by_messages(shape_of(VoxelShape(voxels), voxels.grid(), {}), 8, {8}, "a box");
}

TEST(BrickMessages, FailOnAllRanksWithOneSentence) {
  const TemporaryFolder folder;
  ShapeOptions options;
  options.resolution = 48;
  plan_bricks(shape_of(make_sample("torus").mesh, options), {}, 8, folder / "work", "{}");
  std::ofstream(folder / "work" / "shape" / "000001.runs") << "damaged";  // which only some ranks read first
  for (const RankEnd& end : cores_on_ranks(5, folder / "work")) {
    EXPECT_EQ(end.code, static_cast<int>(ErrorCode::input));
    EXPECT_EQ(end.error,
              "'" + (folder / "work" / "shape" / "000001.runs").string() + "' cannot be used: it is damaged");
  }
  for (const RankEnd& end : cores_on_ranks(3, folder / "nowhere"))
    EXPECT_EQ(end.error, "'" + (folder / "nowhere").string() + "' holds no plan of bricks");
}

TEST(BrickMessages, TheFirstFailureIsThatOfAll) {
  const auto ends = on_ranks(4, [](Messenger& messenger, RankEnd&) {
    together(messenger, [] {});
    together(messenger, [&] {
      if (messenger.rank() == 2) throw std::bad_alloc();
      if (messenger.rank() == 3) throw Error(ErrorCode::usage, "the last one");
    });
  });
  for (const RankEnd& end : ends) {
    EXPECT_EQ(end.error, "out of memory");
    EXPECT_EQ(end.code, static_cast<int>(ErrorCode::failed));
  }
}

}  // namespace brick_messages_test
}  // namespace quench::pipeline
