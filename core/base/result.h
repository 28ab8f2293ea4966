// Result<T>: a value, or an Error that says what happened and what the user can do about it.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <variant>

namespace likeness {

enum class ErrorCode {
  bad_input,           // a file or option given by the user is not valid
  not_found,           // a file or folder is absent
  no_face,             // the pictures hold no usable face
  io,                  // reading or writing failed
  no_space,            // the disk or folder cannot take the result
  missing_dependency,  // a program or data file that Likeness needs is not installed
  failed,              // the computation could not reach a usable result
  cancelled            // the user asked to stop; not a failure
};

struct Error {
  ErrorCode code = ErrorCode::failed;
  std::string what;   // the fact, with numbers
  std::string fix;    // what the user can do now
  std::string where;  // file or stage, may be empty
};

template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}
  Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}

  bool ok() const { return state_.index() == 0; }
  explicit operator bool() const { return ok(); }

  // Precondition of value access: ok(). Of error(): !ok(). Checked by std::get.
  T& value() & { return std::get<0>(state_); }
  const T& value() const& { return std::get<0>(state_); }
  T&& value() && { return std::get<0>(std::move(state_)); }
  T& operator*() & { return value(); }
  const T& operator*() const& { return value(); }
  T&& operator*() && { return std::move(*this).value(); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }
  const Error& error() const { return std::get<1>(state_); }

 private:
  std::variant<T, Error> state_;
};

template <>
class [[nodiscard]] Result<void> {
 public:
  Result() = default;
  Result(Error error) : error_(std::move(error)) {}
  bool ok() const { return !error_.has_value(); }
  explicit operator bool() const { return ok(); }
  const Error& error() const { return error_.value(); }

 private:
  std::optional<Error> error_;
};

// The outcome of work that was asked to stop.
inline Error cancelled_error() {
  return {ErrorCode::cancelled, "Stopped on request.", "Run the same command again to continue.", ""};
}

}  // namespace likeness
