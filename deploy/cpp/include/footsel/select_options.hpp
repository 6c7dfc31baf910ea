/// What a selection may be asked for beyond the map, the pose and the legs.
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <limits>
#include <optional>

#include "footsel/base_pose.hpp"
#include "footsel/foothold.hpp"
#include "footsel/legs.hpp"
#include "footsel/local_map.hpp"
#include "footsel/result.hpp"

namespace footsel {

/// verify(leg, base pose, cell of the leg's local map, contact point in W) -> whether the candidate may be used.
using Verify = std::function<bool(Leg, const BasePose&, Cell, const Vector3&)>;

/// A nominal foothold N_i of the caller's own: a world point, in [m]. Without z it lies on the terrain.
struct Nominal {
    double x = 0, y = 0;
    std::optional<double> z;

    Result<void> check(Leg leg) const noexcept {
        if (is_plausible(x) && is_plausible(y) && is_plausible(z.value_or(0))) return {};
        return Error::format(ErrorCode::input, "nominal foothold of %s is (%g, %g, %g); give world (x, y) or (x, y, z)",
                             name(leg), x, y, z.value_or(0));
    }
};

struct SelectOptions {
    /// N_i by leg; the robot's nominal stance for legs without one.
    PerLeg<std::optional<Nominal>> nominal;
    /// How many candidates to name, the chosen one and its alternatives.
    std::size_t top_k = 1;
    /// No cell farther from N_i is chosen, in [m].
    double max_distance = std::numeric_limits<double>::infinity();
    /// Called on candidates in their order until `top_k` of them are accepted.
    Verify verify;
    /// Footholds to stay with, world xy in [m]: one that may still be chosen is kept in its place unless another's final
    /// cost is lower by more than `hysteresis`.
    PerLeg<std::optional<std::array<double, 2>>> previous;
    /// In the unit of costs; by default, half a class.
    double hysteresis = 10.0;

    /// Stay with the footholds of an earlier answer.
    void stay_with(const Selection& earlier) noexcept {
        for (Leg leg : LEGS) {
            const Foothold& foothold = earlier[leg];
            previous[leg].reset();
            if (foothold.ok()) previous[leg] = {foothold.position[0], foothold.position[1]};
        }
    }

    /// Whether the options make sense for these legs.
    Result<void> check(LegSet legs) const noexcept {
        if (top_k < 1 || top_k > MOST_CANDIDATES) {
            return Error::format(ErrorCode::input, "top_k is %zu; give a whole number from 1 to %zu", top_k, MOST_CANDIDATES);
        }
        // NaN compares false.
        if (!(max_distance >= 0)) {
            return Error::format(ErrorCode::input, "max_distance is %g; give 0 m or more", max_distance);
        }
        if (!(hysteresis >= 0)) {
            return Error::format(ErrorCode::input, "hysteresis is %g; give a final cost of 0 or more", hysteresis);
        }
        for (Leg leg : LEGS) {
            if (!legs.contains(leg)) continue;
            if (nominal[leg]) {
                if (auto checked = nominal[leg]->check(leg); !checked) return checked;
            }
            const auto& before = previous[leg];
            if (before && !(is_plausible((*before)[0]) && is_plausible((*before)[1]))) {
                return Error::format(ErrorCode::input, "previous foothold of %s is (%g, %g); give world (x, y)", name(leg),
                                     (*before)[0], (*before)[1]);
            }
        }
        return {};
    }
};

}  // namespace footsel
