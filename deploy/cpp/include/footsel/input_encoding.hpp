/// What a network sees of a local map: image planes in [0, 1] or [-1, 1].
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

#include "footsel/local_map.hpp"

namespace footsel {

/// One plane of the input.
enum class Plane {
    height,   ///< depth below L_i as a share of the range, 1 where unknown
    unknown,  ///< 1 where no height is known
    roll,     ///< constant, 1 at TILT_RANGE
    pitch,    ///< constant, 1 at TILT_RANGE
    above,    ///< rise above L_i as a share of the range, 0 where unknown
};

inline std::optional<Plane> plane_of(std::string_view text) noexcept {
    if (text == "height") return Plane::height;
    if (text == "unknown") return Plane::unknown;
    if (text == "roll") return Plane::roll;
    if (text == "pitch") return Plane::pitch;
    if (text == "above") return Plane::above;
    return std::nullopt;
}

/// Tilt that a constant plane shows as 1, 15 degrees. [rad]
inline constexpr double TILT_RANGE = 15.0 * 3.14159265358979323846 / 180.0;

/// Which planes a network takes, in this order.
struct InputEncoding {
    std::vector<Plane> planes;
    bool quantised = false;   ///< heights are rounded to 8 bits, as in the paper
    double height_range = 0;  ///< depth below L_i, or rise above it, that an image shows as 1, in [m]

    /// Write one map's planes to `input` (planes, 40, 40).
    ///
    /// heights: (40, 40) relative to L_i, NaN = unknown, in [m]. roll, pitch: of the base, in [rad].
    /// mirrored: show a right leg as its left twin: y turned round and the roll negated.
    void encode(const float* heights, double roll, double pitch, bool mirrored, float* input) const noexcept {
        for (Plane plane : planes) {
            switch (plane) {
                case Plane::height: encode_share(heights, -1.0F, 1.0F, mirrored, input); break;
                case Plane::above: encode_share(heights, 1.0F, 0.0F, mirrored, input); break;
                case Plane::unknown: encode_unknown(heights, mirrored, input); break;
                case Plane::roll: std::fill_n(input, MAP_CELLS, tilt(mirrored ? -roll : roll)); break;
                case Plane::pitch: std::fill_n(input, MAP_CELLS, tilt(pitch)); break;
            }
            input += MAP_CELLS;
        }
    }

    bool operator==(const InputEncoding& other) const noexcept {
        return planes == other.planes && quantised == other.quantised && height_range == other.height_range;
    }

private:
    static float tilt(double angle) noexcept { return static_cast<float>(angle) / static_cast<float>(TILT_RANGE); }

    /// Heights times `sign` as a share of the range, `unknown` where there is none.
    void encode_share(const float* heights, float sign, float unknown, bool mirrored, float* input) const noexcept {
        const float range = static_cast<float>(height_range);
        for (std::size_t cell = 0; cell < MAP_CELLS; ++cell) {
            const float share = sign * heights[mirrored ? mirror_of(cell) : cell] / range;
            const float image = std::isnan(share) ? unknown : std::clamp(share, 0.0F, 1.0F);
            input[cell] = quantised ? std::nearbyint(image * 255.0F) / 255.0F : image;
        }
    }

    static void encode_unknown(const float* heights, bool mirrored, float* input) noexcept {
        for (std::size_t cell = 0; cell < MAP_CELLS; ++cell) {
            input[cell] = std::isnan(heights[mirrored ? mirror_of(cell) : cell]) ? 1.0F : 0.0F;
        }
    }
};

}  // namespace footsel
