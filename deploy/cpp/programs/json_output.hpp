/// Footholds as JSON, with the keys of `footsel select`.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>

#include "footsel/foothold.hpp"

namespace footsel {

/// Writes values one after the other and puts the commas between them.
class JsonWriter {
public:
    explicit JsonWriter(std::FILE* file) noexcept : file_(file) {}

    JsonWriter& open(char bracket, const char* key = nullptr) {
        begin(key);
        std::fputc(bracket, file_);
        first_ = true;
        return *this;
    }
    JsonWriter& close(char bracket) {
        std::fputc(bracket, file_);
        first_ = false;
        return *this;
    }
    JsonWriter& number(double value, const char* key = nullptr) {
        begin(key);
        // JSON knows no NaN: what there is not is null.
        std::isfinite(value) ? std::fprintf(file_, "%.17g", value) : std::fputs("null", file_);
        return *this;
    }
    /// UTF-8; null for none.
    JsonWriter& text(const char* text, const char* key = nullptr) {
        begin(key);
        if (text == nullptr) return std::fputs("null", file_), *this;
        std::fputc('"', file_);
        for (const char* c = text; *c != '\0'; ++c) {
            if (static_cast<unsigned char>(*c) < 0x20) {
                std::fprintf(file_, "\\u%04x", static_cast<unsigned>(*c));
            } else {
                if (*c == '"' || *c == '\\') std::fputc('\\', file_);
                std::fputc(*c, file_);
            }
        }
        std::fputc('"', file_);
        return *this;
    }
    template <class Numbers>
    JsonWriter& numbers(const Numbers& values, const char* key = nullptr) {
        open('[', key);
        for (auto value : values) number(static_cast<double>(value));
        return close(']');
    }
    JsonWriter& nothing(const char* key) { return text(nullptr, key); }

private:
    void begin(const char* key) {
        if (!first_) std::fputs(", ", file_);
        first_ = false;
        if (key != nullptr) std::fprintf(file_, "\"%s\": ", key);
    }

    std::FILE* file_;
    bool first_ = true;
};

inline void write_foothold(JsonWriter& json, const Foothold& foothold, const char* key) {
    json.open('{', key).text(foothold.status_name(), "status");
    json.text(foothold.ok() ? nullptr : foothold.reason, "reason");
    if (foothold.ok()) {
        json.numbers(foothold.position, "position");
        json.numbers(std::array<int, 2>{foothold.cell.i, foothold.cell.j}, "cell");
        json.number(foothold.cost, "cost").number(foothold.class_, "class");
    } else {
        json.nothing("position").nothing("cell").nothing("cost").nothing("class");
    }
    json.number(foothold.final_cost, "final_cost").numbers(foothold.nominal, "nominal");
    json.number(foothold.distance_to_nominal, "distance_to_nominal").number(foothold.confidence, "confidence");
    json.open('[', "alternatives");
    for (std::size_t i = 0; i < foothold.alternative_count; ++i) {
        const Candidate& other = foothold.alternatives[i];
        json.open('{').numbers(other.position, "position").number(other.final_cost, "final_cost").close('}');
    }
    json.close(']').close('}');
}

inline void write_footholds(JsonWriter& json, const Selection& selection, const char* key) {
    json.open('{', key);
    for (Leg leg : LEGS) {
        if (selection.legs.contains(leg)) write_foothold(json, selection[leg], name(leg));
    }
    json.close('}');
}

}  // namespace footsel
