/// A reader of JSON (RFC 8259), for the contract in a model's metadata.
///
/// The one document that this library ever reads is a page long and read once; a hundred lines spare its users a
/// dependency.
#pragma once

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <cstdint>
#include <locale>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace footsel {

/// A JSON value. Looking for what is not there gives nothing, never an exception.
class Json {
public:
    enum class Kind { null, boolean, number, string, array, object };

    /// The value that `text` holds, or nothing if it is no JSON. Allocates.
    static std::optional<Json> parse(std::string_view text);

    Kind kind() const noexcept { return kind_; }
    std::optional<bool> boolean() const noexcept { return when(Kind::boolean, number_ != 0); }
    std::optional<double> number() const noexcept { return when(Kind::number, number_); }
    const std::string* string() const noexcept { return kind_ == Kind::string ? &string_ : nullptr; }
    /// Elements of an array; none of anything else.
    const std::vector<Json>& elements() const noexcept { return elements_; }

    /// A member of an object; null if there is none of that name. Of two, the last counts.
    const Json* find(std::string_view key) const noexcept {
        for (std::size_t i = kind_ == Kind::object ? keys_.size() : 0; i-- > 0;) {
            if (keys_[i] == key) return &elements_[i];
        }
        return nullptr;
    }

private:
    class Reader;

    template <class T>
    std::optional<T> when(Kind kind, T value) const noexcept {
        return kind_ == kind ? std::optional<T>(value) : std::nullopt;
    }

    Kind kind_ = Kind::null;
    double number_ = 0;
    std::string string_;
    std::vector<std::string> keys_;  ///< of an object's elements
    std::vector<Json> elements_;     ///< of an array or an object
};

/// Reads one value after the other; a false answer means that the text is no JSON.
class Json::Reader {
public:
    explicit Reader(std::string_view text) noexcept : rest_(text) {}

    bool document(Json& value) { return this->value(value, 0) && (skip_space(), rest_.empty()); }

private:
    /// Deeper nesting is refused rather than risk the stack.
    static constexpr int MOST_DEPTH = 32;

    bool value(Json& value, int depth) {
        skip_space();
        if (rest_.empty() || depth > MOST_DEPTH) return false;
        switch (rest_.front()) {
            case '{': return object(value, depth);
            case '[': return array(value, depth);
            case '"': return value.kind_ = Kind::string, string(value.string_);
            case 't': return value.kind_ = Kind::boolean, value.number_ = 1, take("true");
            case 'f': return value.kind_ = Kind::boolean, take("false");
            case 'n': return take("null");
            default: return value.kind_ = Kind::number, number(value.number_);
        }
    }

    bool object(Json& value, int depth) {
        value.kind_ = Kind::object;
        return items('{', '}', [&] {
            skip_space();
            return string(value.keys_.emplace_back()) && (skip_space(), take(":")) &&
                   this->value(value.elements_.emplace_back(), depth + 1);
        });
    }

    bool array(Json& value, int depth) {
        value.kind_ = Kind::array;
        return items('[', ']', [&] { return this->value(value.elements_.emplace_back(), depth + 1); });
    }

    template <class Item>
    bool items(char open, char close, Item&& item) {
        take(open), skip_space();
        if (take(close)) return true;
        do {
            if (!item()) return false;
            skip_space();
        } while (take(','));
        return take(close);
    }

    bool number(double& number) {
        const std::string_view all = rest_;
        take('-');
        if (!take('0') && !digits()) return false;
        if (take('.') && !digits()) return false;
        if (take('e') || take('E')) {
            if (!take('+')) take('-');
            if (!digits()) return false;
        }
        // Whatever decimal point the program's locale has, JSON's is a point.
        std::istringstream stream{std::string(all.substr(0, all.size() - rest_.size()))};
        stream.imbue(std::locale::classic());
        return static_cast<bool>(stream >> number);
    }

    bool string(std::string& text) {
        if (!take('"')) return false;
        while (!rest_.empty()) {
            const char c = rest_.front();
            rest_.remove_prefix(1);
            if (c == '"') return true;
            if (static_cast<unsigned char>(c) < 0x20) return false;
            if (c != '\\') text += c;
            else if (!escape(text)) return false;
        }
        return false;
    }

    bool escape(std::string& text) {
        if (rest_.empty()) return false;
        const char c = rest_.front();
        rest_.remove_prefix(1);
        constexpr std::string_view names = "\"\\/bfnrt", values = "\"\\/\b\f\n\r\t";
        if (const auto at = names.find(c); at != names.npos) return text += values[at], true;
        std::uint32_t point = 0, low = 0;
        if (c != 'u' || !hex4(point)) return false;
        if (point >= 0xD800 && point < 0xDC00) {
            // A character beyond 16 bits is written as two surrogates.
            if (!take("\\u") || !hex4(low) || low < 0xDC00 || low > 0xDFFF) return false;
            point = 0x10000 + ((point - 0xD800) << 10) + (low - 0xDC00);
        } else if (point >= 0xDC00 && point <= 0xDFFF) {
            return false;
        }
        return utf8(point, text), true;
    }

    bool hex4(std::uint32_t& point) noexcept {
        for (int i = 0; i < 4; ++i) {
            constexpr std::string_view digits = "0123456789abcdef";
            if (rest_.empty()) return false;
            const auto digit = digits.find(static_cast<char>(std::tolower(static_cast<unsigned char>(rest_.front()))));
            if (digit == digits.npos) return false;
            point = point * 16 + static_cast<std::uint32_t>(digit);
            rest_.remove_prefix(1);
        }
        return true;
    }

    static void utf8(std::uint32_t point, std::string& text) {
        const int more = point < 0x80 ? 0 : point < 0x800 ? 1 : point < 0x10000 ? 2 : 3;
        constexpr std::uint32_t lead[]{0x00, 0xC0, 0xE0, 0xF0};
        text += static_cast<char>(lead[more] | (point >> (6 * more)));
        for (int i = more - 1; i >= 0; --i) text += static_cast<char>(0x80 | ((point >> (6 * i)) & 0x3F));
    }

    bool digits() noexcept {
        const std::size_t before = rest_.size();
        while (!rest_.empty() && rest_.front() >= '0' && rest_.front() <= '9') rest_.remove_prefix(1);
        return rest_.size() < before;
    }

    bool take(char c) noexcept { return take(std::string_view(&c, 1)); }
    bool take(std::string_view text) noexcept {
        if (rest_.substr(0, text.size()) != text) return false;
        rest_.remove_prefix(text.size());
        return true;
    }
    void skip_space() noexcept { rest_.remove_prefix(std::min(rest_.find_first_not_of(" \t\n\r"), rest_.size())); }

    std::string_view rest_;
};

inline std::optional<Json> Json::parse(std::string_view text) {
    Json value;
    return Reader(text).document(value) ? std::optional<Json>(std::move(value)) : std::nullopt;
}

}  // namespace footsel
