#pragma once

namespace gelenk::testing {

/// Built with AddressSanitizer: two to four times slower, so that tests that go through many cases take
/// fewer.
#if defined(__SANITIZE_ADDRESS__)
inline constexpr bool sanitized = true;
#elif defined(__has_feature)
inline constexpr bool sanitized = __has_feature(address_sanitizer);
#else
inline constexpr bool sanitized = false;
#endif

}  // namespace gelenk::testing
