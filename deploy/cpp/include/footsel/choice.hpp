/// From a cost per cell to a foothold: the cheapest feasible cell by `c_final = Z_c + k d_n`.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <tuple>

#include "footsel/foothold.hpp"
#include "footsel/model_contract.hpp"
#include "footsel/select_options.hpp"

namespace footsel {

/// The cells of one local map that may be chosen, handed out in the order of their final cost.
class Ranking {
public:
    struct Entry {
        double final_cost = 0;   ///< Z_c + k d_n
        double distance = 0;     ///< d_n, in [m]
        std::uint16_t seen = 0;  ///< the cell, where the trained leg sees it
    };

    void clear() noexcept { count_ = 0; }
    std::size_t size() const noexcept { return count_; }

    void add(const Entry& entry) noexcept { entries_[count_++] = entry; }

    bool contains(std::uint16_t seen) noexcept {
        return std::any_of(entries_.begin(), end(), [&](const Entry& entry) { return entry.seen == seen; });
    }

    /// After the last `add`, before the first `next`.
    void start() noexcept { std::make_heap(entries_.begin(), end(), later); }

    /// The cheapest entry that is left; there must be one. Equal costs go to the cell nearer to N_i, then to the lower
    /// index.
    const Entry& next() const noexcept { return entries_.front(); }
    void drop_next() noexcept {
        std::pop_heap(entries_.begin(), end(), later);
        --count_;
    }

private:
    static bool later(const Entry& a, const Entry& b) noexcept {
        return std::tie(a.final_cost, a.distance, a.seen) > std::tie(b.final_cost, b.distance, b.seen);
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
    const float* infeasible;      ///< (40, 40) p(infeasible), where the trained leg sees it
    const float* cost;            ///< (40, 40) mean cost over all classes, where the trained leg sees it

    /// From a cell of the leg's own map to where its left twin sees it, and back.
    std::size_t mirrored(std::size_t flat) const noexcept { return is_right(leg) ? mirror_of(flat) : flat; }
};

/// Class of a feasible cost, one of thirteen equal bins.
inline int cost_to_class(double cost) noexcept {
    return static_cast<int>(std::clamp(cost * COST_BINS / INFEASIBLE_COST, 0.0, COST_BINS - 1.0));
}

/// Chooses the cheapest feasible known cells of one leg. Made for one choice; `ranking` is memory that it works in.
class Choice {
public:
    Choice(const LegView& view, const ModelContract& contract, const SelectOptions& options, Ranking& ranking,
           Foothold& foothold) noexcept
        : view_(view), contract_(contract), options_(options), ranking_(ranking), foothold_(foothold) {}

    /// Writes all of the foothold but its nominal place, which is given. ground: height at the previous foothold, in [m].
    /// An error only if `verify` throws.
    Result<void> make(const BasePose& pose, float ground) noexcept {
        rank();
        const std::size_t candidates = ranking_.size();
        keep_previous(ground);
        std::size_t accepted = 0;
        while (accepted < options_.top_k) {
            const auto candidate = next();
            if (!candidate) break;
            if (options_.verify) {
                const auto verdict = detail::guarded(ErrorCode::input, "the verify callback threw", [&]() -> Result<bool> {
                    return options_.verify(view_.leg, pose, cell_of(*candidate), candidate->position);
                });
                if (!verdict) return verdict.error();
                if (!*verdict) continue;
            }
            accept(*candidate, accepted++);
        }
        if (accepted == 0) say_why_none(candidates);
        return {};
    }

private:
    /// A place for a foot, in a cell or where a foot stood before.
    struct Place : Ranking::Entry {
        Vector3 position{};  ///< contact point in the world frame, in [m]
    };

    Cell cell_of(const Ranking::Entry& entry) const noexcept { return Cell::of(view_.mirrored(entry.seen)); }

    void rank() noexcept {
        // The probability is 32 bits wide, and so is the threshold that it is compared with.
        const float feasible_below = static_cast<float>(contract_.feasible_below);
        const float distance_weight = static_cast<float>(contract_.distance_weight);
        const auto nominal = view_.frame.from_world(foothold_.nominal[0], foothold_.nominal[1]);
        ranking_.clear();
        for (std::size_t seen = 0; seen < MAP_CELLS; ++seen) {
            const std::size_t flat = view_.mirrored(seen);
            // Compared this way round, a NaN of a network forbids its cell.
            if (std::isnan(view_.heights[flat]) || !(view_.infeasible[seen] < feasible_below)) continue;
            any_feasible_ = true;
            const Cell cell = Cell::of(flat);
            const double dx = view_.frame.offset(cell.i) - nominal[0], dy = view_.frame.offset(cell.j) - nominal[1];
            // In 32 bits, as in Python: what is equal there is equal here.
            const float distance = std::sqrt(static_cast<float>(dx * dx) + static_cast<float>(dy * dy));
            const float final_cost = distance * distance_weight + view_.cost[seen];
            if (static_cast<double>(distance) > options_.max_distance || !std::isfinite(final_cost)) continue;
            ranking_.add({static_cast<double>(final_cost), static_cast<double>(distance), static_cast<std::uint16_t>(seen)});
        }
        ranking_.start();
    }

    /// Let the previous foothold wait for its turn, if it may still be chosen: in its place, not in its cell's middle.
    void keep_previous(float ground) noexcept {
        const auto& previous = options_.previous[view_.leg];
        if (!previous || std::isnan(ground)) return;
        const auto [x, y] = *previous;
        const auto in_map = view_.frame.from_world(x, y);
        const double i = std::nearbyint(in_map[0] / view_.frame.resolution - offset_in_cells(0));
        const double j = std::nearbyint(in_map[1] / view_.frame.resolution - offset_in_cells(0));
        if (!(i >= 0 && i < CELLS && j >= 0 && j < CELLS)) return;
        const std::size_t seen = view_.mirrored(Cell{static_cast<int>(i), static_cast<int>(j)}.flat());
        const double distance = std::hypot(x - foothold_.nominal[0], y - foothold_.nominal[1]);
        if (distance > options_.max_distance || !ranking_.contains(static_cast<std::uint16_t>(seen))) return;
        previous_ = Place{{static_cast<double>(view_.cost[seen]) + contract_.distance_weight * distance, distance,
                           static_cast<std::uint16_t>(seen)},
                          {x, y, static_cast<double>(ground)}};
        waiting_ = true;
    }

    /// The next candidate. The previous foothold comes before every one that is not cheaper by more than the hysteresis,
    /// and stands for its cell.
    std::optional<Place> next() noexcept {
        while (ranking_.size() > 0) {
            const Ranking::Entry entry = ranking_.next();
            if (waiting_ && !(entry.final_cost < previous_->final_cost - options_.hysteresis)) break;
            ranking_.drop_next();
            if (previous_ && entry.seen == previous_->seen) continue;
            return Place{entry, view_.frame.position(cell_of(entry), view_.heights[view_.mirrored(entry.seen)])};
        }
        if (!waiting_) return std::nullopt;
        waiting_ = false;
        return previous_;
    }

    void accept(const Place& place, std::size_t accepted_before) noexcept {
        if (accepted_before > 0) {
            foothold_.alternatives[foothold_.alternative_count++] = {cell_of(place), place.position, place.final_cost};
            return;
        }
        foothold_.status = Foothold::Status::ok;
        foothold_.reason[0] = '\0';
        foothold_.position = place.position;
        foothold_.cell = cell_of(place);
        foothold_.cost = static_cast<double>(view_.cost[place.seen]);
        foothold_.class_ = cost_to_class(foothold_.cost);
        foothold_.final_cost = place.final_cost;
        foothold_.distance_to_nominal = place.distance;
        foothold_.confidence = static_cast<double>(1.0F - view_.infeasible[place.seen]);
    }

    void say_why_none(std::size_t candidates) noexcept {
        if (candidates > 0) {
            foothold_.set_none("none of %zu candidates passed the verification", candidates);
        } else if (view_.known == 0) {
            foothold_.set_none("no cell of the local map is known");
        } else if (any_feasible_) {
            foothold_.set_none("no feasible cell lies within %g m of the nominal foothold", options_.max_distance);
        } else {
            foothold_.set_none("the network calls no known cell feasible");
        }
    }

    const LegView& view_;
    const ModelContract& contract_;
    const SelectOptions& options_;
    Ranking& ranking_;
    Foothold& foothold_;
    bool any_feasible_ = false;
    std::optional<Place> previous_;  ///< if it may still be chosen
    bool waiting_ = false;           ///< whether its turn is to come
};

}  // namespace footsel
