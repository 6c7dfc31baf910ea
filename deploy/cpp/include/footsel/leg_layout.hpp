/// Where the legs of a robot sit: all that choosing a foothold needs to know of a robot.
#pragma once

#include <array>
#include <cmath>

#include "footsel/base_pose.hpp"
#include "footsel/elevation_map.hpp"
#include "footsel/legs.hpp"

namespace footsel {

/// Hip points, nominal feet and the scale of the local maps; a model carries it in its contract.
struct LegLayout {
    PerLeg<Vector3> hips;          ///< hip points L_i in the base frame, in [m]
    PerLeg<Vector3> nominal_feet;  ///< contact points of the nominal stance in the base frame of a level base, in [m]
    double resolution = 0;         ///< side of a local map's cell, in [m]
    double height_range = 0;       ///< depth below L_i that the image's full scale stands for, in [m]
    double foot_radius = 0;        ///< the foot sphere's centre is this far above the contact point, in [m]

    /// L_i in the world frame, in [m].
    Vector3 hip_position(Leg leg, const BasePose& pose) const noexcept {
        return transform_base_to_world(pose, hips[leg]);
    }

    /// N_i, the nominal stance's foot turned by the yaw: world xy, in [m].
    std::array<double, 2> nominal_xy(Leg leg, const BasePose& pose) const noexcept {
        const auto turned = Heading(pose.yaw).to_world(nominal_feet[leg][0], nominal_feet[leg][1]);
        return {pose.x + turned[0], pose.y + turned[1]};
    }

    /// N_i at a world point on the terrain, or on the ground of the standing base where terrain is unknown, in [m].
    Vector3 nominal_position(Leg leg, const BasePose& pose, const ElevationMap& map,
                             std::array<double, 2> xy) const noexcept {
        const double ground = static_cast<double>(map.sample(xy[0], xy[1]));
        return {xy[0], xy[1], std::isnan(ground) ? pose.z + nominal_feet[leg][2] : ground};
    }

    /// Height of a level base above the ground in the nominal stance, in [m].
    double standing_height() const noexcept {
        double sum = 0;
        for (Leg leg : LEGS) sum += nominal_feet[leg][2];
        return -sum / 4;
    }

    bool operator==(const LegLayout& other) const noexcept {
        return hips.values == other.hips.values && nominal_feet.values == other.nominal_feet.values &&
               resolution == other.resolution && height_range == other.height_range && foot_radius == other.foot_radius;
    }
};

}  // namespace footsel
