// SPDX-License-Identifier: Apache-2.0
#include "base/csr.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <utility>

namespace quench {
namespace csr_test {

// Against a vector per row, with empty rows first, last and in between.
TEST(Csr, GroupsLikeAVectorPerRow) {
  std::mt19937 random(7);
  for (const std::size_t rows : {0u, 1u, 2u, 5u, 100u})
    for (const std::size_t items : {0u, 1u, 7u, 300u}) {
      std::vector<std::pair<std::size_t, int>> given;
      for (std::size_t i = 0; rows > 0 && i < items; ++i) given.emplace_back(random() % rows, static_cast<int>(i));
      std::vector<std::vector<int>> wanted(rows);
      for (const auto& [row, item] : given) wanted[row].push_back(item);

      auto csr = base::Csr<int>::group(rows, [&](const auto& emit) {
        for (const auto& [row, item] : given) emit(row, item);
      });
      ASSERT_EQ(csr.rows(), rows);
      EXPECT_EQ(csr.items().size(), given.size());
      EXPECT_EQ(csr.offsets().size(), rows + 1);
      EXPECT_EQ(csr.offsets().back(), given.size());
      for (std::size_t r = 0; r < rows; ++r) {
        const auto row = std::as_const(csr)[r];
        EXPECT_EQ(std::vector<int>(row.begin(), row.end()), wanted[r]);
        EXPECT_EQ(csr.items().data() + csr.offsets()[r], row.data());
      }
    }
}

TEST(Csr, HasNoRowsAtFirst) {
  const base::Csr<int> csr;
  EXPECT_EQ(csr.rows(), 0u);
  EXPECT_TRUE(csr.items().empty());
}

TEST(Csr, ItemsOfARowCanBeChanged) {
  auto csr = base::Csr<int>::group(2, [](const auto& emit) {
    emit(1, 3);
    emit(0, 9);
    emit(1, 2);
  });
  const auto row = csr[1];
  std::sort(row.begin(), row.end());
  EXPECT_EQ(csr.items(), (std::vector<int>{9, 2, 3}));
}

}  // namespace csr_test
}  // namespace quench
