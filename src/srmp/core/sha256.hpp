#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <type_traits>

namespace srmp {

/// SHA-256 (FIPS 180-4), for content keys and checksums: contents with one digest may be taken for equal.
class Sha256 {
 public:
  using Digest = std::array<std::uint8_t, 32>;

  Sha256();
  void add(const void* data, std::size_t size);
  /// The number's bytes as this machine stores them.
  template <class T>
    requires(std::is_arithmetic_v<T>)
  void add(T number) {
    add(&number, sizeof number);
  }
  /// Of everything added; ends the object's life.
  Digest digest();

 private:
  void block(const std::uint8_t* data);

  std::array<std::uint32_t, 8> state_;
  std::array<std::uint8_t, 64> rest_{};
  std::uint64_t size_{0};
};

std::string to_hex(const Sha256::Digest& digest);

}  // namespace srmp
