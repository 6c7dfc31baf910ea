/// The four legs, the pairs that share a network, and which legs are evaluated through their mirror image.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string_view>

namespace footsel {

/// Left and right, front (F) and hind (H).
enum class Leg : std::uint8_t { LF, RF, LH, RH };

inline constexpr std::array<Leg, 4> LEGS{Leg::LF, Leg::RF, Leg::LH, Leg::RH};

/// Legs that share a network: it is trained for the left one, the right one is its mirror image in the base's xz plane.
enum class Pair : std::uint8_t { front, hind };

inline constexpr std::array<Pair, 2> PAIRS{Pair::front, Pair::hind};

constexpr std::size_t index(Leg leg) noexcept { return static_cast<std::size_t>(leg); }
constexpr std::size_t index(Pair pair) noexcept { return static_cast<std::size_t>(pair); }

constexpr Pair pair_of(Leg leg) noexcept { return index(leg) < 2 ? Pair::front : Pair::hind; }
constexpr bool is_right(Leg leg) noexcept { return index(leg) % 2 == 1; }

constexpr const char* name(Leg leg) noexcept {
    constexpr const char* names[]{"LF", "RF", "LH", "RH"};
    return names[index(leg) % 4];
}
constexpr const char* name(Pair pair) noexcept { return pair == Pair::front ? "front" : "hind"; }

inline std::optional<Leg> leg_of(std::string_view text) noexcept {
    for (Leg leg : LEGS) {
        if (text == name(leg)) return leg;
    }
    return std::nullopt;
}

/// A value for each leg.
template <class T>
struct PerLeg {
    std::array<T, 4> values{};

    constexpr T& operator[](Leg leg) noexcept { return values[index(leg) % 4]; }
    constexpr const T& operator[](Leg leg) const noexcept { return values[index(leg) % 4]; }
};

/// Some of the legs; by default, all.
class LegSet {
public:
    constexpr LegSet() noexcept : bits_(0b1111) {}
    constexpr LegSet(std::initializer_list<Leg> legs) noexcept {
        for (Leg leg : legs) insert(leg);
    }

    static constexpr LegSet none() noexcept { return LegSet(0U); }

    constexpr void insert(Leg leg) noexcept { bits_ |= 1U << (index(leg) % 4); }
    constexpr bool contains(Leg leg) const noexcept { return (bits_ >> (index(leg) % 4)) & 1U; }

private:
    constexpr explicit LegSet(unsigned bits) noexcept : bits_(bits) {}

    unsigned bits_ = 0;
};

}  // namespace footsel
