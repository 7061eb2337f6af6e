// SPDX-License-Identifier: Apache-2.0
// Values as bytes and back, for pickles: numbers as they are in memory, large arrays apart from the rest and not
// copied.
#pragma once

#include <Eigen/Core>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "arrays.h"
#include "quench/error.h"
#include "quench/shape.h"

namespace quench::python {

/// Is<T>: T or const T, for what is written and read by one function.
template <class T, class U>
concept Is = std::same_as<std::remove_const_t<T>, U>;

template <class T>
inline constexpr bool kIsMatrix = false;
template <int Rows, int Columns>
inline constexpr bool kIsMatrix<Eigen::Matrix<double, Rows, Columns>> = Rows > 0 && Columns > 0;

/// What is written as it is in memory: without pointers and gaps.
template <class T>
inline constexpr bool kIsPlain = std::is_arithmetic_v<T> || std::is_enum_v<T> || kIsMatrix<T> || std::is_same_v<T, Run>;
template <class T, std::size_t N>
inline constexpr bool kIsPlain<std::array<T, N>> = kIsPlain<T>;

inline constexpr std::size_t kLargeBytes = 1024;  ///< arrays from here on are apart

/// Collects the parts of a value. Other types are written by functions fields(archive, value) that hand their members
/// to the archive; Reader reads them with the same functions.
class Writer {
 public:
  /// `owner` keeps the arrays of the value alive.
  explicit Writer(std::shared_ptr<const void> owner) : owner_(std::move(owner)) {}

  std::string small;
  std::vector<Array> large;

  template <class... T>
  void operator()(const T&... values) {
    (put(values), ...);
  }
  /// An array of its own, which may go afterwards.
  template <class T>
  void own(std::vector<T> values) {
    auto kept = std::make_shared<const std::vector<T>>(std::move(values));
    std::swap(owner_, other_ = kept);
    put(*kept);
    std::swap(owner_, other_);
    other_.reset();
  }

 private:
  void bytes(const void* data, std::size_t size) {
    if (size > 0) small.append(static_cast<const char*>(data), size);
  }
  void count(std::size_t n) {
    const std::uint64_t wide = n;
    bytes(&wide, sizeof wide);
  }
  template <class T>
  void put(const T& value) {
    if constexpr (kIsPlain<T>)
      bytes(&value, sizeof(T));
    else
      fields(*this, value);
  }
  void put(const std::string& text) {
    count(text.size());
    bytes(text.data(), text.size());
  }
  void put(const std::filesystem::path& path) { put(path.string()); }
  /// Read as a vector.
  template <class T>
  void put(const std::span<const T>& values) {
    count(values.size());
    if constexpr (kIsPlain<T>) {
      if (values.size_bytes() < kLargeBytes)
        bytes(values.data(), values.size_bytes());
      else
        large.push_back(
            {owner_, values.data(), format_of<std::uint8_t>(), 1, {static_cast<py::ssize_t>(values.size_bytes())}});
    } else {
      for (const T& value : values) put(value);
    }
  }
  template <class T>
  void put(const std::vector<T>& values) {
    put(std::span<const T>(values));
  }
  template <class T>
  void put(const std::optional<T>& value) {
    put(value.has_value());
    if (value) put(*value);
  }
  template <class... T>
  void put(const std::variant<T...>& value) {
    put(static_cast<std::uint8_t>(value.index()));
    std::visit([&](const auto& held) { put(held); }, value);
  }
  template <class A, class B>
  void put(const std::pair<A, B>& value) {
    put(value.first);
    put(value.second);
  }

  std::shared_ptr<const void> owner_, other_;
};

/// Takes values in the order in which a Writer was given them. Throws Error(input) where there is less than was
/// written.
class Reader {
 public:
  Reader(std::string_view small, std::vector<std::span<const std::byte>> large)
      : small_(small), large_(std::move(large)) {}

  template <class... T>
  void operator()(T&... values) {
    (get(values), ...);
  }
  template <class T>
  T take() {
    T value{};
    get(value);
    return value;
  }
  /// Throws Error(input) where something is left.
  void finish() const {
    if (at_ != small_.size() || next_ != large_.size()) refuse();
  }

 private:
  [[noreturn]] static void refuse() { throw Error(ErrorCode::input, "the pickle is damaged; make it again"); }
  std::size_t left() const { return small_.size() - at_; }
  void bytes(void* data, std::size_t size) {
    if (size > left()) refuse();
    if (size > 0) std::memcpy(data, small_.data() + at_, size);
    at_ += size;
  }
  std::size_t count() {
    std::uint64_t wide = 0;
    bytes(&wide, sizeof wide);
    return static_cast<std::size_t>(wide);
  }
  template <class T>
  void get(T& value) {
    if constexpr (std::is_same_v<T, bool>)
      value = take<std::uint8_t>() != 0;
    else if constexpr (kIsPlain<T>)
      bytes(&value, sizeof(T));
    else
      fields(*this, value);
  }
  void get(std::string& text) {
    const std::size_t n = count();
    if (n > left()) refuse();
    text.assign(small_.substr(at_, n));
    at_ += n;
  }
  void get(std::filesystem::path& path) { path = take<std::string>(); }
  template <class T>
  void get(std::vector<T>& values) {
    const std::size_t n = count();
    if constexpr (kIsPlain<T>) {
      if (n < kLargeBytes && n * sizeof(T) < kLargeBytes) {
        values.resize(n);
        bytes(values.data(), n * sizeof(T));
      } else {
        if (next_ == large_.size() || large_[next_].size() / sizeof(T) != n || large_[next_].size() % sizeof(T))
          refuse();
        values.resize(n);
        std::memcpy(static_cast<void*>(values.data()), large_[next_].data(), n * sizeof(T));
        ++next_;
      }
    } else {
      if (n > left()) refuse();  // each takes a byte or more
      values.clear();
      values.reserve(n);
      for (std::size_t i = 0; i < n; ++i) values.push_back(take<T>());
    }
  }
  template <class T>
  void get(std::optional<T>& value) {
    value.reset();
    if (take<bool>()) value.emplace(take<T>());
  }
  template <class... T>
  void get(std::variant<T...>& value) {
    const std::size_t index = take<std::uint8_t>();
    if (index >= sizeof...(T)) refuse();
    std::size_t i = 0;
    ((i++ == index ? static_cast<void>(value = take<T>()) : static_cast<void>(0)), ...);
  }
  template <class A, class B>
  void get(std::pair<A, B>& value) {
    get(value.first);
    get(value.second);
  }

  std::string_view small_;
  std::vector<std::span<const std::byte>> large_;
  std::size_t at_ = 0, next_ = 0;
};

}  // namespace quench::python
