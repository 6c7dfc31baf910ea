/// An answer or an error, without exceptions and without allocation.
#pragma once

#include <cassert>
#include <cstdarg>
#include <cstdio>
#include <exception>
#include <new>
#include <optional>
#include <type_traits>
#include <utility>

namespace footsel {

/// Whose fault an error is, and so what a caller can do about it.
enum class ErrorCode {
    input,   ///< a pose, a nominal foothold or an option makes no sense
    map,     ///< the elevation map makes no sense
    model,   ///< a model file is missing, damaged, foreign or of another contract
    engine,  ///< onnxruntime failed, or memory ran out
};

/// What was wrong and what to do, in one line. The text lives in the error itself: reporting one allocates nothing.
class Error {
public:
    ErrorCode code = ErrorCode::input;

    [[nodiscard]] const char* what() const noexcept { return text_; }

    [[gnu::format(printf, 2, 3)]] static Error format(ErrorCode code, const char* pattern, ...) noexcept {
        Error error;
        error.code = code;
        std::va_list arguments;
        va_start(arguments, pattern);
        std::vsnprintf(error.text_, sizeof error.text_, pattern, arguments);
        va_end(arguments);
        return error;
    }

private:
    char text_[512] = "";
};

/// A T, or why there is none. Ask before you look: `if (result) use(*result); else report(result.error().what());`
template <class T>
class [[nodiscard]] Result {
public:
    Result(T value) noexcept(std::is_nothrow_move_constructible_v<T>) : value_(std::move(value)) {}
    Result(const Error& error) noexcept : error_(error) {}

    explicit operator bool() const noexcept { return value_.has_value(); }

    T& operator*() & noexcept { return assert(value_), *value_; }
    const T& operator*() const& noexcept { return assert(value_), *value_; }
    T&& operator*() && noexcept { return assert(value_), std::move(*value_); }
    T* operator->() noexcept { return &**this; }
    const T* operator->() const noexcept { return &**this; }

    /// Why there is no value; an empty text if there is one.
    [[nodiscard]] const Error& error() const noexcept { return error_; }

private:
    std::optional<T> value_;
    Error error_;
};

/// Success, or an error: a Result of nothing.
template <>
class [[nodiscard]] Result<void> {
public:
    Result() noexcept = default;
    Result(const Error& error) noexcept : error_(error), failed_(true) {}

    explicit operator bool() const noexcept { return !failed_; }
    [[nodiscard]] const Error& error() const noexcept { return error_; }

private:
    Error error_;
    bool failed_ = false;
};

namespace detail {

/// The border that no exception crosses: whatever `body` throws becomes an error that begins with `doing`.
template <class Body>
auto guarded(ErrorCode code, const char* doing, Body&& body) noexcept -> decltype(body()) {
    try {
        return body();
    } catch (const std::bad_alloc&) {
        return Error::format(ErrorCode::engine, "%s: out of memory", doing);
    } catch (const std::exception& exception) {
        return Error::format(code, "%s: %s", doing, exception.what());
    } catch (...) {
        return Error::format(code, "%s: an exception that is no std::exception", doing);
    }
}

}  // namespace detail
}  // namespace footsel
