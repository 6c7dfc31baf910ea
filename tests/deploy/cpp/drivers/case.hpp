/// A selection to be made, as the tests write it: 49 numbers of 64 bits, then the heights of the map, 32 bits each.
#pragma once

#include <cstdio>
#include <stdexcept>
#include <vector>

#include "footsel/footsel.hpp"

/// How `elevation` lies in memory.
enum class Order { row_major, column_major, grid_map };

struct Case {
    std::vector<float> elevation;
    footsel::ElevationMap map;
    footsel::BasePose pose;
    footsel::LegSet legs = footsel::LegSet::none();
    footsel::SelectOptions options;
};

/// What `verify` does: nothing, refuse all, accept some, throw.
inline footsel::Verify verify_of(int kind) {
    if (kind == 1) return [](auto...) { return false; };
    if (kind == 2) return [](footsel::Leg, const footsel::BasePose&, footsel::Cell cell, const auto&) { return (cell.i + 2 * cell.j) % 5 == 0; };
    if (kind == 3) return [](auto...) -> bool { throw std::runtime_error("no verdict"); };
    return {};
}

/// The next case of a stream; false at its end.
inline bool read_case(std::FILE* file, Case& result) {
    double numbers[49];
    if (std::fread(numbers, sizeof numbers, 1, file) != 1) return false;
    const double* next = numbers;
    const auto whole = [&] { return static_cast<std::size_t>(*next++); };
    result = Case{};
    const std::size_t nx = whole(), ny = whole();
    const double resolution = *next++;
    const std::array<double, 2> position{next[0], next[1]};
    next += 2;
    for (double* value : {&result.pose.x, &result.pose.y, &result.pose.z, &result.pose.roll, &result.pose.pitch, &result.pose.yaw}) {
        *value = *next++;
    }
    for (footsel::Leg leg : footsel::LEGS) {
        if (*next++ != 0) result.legs.insert(leg);
    }
    for (footsel::Leg leg : footsel::LEGS) {
        // The length of the point that was given: 0, 2 or 3 numbers.
        const std::size_t length = whole();
        if (length > 0) result.options.nominal[leg] = footsel::Nominal{next[0], next[1], std::nullopt};
        if (length == 3) result.options.nominal[leg]->z = next[2];
        next += 3;
    }
    for (footsel::Leg leg : footsel::LEGS) {
        if (*next++ != 0) result.options.previous[leg] = {next[0], next[1]};
        next += 2;
    }
    result.options.hysteresis = *next++;
    result.options.top_k = whole();
    result.options.max_distance = *next++;
    result.options.verify = verify_of(static_cast<int>(whole()));
    const auto order = static_cast<Order>(whole());
    const bool null = whole() != 0;

    result.elevation.resize(nx * ny);
    if (std::fread(result.elevation.data(), sizeof(float), nx * ny, file) != nx * ny) return false;
    const float* heights = null ? nullptr : result.elevation.data();
    const auto view = order == Order::row_major      ? footsel::ElevationMap::row_major
                      : order == Order::column_major ? footsel::ElevationMap::column_major
                                                     : footsel::ElevationMap::grid_map;
    result.map = view(heights, nx, ny, resolution, position);
    return true;
}
