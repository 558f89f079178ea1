#include "srmp/core/utf8.hpp"

#include <cstdint>

namespace srmp {

namespace {

/// The length of the character of which `lead` is the first byte, 0 if it cannot be one, and the range of the byte
/// after it, which excludes overlong forms, surrogates and what lies beyond U+10FFFF.
struct Lead {
  std::size_t length;
  std::uint8_t low, high;
};

Lead lead_of(std::uint8_t lead) {
  if (lead < 0x80) return {1, 0, 0};
  if (lead < 0xC2) return {0, 0, 0};
  if (lead < 0xE0) return {2, 0x80, 0xBF};
  if (lead < 0xF0) return {3, std::uint8_t(lead == 0xE0 ? 0xA0 : 0x80), std::uint8_t(lead == 0xED ? 0x9F : 0xBF)};
  if (lead < 0xF5) return {4, std::uint8_t(lead == 0xF0 ? 0x90 : 0x80), std::uint8_t(lead == 0xF4 ? 0x8F : 0xBF)};
  return {0, 0, 0};
}

}  // namespace

std::size_t find_invalid_utf8(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(text[i]); };
  for (std::size_t i = 0; i < text.size();) {
    const Lead lead = lead_of(byte(i));
    if (lead.length == 0 || lead.length > text.size() - i) return i;
    for (std::size_t k = 1; k < lead.length; ++k) {
      const std::uint8_t low = k == 1 ? lead.low : std::uint8_t{0x80}, high = k == 1 ? lead.high : std::uint8_t{0xBF};
      if (byte(i + k) < low || byte(i + k) > high) return i;
    }
    i += lead.length;
  }
  return std::string_view::npos;
}

}  // namespace srmp
