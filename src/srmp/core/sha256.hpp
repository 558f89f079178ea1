#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <type_traits>

namespace srmp {

/// SHA-256 (FIPS 180-4), for content keys and checksums: contents with equal digests may be considered equal.
class Sha256 {
 public:
  using Digest = std::array<std::uint8_t, 32>;

  Sha256();
  /// Appends bytes.
  void add(const void* data, std::size_t size);
  /// Appends the bytes of the number as this machine stores them.
  template <class T>
    requires(std::is_arithmetic_v<T>)
  void add(T number) {
    add(&number, sizeof number);
  }
  /// The digest of all that was added. Nothing may be added afterwards.
  Digest digest();

 private:
  void block(const std::uint8_t* data);

  std::array<std::uint32_t, 8> state_;
  std::array<std::uint8_t, 64> block_{};
  std::uint64_t size_{0};
};

/// 64 lower-case hexadecimal digits.
std::string to_hex(const Sha256::Digest& digest);

}  // namespace srmp
