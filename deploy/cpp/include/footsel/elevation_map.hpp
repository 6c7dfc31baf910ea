/// A world-aligned elevation map that belongs to someone else, and how it is sampled between its cells.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "footsel/result.hpp"

namespace footsel {

/// A view of terrain heights on a regular grid of the world frame W; nothing is copied.
///
/// Cell (i, j) has its centre at `position + ((i, j) - (n - 1) / 2) * resolution`, i along +x and j along +y. Its height
/// in [m] is `elevation[i * stride_x + j * stride_y]`, NaN = unknown. Strides may be negative: a map whose index grows
/// along -x begins at its last row.
struct ElevationMap {
    const float* elevation = nullptr;
    std::size_t nx = 0, ny = 0;                 ///< cells along x and y, at least 2
    std::ptrdiff_t stride_x = 0, stride_y = 0;  ///< steps between neighbours, in floats
    double resolution = 0.0;                    ///< side of a cell, in [m]
    std::array<double, 2> position{0.0, 0.0};   ///< world xy of the map's centre, in [m]

    /// j runs fastest, as in C and numpy.
    static ElevationMap row_major(const float* elevation, std::size_t nx, std::size_t ny, double resolution,
                                  std::array<double, 2> position = {0.0, 0.0}) noexcept {
        return {elevation, nx, ny, static_cast<std::ptrdiff_t>(ny), 1, resolution, position};
    }

    /// i runs fastest, as in Eigen and Fortran.
    static ElevationMap column_major(const float* elevation, std::size_t nx, std::size_t ny, double resolution,
                                     std::array<double, 2> position = {0.0, 0.0}) noexcept {
        return {elevation, nx, ny, 1, static_cast<std::ptrdiff_t>(nx), resolution, position};
    }

    /// As grid_map and Eigen keep it: i runs fastest, and both indices grow against the axes of the world. `layer` is the
    /// data of a layer whose start index is (0, 0), `rows` and `columns` are its size.
    static ElevationMap grid_map(const float* layer, std::size_t rows, std::size_t columns, double resolution,
                                 std::array<double, 2> position) noexcept {
        const float* last = layer == nullptr ? nullptr : layer + (rows * columns > 0 ? rows * columns - 1 : 0);
        return {last, rows, columns, -1, -static_cast<std::ptrdiff_t>(rows), resolution, position};
    }

    /// Whether the map makes sense. Its heights are looked at only where they are sampled: a call need not read it all.
    Result<void> check() const noexcept {
        if (nx < 2 || ny < 2) {
            return Error::format(ErrorCode::map, "elevation has shape (%zu, %zu); expected at least 2x2 cells", nx, ny);
        }
        if (elevation == nullptr) return Error::format(ErrorCode::map, "the elevation map is null; give its heights");
        if (stride_x == 0 || stride_y == 0) {
            return Error::format(ErrorCode::map, "strides are %td and %td; expected steps other than 0", stride_x, stride_y);
        }
        if (!std::isfinite(resolution) || resolution <= 0) {
            return Error::format(ErrorCode::map, "resolution is %g; expected a cell side above 0 m", resolution);
        }
        if (!std::isfinite(position[0]) || !std::isfinite(position[1])) {
            return Error::format(ErrorCode::map, "position is (%g, %g); expected two finite numbers, world xy in metres",
                                 position[0], position[1]);
        }
        return {};
    }

    /// Height of a cell, in [m].
    float at(std::size_t i, std::size_t j) const noexcept {
        return elevation[static_cast<std::ptrdiff_t>(i) * stride_x + static_cast<std::ptrdiff_t>(j) * stride_y];
    }

    /// Whether a world point lies on the map, known or not.
    bool contains(double x, double y) const noexcept {
        const double u = index_along(0, x), v = index_along(1, y);
        return u >= -0.5 && u < static_cast<double>(nx) - 0.5 && v >= -0.5 && v < static_cast<double>(ny) - 0.5;
    }

    /// Height at a world point, in [m]; NaN where the cell that it falls in is unknown or off the map.
    ///
    /// Heights are interpolated bilinearly, so a plane stays that plane at any yaw and any cell size. Unknown neighbours
    /// carry no weight: holes neither grow nor shrink. Infinity says that a cell around the point is infinite, which no
    /// map may be.
    float sample(double x, double y) const noexcept {
        constexpr float unknown = std::numeric_limits<float>::quiet_NaN();
        const double last_i = static_cast<double>(nx) - 1, last_j = static_cast<double>(ny) - 1;
        double u = index_along(0, x), v = index_along(1, y);
        // Said this way round, NaN is outside too.
        if (!(u + 0.5 >= 0 && u + 0.5 < last_i + 1 && v + 0.5 >= 0 && v + 0.5 < last_j + 1)) return unknown;

        u = std::clamp(u, 0.0, last_i);
        v = std::clamp(v, 0.0, last_j);
        const std::size_t i = std::min(static_cast<std::size_t>(u), nx - 2);
        const std::size_t j = std::min(static_cast<std::size_t>(v), ny - 2);
        const double a = u - static_cast<double>(i), b = v - static_cast<double>(j);
        const float heights[]{at(i, j), at(i, j + 1), at(i + 1, j), at(i + 1, j + 1)};
        const double weights[]{(1 - a) * (1 - b), (1 - a) * b, a * (1 - b), a * b};

        if (std::isfinite(heights[0] + heights[1] + heights[2] + heights[3])) {
            double sum = 0, weight = 0;
            for (int k = 0; k < 4; ++k) {
                sum += weights[k] * static_cast<double>(heights[k]);
                weight += weights[k];
            }
            return static_cast<float>(sum / weight);
        }
        const int nearest = 2 * (std::floor(u + 0.5) > static_cast<double>(i)) + (std::floor(v + 0.5) > static_cast<double>(j));
        double sum = 0, weight = 0;
        for (int k = 0; k < 4; ++k) {
            if (std::isinf(heights[k])) return std::numeric_limits<float>::infinity();
            if (std::isnan(heights[k])) continue;
            sum += weights[k] * static_cast<double>(heights[k]);
            weight += weights[k];
        }
        return std::isnan(heights[nearest]) ? unknown : static_cast<float>(sum / weight);
    }

    /// Fractional index of a world coordinate along an axis, a whole number at cell centres.
    double index_along(int axis, double coordinate) const noexcept {
        const double centre = (static_cast<double>(axis == 0 ? nx : ny) - 1) / 2;
        return (coordinate - position[static_cast<std::size_t>(axis)]) / resolution + centre;
    }
};

}  // namespace footsel
