#pragma once

#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "common/check.h"

namespace vantage {

enum class ErrorCode {
  kInvalidArgument,  ///< A value from outside is not what was expected.
  kNotFound,         ///< A file, device, model or channel is not there.
  kCorrupt,          ///< Bytes do not have the format that they claim.
  kUnavailable,      ///< It exists but can't be used now (busy, no route, no permission).
  kIo,               ///< The operating system refused a read or write.
};

/// What went wrong at a boundary. `message` is one sentence that names the thing, its value, what
/// was expected and, where there is one, the command that mends it.
struct Error {
  ErrorCode code = ErrorCode::kInvalidArgument;
  std::string message;
};

/// A value, or the reason why there is none.
template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : content_(std::move(value)) {}      // NOLINT(google-explicit-constructor)
  Result(Error error) : content_(std::move(error)) {}  // NOLINT(google-explicit-constructor)

  [[nodiscard]] bool ok() const { return std::holds_alternative<T>(content_); }
  explicit operator bool() const { return ok(); }

  /// The value; the program stops if there is none.
  T& value() & {
    VANTAGE_CHECK(ok(), error().message);
    return std::get<T>(content_);
  }
  const T& value() const& {
    VANTAGE_CHECK(ok(), error().message);
    return std::get<T>(content_);
  }
  T&& value() && {
    VANTAGE_CHECK(ok(), error().message);
    return std::get<T>(std::move(content_));
  }
  [[nodiscard]] const Error& error() const { return std::get<Error>(content_); }

  T& operator*() & { return value(); }
  const T& operator*() const& { return value(); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }

 private:
  std::variant<T, Error> content_;
};

/// Success, or the reason of failure.
template <>
class [[nodiscard]] Result<void> {
 public:
  Result() = default;
  Result(Error error) : error_(std::move(error)) {}  // NOLINT(google-explicit-constructor)

  [[nodiscard]] bool ok() const { return !error_.has_value(); }
  explicit operator bool() const { return ok(); }
  [[nodiscard]] const Error& error() const { return *error_; }

 private:
  std::optional<Error> error_;
};

}  // namespace vantage
