/// A world-aligned elevation map that belongs to someone else, and how it is sampled between its cells.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "footsel/base_pose.hpp"
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
        if (resolution < 1e-5 || resolution > 1e3) {
            return Error::format(ErrorCode::map, "the map's cells are %g m wide; give its resolution in metres", resolution);
        }
        if (!std::isfinite(position[0]) || !std::isfinite(position[1])) {
            return Error::format(ErrorCode::map, "position is (%g, %g); expected two finite numbers, world xy in metres",
                                 position[0], position[1]);
        }
        if (!is_plausible(position[0]) || !is_plausible(position[1])) {
            return Error::format(ErrorCode::map, "the map's centre is at (%g, %g); give its position in metres", position[0],
                                 position[1]);
        }
        return {};
    }

    /// Height of a cell, in [m].
    float at(std::size_t i, std::size_t j) const noexcept {
        return elevation[static_cast<std::ptrdiff_t>(i) * stride_x + static_cast<std::ptrdiff_t>(j) * stride_y];
    }

    /// Where a world point is among the cells, whole numbers at their centres.
    std::array<double, 2> index_of(double x, double y) const noexcept {
        return {(x - position[0]) / resolution + (static_cast<double>(nx) - 1) / 2,
                (y - position[1]) / resolution + (static_cast<double>(ny) - 1) / 2};
    }

    /// Whether a world point lies on the map, known or not.
    bool contains(double x, double y) const noexcept {
        const auto [u, v] = index_of(x, y);
        return u >= -0.5 && u < static_cast<double>(nx) - 0.5 && v >= -0.5 && v < static_cast<double>(ny) - 0.5;
    }

    /// Height at a world point, in [m]; NaN where the cell that it falls in is unknown or off the map.
    float sample(double x, double y) const noexcept {
        const auto [u, v] = index_of(x, y);
        return sample_at(u, v);
    }

    /// The same at an index between cells.
    ///
    /// Heights are interpolated bilinearly, so a plane stays that plane at any yaw and any cell size. Unknown neighbours
    /// carry no weight: holes neither grow nor shrink. Infinity says that a cell around the point is infinite, which no
    /// map may be.
    float sample_at(double u, double v) const noexcept {
        const double last_i = static_cast<double>(nx) - 1, last_j = static_cast<double>(ny) - 1;
        // Said this way round, NaN is outside too.
        if (!(u + 0.5 >= 0 && u + 0.5 < last_i + 1 && v + 0.5 >= 0 && v + 0.5 < last_j + 1)) {
            return std::numeric_limits<float>::quiet_NaN();
        }
        u = std::clamp(u, 0.0, last_i);
        v = std::clamp(v, 0.0, last_j);
        const std::size_t i = std::min(static_cast<std::size_t>(u), nx - 2);
        const std::size_t j = std::min(static_cast<std::size_t>(v), ny - 2);
        const double a = u - static_cast<double>(i), b = v - static_cast<double>(j);
        const std::array<float, 4> corners{at(i, j), at(i, j + 1), at(i + 1, j), at(i + 1, j + 1)};

        // In 32 bits, as in Python: the network sees the very same heights.
        const float share_i = static_cast<float>(a), share_j = static_cast<float>(b);
        const float low = corners[0] + share_j * (corners[1] - corners[0]);
        const float high = corners[2] + share_j * (corners[3] - corners[2]);
        const float height = low + share_i * (high - low);
        if (std::isfinite(height)) return height;
        const int nearest = 2 * (std::floor(u + 0.5) > static_cast<double>(i)) + (std::floor(v + 0.5) > static_cast<double>(j));
        return sample_beside_unknown(corners, a, b, static_cast<std::size_t>(nearest));
    }

    /// Height among four cells of which some are unknown, or so absurd that 32 bits do not hold their differences.
    static float sample_beside_unknown(const std::array<float, 4>& corners, double a, double b, std::size_t nearest) noexcept {
        const std::array<double, 4> weights{(1 - a) * (1 - b), (1 - a) * b, a * (1 - b), a * b};
        double sum = 0, weight = 0;
        for (std::size_t k = 0; k < 4; ++k) {
            if (std::isinf(corners[k])) return std::numeric_limits<float>::infinity();
            if (std::isnan(corners[k])) continue;
            sum += weights[k] * static_cast<double>(corners[k]);
            weight += weights[k];
        }
        return std::isnan(corners[nearest]) ? corners[nearest] : static_cast<float>(sum / weight);
    }
};

}  // namespace footsel
