#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace vantage {

/// Text from outside as it may be shown: every byte that is no printable ASCII character is a
/// question mark, so that nothing steers the terminal; what is longer than `most` characters is cut
/// off and ends with '~'.
std::string Shown(std::string_view text, size_t most = 200);

/// Left in a column of so many characters; longer text is cut.
std::string Padded(std::string_view text, size_t columns);

/// "0:07", "1:02:05", "3d04:05"; "-" unless it is finite and not negative.
std::string DurationText(double seconds);
/// Of so few characters as fit a table: "0.3", "12", "1234", "1e+09"; "-" for NaN and infinity.
std::string NumberText(double value);
/// "512", "12.3 k", "4.0 M": with the powers of 1000.
std::string ScaledText(double bytes);
/// "23 us", "0.4 ms", "12 ms", "1.2 s"; "-" unless it is finite.
std::string LatencyText(double seconds);

}  // namespace vantage
