/// From a cost per cell to a foothold: the cheapest feasible cell by `c_final = Z_c + k d_n`.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <tuple>

#include "footsel/foothold.hpp"
#include "footsel/model_contract.hpp"

namespace footsel {

/// verify(leg, base pose, cell of the leg's local map, contact point in W) -> whether the candidate may be used.
using Verify = std::function<bool(Leg, const BasePose&, Cell, const Vector3&)>;

/// The cells of one local map that may be chosen, handed out in the order of their final cost.
class Ranking {
public:
    struct Entry {
        double final_cost = 0;    ///< Z_c + k d_n
        double distance = 0;      ///< d_n, in [m]
        std::uint16_t flat = 0;   ///< the cell
    };

    void clear() noexcept { count_ = 0; }
    std::size_t size() const noexcept { return count_; }

    void add(const Entry& entry) noexcept { entries_[count_++] = entry; }

    /// After the last `add`, before the first `next`.
    void start() noexcept { std::make_heap(entries_.begin(), end(), later); }

    /// The cheapest entry that is left; there must be one. Equal costs go to the cell nearer to N_i, then to the lower
    /// index.
    Entry next() noexcept {
        std::pop_heap(entries_.begin(), end(), later);
        return entries_[--count_];
    }

private:
    static bool later(const Entry& a, const Entry& b) noexcept {
        return std::tie(a.final_cost, a.distance, a.flat) > std::tie(b.final_cost, b.distance, b.flat);
    }
    std::array<Entry, MAP_CELLS>::iterator end() noexcept {
        return entries_.begin() + static_cast<std::ptrdiff_t>(count_);
    }

    std::array<Entry, MAP_CELLS> entries_{};
    std::size_t count_ = 0;
};

/// What is known and thought of one leg's local map.
struct LegView {
    Leg leg = Leg::LF;
    LocalFrame frame;
    const LocalHeights& heights;  ///< relative to L_i, NaN = unknown, in [m]
    std::size_t known = 0;        ///< cells with a height
    const float* infeasible;      ///< (40, 40) p(infeasible), as the trained leg sees it
    const float* cost;            ///< (40, 40) mean cost over all classes, as the trained leg sees it

    /// Index into what the network said; a right leg's map went in mirrored.
    std::size_t seen(std::size_t flat) const noexcept { return is_right(leg) ? mirror_of(flat) : flat; }
};

/// Class of a feasible cost, one of thirteen equal bins.
inline int cost_to_class(double cost) noexcept {
    return static_cast<int>(std::clamp(cost * COST_BINS / INFEASIBLE_COST, 0.0, COST_BINS - 1.0));
}

/// Choose the cheapest feasible known cells of a leg; `foothold.nominal` is given, the rest is written.
/// An error only if `verify` throws.
inline Result<void> choose(const LegView& view, const ModelContract& contract, const BasePose& pose, std::size_t top_k,
                           double max_distance, const Verify& verify, Ranking& ranking, Foothold& foothold) noexcept {
    // The probability is 32 bits wide, and so is the threshold that it is compared with.
    const float feasible_below = static_cast<float>(contract.feasible_below);
    const auto nominal = view.frame.from_world(foothold.nominal[0], foothold.nominal[1]);
    std::size_t feasible = 0;
    ranking.clear();
    for (std::size_t flat = 0; flat < MAP_CELLS; ++flat) {
        const std::size_t seen = view.seen(flat);
        if (std::isnan(view.heights[flat]) || !(view.infeasible[seen] < feasible_below)) continue;
        ++feasible;
        const Cell cell = Cell::of(flat);
        const double dx = view.frame.offset(cell.i) - nominal[0], dy = view.frame.offset(cell.j) - nominal[1];
        const double distance = std::sqrt(dx * dx + dy * dy);
        const double final_cost = static_cast<double>(view.cost[seen]) + contract.distance_weight * distance;
        if (distance > max_distance || !std::isfinite(final_cost)) continue;
        ranking.add({final_cost, distance, static_cast<std::uint16_t>(flat)});
    }
    ranking.start();

    const std::size_t candidates = ranking.size();
    std::size_t accepted = 0;
    while (ranking.size() > 0 && accepted < top_k) {
        const Ranking::Entry entry = ranking.next();
        const Cell cell = Cell::of(entry.flat);
        const Vector3 position = view.frame.position(cell, view.heights[entry.flat]);
        if (verify) {
            const auto verdict = detail::guarded(ErrorCode::input, "the verify callback threw", [&]() -> Result<bool> {
                return verify(view.leg, pose, cell, position);
            });
            if (!verdict) return verdict.error();
            if (!*verdict) continue;
        }
        if (accepted == 0) {
            const std::size_t seen = view.seen(entry.flat);
            foothold.status = Foothold::Status::ok;
            foothold.reason[0] = '\0';
            foothold.position = position;
            foothold.cell = cell;
            foothold.cost = static_cast<double>(view.cost[seen]);
            foothold.class_ = cost_to_class(foothold.cost);
            foothold.final_cost = entry.final_cost;
            foothold.distance_to_nominal = entry.distance;
            foothold.confidence = static_cast<double>(1.0F - view.infeasible[seen]);
        } else {
            foothold.alternatives[foothold.alternative_count++] = {cell, position, entry.final_cost};
        }
        ++accepted;
    }
    if (accepted > 0) return {};

    if (view.known == 0) {
        foothold.set_none("no cell of the local map is known");
    } else if (feasible == 0) {
        foothold.set_none("the network calls no known cell feasible");
    } else if (candidates == 0) {
        foothold.set_none("no feasible cell lies within %g m of the nominal foothold", max_distance);
    } else {
        foothold.set_none("none of %zu candidates passed the verification", candidates);
    }
    return {};
}

}  // namespace footsel
