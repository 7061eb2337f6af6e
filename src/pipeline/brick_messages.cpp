// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <charconv>
#include <map>
#include <new>
#include <numeric>
#include <utility>

#include "base/memory.h"
#include "pipeline/brick_files.h"
#include "quench/bricks.h"
#include "quench/error.h"

namespace quench::pipeline {
namespace {

using Messages = std::vector<std::vector<std::string_view>>;

// What a brick needs of the round before: a part, or only its head.
struct PartNeed {
  std::size_t brick;
  bool whole;
  friend auto operator<=>(const PartNeed&, const PartNeed&) = default;
};

// What a process has of the parts: those it has made, and those others have sent for the brick it works on.
class RankStore : public BrickStore {
 public:
  RankStore(const std::filesystem::path& work, Context* context)
      : folder_(work, context), made_(plan().rounds.size()) {}

  const BrickPlan& plan() const { return folder_.file.plan; }
  const std::string& report() const { return folder_.file.report; }
  LoadedShape shape() { return folder_.shape(); }
  VoxelShape voxels(const dual::bricks::Box& box) override { return folder_.voxels(box); }
  const Surface* surface() override { return folder_.surface(); }
  bool has(std::size_t round, std::size_t brick) override { return made_[round].contains(brick); }
  std::int64_t size(std::size_t round, std::size_t brick) override {
    const std::string& held = has(round, brick) ? made_[round].at(brick) : received_.at({brick, true});
    return static_cast<std::int64_t>(held.size());
  }
  std::string part(std::size_t round, std::size_t brick) override { return bytes(round, {brick, true}); }
  std::string head(std::size_t round, std::size_t brick) override { return bytes(round, {brick, false}); }
  void put(std::size_t round, std::size_t brick, const std::string& bytes) override { made_[round][brick] = bytes; }

  // Of a brick that this process has made.
  std::string_view to_send(std::size_t round, const PartNeed& need) const {
    const std::string_view made = made_[round].at(need.brick);
    return need.whole ? made : made.substr(0, dual::bricks::loose_bytes(made, plan().label(round, need.brick)));
  }
  void receive(const PartNeed& need, std::string bytes) { received_[need] = std::move(bytes); }
  void forget_received() { received_.clear(); }
  void forget(std::size_t round, std::size_t brick) { made_[round].erase(brick); }

 private:
  std::string bytes(std::size_t round, const PartNeed& need) {
    if (has(round, need.brick)) return std::string(to_send(round, need));
    return received_.at(need);
  }

  FolderBrickStore folder_;
  std::vector<std::map<std::size_t, std::string>> made_;  // per round
  std::map<PartNeed, std::string> received_;              // of the round before the present one
};

// A process. Every round is done in waves of a brick per process, of about as many sites. All know the plan, so nobody
// has to ask for what it needs.
class BrickRank {
 public:
  BrickRank(const std::filesystem::path& work, Messenger& messenger, Context* context)
      : messenger_(messenger), context_(context), store_(work, context), plan_(store_.plan()) {}

  std::optional<MergedBricks> run(const std::function<void(std::size_t, std::size_t)>& on_round) {
    for (round_ = 0; round_ < plan_.rounds.size(); ++round_) {
      const std::size_t bricks = plan_.rounds[round_].bricks.size();
      if (on_round) on_round(round_ + 1, bricks);
      arrange_round();
      for (std::size_t first = 0; first < bricks; first += messenger_.ranks()) do_wave(first);
    }
    return merged();
  }

 private:
  // Who does what, and when the parts of the round before are needed for the last time.
  void arrange_round() {
    const auto& bricks = plan_.rounds[round_].bricks;
    owner_before_ = std::exchange(owner_, std::vector<std::size_t>(bricks.size()));
    order_.resize(bricks.size());
    std::iota(order_.begin(), order_.end(), std::size_t{0});
    std::ranges::stable_sort(order_, std::ranges::greater(), [&](std::size_t b) { return bricks[b].sites; });
    last_need_.assign(owner_before_.size(), 0);
    for (std::size_t at = 0; at < order_.size(); ++at) {
      owner_[order_[at]] = at % messenger_.ranks();
      for (const PartNeed& need : needs(at)) last_need_[need.brick] = at;
    }
  }

  // What the brick at a place of the order needs.
  std::vector<PartNeed> needs(std::size_t at) const {
    std::vector<PartNeed> needs;
    if (round_ == 0 || at >= order_.size()) return needs;
    for (const std::size_t part : plan_.below(round_, order_[at])) needs.push_back({part, true});
    for (const std::size_t head : plan_.beside(round_, order_[at])) needs.push_back({head, false});
    return needs;
  }

  void do_wave(std::size_t first) {
    const std::size_t end = std::min(first + messenger_.ranks(), order_.size()), mine = first + messenger_.rank();
    if (round_ > 0) send_needed(round_ - 1, owner_before_, [&](std::size_t rank) { return needs(first + rank); });
    together(messenger_, [&] {
      if (mine < end) run_brick(plan_, round_, order_[mine], store_, context_);
    });
    store_.forget_received();
    for (std::size_t brick = 0; brick < last_need_.size(); ++brick)
      if (last_need_[brick] < end) store_.forget(round_ - 1, brick);
  }

  // Every rank gets the parts of a round that needs_of(rank) names and it has not made.
  template <class NeedsOf>
  void send_needed(std::size_t round, const std::vector<std::size_t>& owner, const NeedsOf& needs_of) {
    const std::size_t own = messenger_.rank();
    Messages to(messenger_.ranks());
    for (std::size_t rank = 0; rank < to.size(); ++rank)
      if (rank != own)
        for (const PartNeed& need : needs_of(rank))
          if (owner[need.brick] == own) to[rank].push_back(store_.to_send(round, need));
    std::vector<std::vector<std::string>> from = messenger_.exchange(to);
    std::vector<std::size_t> next(from.size(), 0);
    for (const PartNeed& need : needs_of(own))
      if (const std::size_t rank = owner[need.brick]; rank != own)
        store_.receive(need, std::move(from[rank].at(next[rank]++)));
  }

  std::optional<MergedBricks> merged() {
    const std::size_t last = plan_.rounds.size() - 1;
    send_needed(last, owner_, [&](std::size_t rank) {
      std::vector<PartNeed> all;
      for (std::size_t brick = 0; rank == 0 && brick < owner_.size(); ++brick) all.push_back({brick, true});
      return all;
    });
    const std::int64_t peak = most_memory();
    if (messenger_.rank() != 0) return {};
    MergedBricks result;
    result.shape = store_.shape();
    result.core = merge_bricks(plan_, result.shape, store_, context_);
    result.report = store_.report();
    result.figures.peak_bytes = std::max(peak, base::peak_memory());
    return result;
  }

  // Of all ranks; known on rank 0.
  std::int64_t most_memory() {
    const std::string own = std::to_string(base::peak_memory());
    Messages to(messenger_.ranks());
    to[0].push_back(own);
    std::int64_t most = 0;
    for (const auto& from : messenger_.exchange(to))
      for (const std::string& text : from) most = std::max<std::int64_t>(most, std::stoll(text));
    return most;
  }

  Messenger& messenger_;
  Context* context_;
  RankStore store_;
  const BrickPlan& plan_;
  std::size_t round_ = 0;
  std::vector<std::size_t> order_;                 // bricks of the round
  std::vector<std::size_t> owner_, owner_before_;  // their ranks, and those of the round before
  std::vector<std::size_t> last_need_;             // of bricks of the round before: a place in order_
};

// The Error that `work` throws as text: its code and sentence; empty when there is none.
std::string failure_of(const std::function<void()>& work) {
  const auto text = [](ErrorCode code, const char* sentence) {
    return std::to_string(static_cast<int>(code)) + ' ' + sentence;
  };
  try {
    work();
    return {};
  } catch (const Error& error) {
    return text(error.code(), error.what());
  } catch (const std::bad_alloc&) {
    return text(ErrorCode::failed, "out of memory");
  } catch (const std::exception& error) {
    return text(ErrorCode::failed, error.what());
  }
}

}  // namespace

void together(Messenger& messenger, const std::function<void()>& work) {
  const std::string own = failure_of(work);
  const Messages to(messenger.ranks(), {std::string_view(own)});
  for (const std::vector<std::string>& from : messenger.exchange(to)) {
    const std::string& failure = from.at(0);
    if (failure.empty()) continue;
    int code = 0;
    const char* const end = failure.data() + failure.size();
    const char* const sentence = std::from_chars(failure.data(), end, code).ptr + 1;
    throw Error(static_cast<ErrorCode>(code), std::string(sentence, end));
  }
}

std::optional<MergedBricks> core_by_messages(const std::filesystem::path& work, Messenger& messenger,
                                             const std::function<void(std::size_t, std::size_t)>& on_round,
                                             Context* context) {
  std::optional<BrickRank> rank;
  together(messenger, [&] { rank.emplace(work, messenger, context); });
  return rank->run(on_round);
}

}  // namespace quench::pipeline
