/// Where the robot's base is in the world.
#pragma once

#include <array>
#include <cmath>

#include "footsel/result.hpp"

namespace footsel {

using Vector3 = std::array<double, 3>;

/// Whether a number can be a coordinate in metres or an angle in radians: it is finite, and arithmetic with it is safe.
inline bool is_plausible(double number) noexcept { return std::abs(number) < 1e9; }

/// Base frame B in the world frame W, in [m] and [rad]: R = Rz(yaw) Ry(pitch) Rx(roll).
struct BasePose {
    double x = 0, y = 0, z = 0;
    double roll = 0, pitch = 0, yaw = 0;

    Result<void> check() const noexcept {
        for (double number : {x, y, z, roll, pitch, yaw}) {
            if (!is_plausible(number)) {
                return Error::format(ErrorCode::input,
                                     "base pose is [%g, %g, %g, %g, %g, %g]; give six finite numbers: x y z roll pitch yaw, in m and rad",
                                     x, y, z, roll, pitch, yaw);
            }
        }
        return {};
    }
};

/// The heading frame H in the world frame: gravity-aligned, turned by the base's yaw.
struct Heading {
    double cosine, sine;

    explicit Heading(double yaw) noexcept : cosine(std::cos(yaw)), sine(std::sin(yaw)) {}

    /// A horizontal vector of H, in W.
    std::array<double, 2> to_world(double x, double y) const noexcept {
        return {cosine * x - sine * y, sine * x + cosine * y};
    }
    /// A horizontal vector of W, in H.
    std::array<double, 2> from_world(double x, double y) const noexcept {
        return {cosine * x + sine * y, cosine * y - sine * x};
    }
};

/// A point of the base frame, in the world frame, in [m].
inline Vector3 transform_base_to_world(const BasePose& pose, const Vector3& point) noexcept {
    const double cr = std::cos(pose.roll), sr = std::sin(pose.roll);
    const double cp = std::cos(pose.pitch), sp = std::sin(pose.pitch);
    // Ry(pitch) Rx(roll): from B to H.
    const double x = cp * point[0] + sp * sr * point[1] + sp * cr * point[2];
    const double y = cr * point[1] - sr * point[2];
    const double z = -sp * point[0] + cp * sr * point[1] + cp * cr * point[2];
    const auto turned = Heading(pose.yaw).to_world(x, y);
    return {pose.x + turned[0], pose.y + turned[1], pose.z + z};
}

}  // namespace footsel
