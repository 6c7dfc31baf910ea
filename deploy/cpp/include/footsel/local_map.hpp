/// The 40x40 map under one leg, in that leg's heading frame H.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "footsel/base_pose.hpp"
#include "footsel/elevation_map.hpp"

namespace footsel {

/// Cells along one side of a local map, and all its cells.
inline constexpr std::size_t CELLS = 40;
inline constexpr std::size_t MAP_CELLS = CELLS * CELLS;

/// A cell of a local map: i along H's x, j along H's y.
struct Cell {
    int i = 0, j = 0;

    static Cell of(std::size_t flat) noexcept {
        return {static_cast<int>(flat / CELLS), static_cast<int>(flat % CELLS)};
    }
    std::size_t flat() const noexcept { return static_cast<std::size_t>(i) * CELLS + static_cast<std::size_t>(j); }
    bool operator==(const Cell& other) const noexcept { return i == other.i && j == other.j; }
};

/// The flat index of the cell that a right leg sees where its left twin sees `flat`, and back: y turned round.
constexpr std::size_t mirror_of(std::size_t flat) noexcept { return flat - flat % CELLS + (CELLS - 1 - flat % CELLS); }

/// Distance of a row or column of cells from the middle of a local map, in [cells].
constexpr double offset_in_cells(int index) noexcept { return index - (static_cast<double>(CELLS) - 1) / 2; }

/// Where the cells of a leg's local map are: around the point M_i below its hip point L_i, turned by the base's yaw.
struct LocalFrame {
    Vector3 hip;        ///< L_i in the world frame, in [m]
    Heading heading;    ///< of H in the world frame
    double resolution;  ///< side of a cell, in [m]

    /// Distance of a row or column of cells from M_i along an axis of H, in [m].
    double offset(int index) const noexcept { return offset_in_cells(index) * resolution; }

    /// World xy of a cell's centre, in [m].
    std::array<double, 2> xy(Cell cell) const noexcept {
        const auto turned = heading.to_world(offset(cell.i), offset(cell.j));
        return {hip[0] + turned[0], hip[1] + turned[1]};
    }

    /// Contact point of a cell in the world frame, in [m]; height is that of the terrain relative to L_i.
    Vector3 position(Cell cell, float height) const noexcept {
        const auto point = xy(cell);
        return {point[0], point[1], hip[2] + static_cast<double>(height)};
    }

    /// A horizontal world point, from M_i in H, in [m].
    std::array<double, 2> from_world(double x, double y) const noexcept {
        return heading.from_world(x - hip[0], y - hip[1]);
    }
};

/// Terrain heights relative to L_i at the cells of a frame, NaN = unknown, in [m].
using LocalHeights = std::array<float, MAP_CELLS>;

/// What there is to say of a local map as a whole.
struct LocalMapSummary {
    std::size_t known = 0;                                     ///< cells with a height
    float nearest = std::numeric_limits<float>::infinity();  ///< smallest distance of a height from L_i, in [m]
};

/// Sample the world map at the cell centres of a local map; an error if the map has infinite heights there.
inline Result<LocalMapSummary> extract_local_map(const ElevationMap& map, const LocalFrame& frame,
                                                 LocalHeights& heights) noexcept {
    const auto middle = map.index_of(frame.hip[0], frame.hip[1]);
    // Cells of the map that a step of one cell along H's x goes, along the map's x and y.
    const double ratio = frame.resolution / map.resolution;
    const double along_x = frame.heading.cosine * ratio, along_y = frame.heading.sine * ratio;
    const float hip_height = static_cast<float>(frame.hip[2]);
    LocalMapSummary summary;
    for (int i = 0; i < static_cast<int>(CELLS); ++i) {
        const double row_u = along_x * offset_in_cells(i) + middle[0], row_v = along_y * offset_in_cells(i) + middle[1];
        for (int j = 0; j < static_cast<int>(CELLS); ++j) {
            const float ground = map.sample_at(row_u - along_y * offset_in_cells(j), row_v + along_x * offset_in_cells(j));
            if (std::isinf(ground)) {
                return Error::format(ErrorCode::map, "elevation holds infinite heights; mark unknown cells with NaN");
            }
            const float height = ground - hip_height;
            heights[Cell{i, j}.flat()] = height;
            if (std::isnan(height)) continue;
            ++summary.known;
            summary.nearest = std::min(summary.nearest, std::abs(height));
        }
    }
    return summary;
}

}  // namespace footsel
