/// A foothold: the answer for one leg. Everything lies in the answer itself, so that it can be copied and kept.
#pragma once

#include <array>
#include <cstddef>
#include <cstdio>
#include <limits>
#include <optional>

#include "footsel/base_pose.hpp"
#include "footsel/legs.hpp"
#include "footsel/local_map.hpp"

namespace footsel {

/// The most that `top_k` can ask for: the chosen cell and its alternatives.
inline constexpr std::size_t MOST_CANDIDATES = 16;

/// A cell that may be chosen.
struct Candidate {
    Cell cell;              ///< in the leg's local map
    Vector3 position{};     ///< contact point on the terrain in the world frame, in [m]
    double final_cost = 0;  ///< Z_c + k d_n
};

/// What was chosen for a leg, or why nothing was.
struct Foothold {
    enum class Status { none, ok };
    static constexpr double nothing = std::numeric_limits<double>::quiet_NaN();

    Status status = Status::none;
    char reason[96] = "the leg was not asked for";  ///< why there is none; empty if there is one

    Vector3 nominal{nothing, nothing, nothing};  ///< N_i in the world frame, in [m]

    // Of the chosen cell; NaN and -1 if there is none.
    Vector3 position{nothing, nothing, nothing};  ///< contact point on the terrain in the world frame, in [m]
    Cell cell{-1, -1};                            ///< in the leg's local map
    double cost = nothing;                        ///< Z_c in [0, 255]
    int class_ = -1;                              ///< of the cost, 0..12
    double final_cost = nothing;                  ///< Z_c + k d_n
    double distance_to_nominal = nothing;         ///< d_n, in [m]
    double confidence = nothing;                  ///< 1 - p(infeasible)

    /// The next best cells, in the order of their final cost.
    std::array<Candidate, MOST_CANDIDATES - 1> alternatives{};
    std::size_t alternative_count = 0;

    bool ok() const noexcept { return status == Status::ok; }
    const char* status_name() const noexcept { return ok() ? "ok" : "none"; }

    template <class... Values>
    void set_none(const char* pattern, Values... values) noexcept {
        status = Status::none;
        if constexpr (sizeof...(values) == 0) {
            std::snprintf(reason, sizeof reason, "%s", pattern);
        } else {
            std::snprintf(reason, sizeof reason, pattern, values...);
        }
    }
};

/// What one call chose, and how long it took.
struct Selection {
    LegSet legs;  ///< that were asked for
    PerLeg<Foothold> footholds;
    /// Whether terrain is known around the legs, but nowhere within ten height ranges of any hip: is the map in metres, and
    /// in the frame of the pose?
    bool far_from_terrain = false;
    double total_ms = 0;    ///< wall time of the call
    double network_ms = 0;  ///< encoding, inference and decoding, a part of the total

    const Foothold& operator[](Leg leg) const noexcept { return footholds[leg]; }

    /// Sum of the final costs over the legs that were asked for; infinite if one of them has no foothold.
    double pose_cost() const noexcept {
        double sum = 0;
        for (Leg leg : LEGS) {
            if (!legs.contains(leg)) continue;
            sum += footholds[leg].ok() ? footholds[leg].final_cost : std::numeric_limits<double>::infinity();
        }
        return sum;
    }
};

/// Which of many selections costs least in all; none if each leaves a leg without a foothold.
inline std::optional<std::size_t> cheapest(const Selection* selections, std::size_t count) noexcept {
    std::optional<std::size_t> best;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t n = 0; n < count; ++n) {
        const double cost = selections[n].pose_cost();
        if (cost < least) least = cost, best = n;
    }
    return best;
}

}  // namespace footsel
