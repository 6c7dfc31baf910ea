/// From an elevation map and a base pose to footholds, with the network alone: what runs on the robot.
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "footsel/base_pose.hpp"
#include "footsel/choice.hpp"
#include "footsel/elevation_map.hpp"
#include "footsel/foothold.hpp"
#include "footsel/legs.hpp"
#include "footsel/local_map.hpp"
#include "footsel/model_folder.hpp"
#include "footsel/network.hpp"
#include "footsel/result.hpp"
#include "footsel/select_options.hpp"

namespace footsel {

/// How a model is loaded.
struct LoadOptions {
    Variant variant = Variant::float32;
    std::string robot;  ///< refuse a model of another robot; empty: take what there is
};

/// Tilt of the base, in [rad].
struct Tilt {
    double roll = 0, pitch = 0;
};

/// Where `evaluate` writes: arrays (n, 40, 40), or null for what is not wanted.
struct CellEvaluation {
    float* cost = nullptr;           ///< mean cost over all classes, 255 where the cell is not feasible
    bool* feasible = nullptr;        ///< whether the cell is known and its p(infeasible) below the contract's threshold
    float* confidence = nullptr;     ///< 1 - p(infeasible); 0 where the height is unknown
    std::uint8_t* class_ = nullptr;  ///< the most probable of the thirteen feasible classes, 13 where the cell is not
};

/// Sizes of batches that memory is laid out for: any number of maps is a sum of them. Larger ones gain nothing, as what
/// the network has in work then leaves the processor's caches.
inline constexpr std::array<std::size_t, 4> BATCH_SIZES{1, 2, 4, 8};
inline constexpr std::size_t LARGEST_BATCH = BATCH_SIZES.back();

/// Footholds by the network. A selector owns the memory it works in, so each thread needs one of its own: `sibling`
/// makes another one over the same networks.
///
/// No function throws. Once loaded, none allocates, but for onnxruntime's own scratch memory.
class FootholdSelector {
public:
    /// A released model folder, both networks checked against SHA256SUMS.
    static Result<FootholdSelector> load(const std::string& folder, const LoadOptions& options = {}) noexcept {
        return detail::guarded(ErrorCode::model, folder.c_str(), [&] {
            return from_files(options, [&](Pair pair) {
                const std::string file = network_file(pair, options.variant);
                return std::pair(folder + "/" + file, read_released(folder, file));
            });
        });
    }

    /// Two ONNX files wherever they are; what is in them is taken as it is, without checksums.
    static Result<FootholdSelector> load_files(const std::string& front, const std::string& hind,
                                               const LoadOptions& options = {}) noexcept {
        return detail::guarded(ErrorCode::model, front.c_str(), [&] {
            return from_files(options, [&](Pair pair) {
                const std::string& file = pair == Pair::front ? front : hind;
                return std::pair(file, read_unchecked(file));
            });
        });
    }

    /// Another selector over the same networks, for another thread.
    Result<FootholdSelector> sibling() const noexcept {
        return detail::guarded(ErrorCode::engine, "making another selector", [&]() -> Result<FootholdSelector> {
            return FootholdSelector(networks_);
        });
    }

    /// Name of the robot that the networks were trained for.
    const std::string& robot() const noexcept { return contract().robot; }
    /// Hip points, nominal feet and scale of the local maps.
    const LegLayout& layout() const noexcept { return contract().layout; }
    /// What the networks promise; all but the pair, the threshold and the weights' origin is common to both.
    const ModelContract& contract(Pair pair = Pair::front) const noexcept { return networks_[index(pair)].contract(); }

    /// The cheapest feasible foothold of each leg, or one of status "none" that says why.
    ///
    /// An error for a base off the map, for a map, a pose or options that make no sense, and if `verify` throws. Heights
    /// are looked at only where a leg's local map samples them.
    Result<Selection> select(const ElevationMap& map, const BasePose& pose, LegSet legs = {},
                             const SelectOptions& options = {}) noexcept {
        const auto start = Clock::now();
        Selection selection;
        if (auto checked = check_request(map, legs, options); !checked) return checked.error();
        if (auto checked = check_pose(map, pose); !checked) return checked.error();
        if (auto done = select_part(map, &pose, 1, &selection, legs, options, {}); !done) return done.error();
        selection.total_ms = milliseconds_since(start);
        return selection;
    }

    /// The same at many base poses, for planners that score hundreds of postures a step: the networks run on eight maps
    /// at a time. `footsel::cheapest` says which pose costs least.
    ///
    /// poses, selections: (count,). nominals: N_i of a leg at each pose (count,), or null for those of the options.
    /// Times are each pose's share. An error names the first pose that makes no sense, before any is answered.
    Result<void> select_many(const ElevationMap& map, const BasePose* poses, std::size_t count, Selection* selections,
                             LegSet legs = {}, const SelectOptions& options = {},
                             const PerLeg<const Nominal*>& nominals = {}) noexcept {
        const auto start = Clock::now();
        if (auto checked = check_request(map, legs, options); !checked) return checked;
        if (auto checked = check_poses(map, poses, count, selections, legs, nominals); !checked) return checked;
        const std::size_t most = LARGEST_BATCH / std::max<std::size_t>(legs_of_largest_pair(legs), 1);
        for (std::size_t begin = 0; begin < count; begin += most) {
            PerLeg<const Nominal*> own;
            for (Leg leg : LEGS) own[leg] = nominals[leg] == nullptr ? nullptr : nominals[leg] + begin;
            auto done = select_part(map, poses + begin, std::min(most, count - begin), selections + begin, legs, options, own);
            if (!done) return done;
        }
        const double share = count == 0 ? 0 : milliseconds_since(start) / static_cast<double>(count);
        for (std::size_t pose = 0; pose < count; ++pose) selections[pose].total_ms = share;
        return {};
    }

    /// Class, cost, feasibility and confidence per cell, for those with their own mapping.
    ///
    /// heights: (maps, 40, 40) terrain height relative to the leg's hip point L_i, i along the base's heading and j to
    /// its left, cells of `layout().resolution`, NaN = unknown, in [m]. tilts: one for each map.
    Result<void> evaluate(const float* heights, std::size_t maps, Leg leg, const Tilt* tilts,
                          const CellEvaluation& result) noexcept {
        if (auto checked = check_local_maps(heights, maps, leg, tilts); !checked) return checked;
        const Network& network = networks_[index(pair_of(leg))];
        for (std::size_t begin = 0; begin < maps;) {
            Batch& batch = largest_batch(pair_of(leg), maps - begin);
            for (std::size_t i = 0; i < batch.maps(); ++i) {
                const Tilt& tilt = tilts[begin + i];
                network.contract().encoding.encode(heights + (begin + i) * MAP_CELLS, tilt.roll, tilt.pitch, is_right(leg),
                                                   batch.input(i));
            }
            if (auto done = network.run(batch, result.class_ != nullptr); !done) return done;
            for (std::size_t i = 0; i < batch.maps(); ++i) decode(batch, i, begin + i, heights, leg, result);
            begin += batch.maps();
        }
        return {};
    }

private:
    /// Ground this many height ranges above or below every hip is no ground a leg has to do with.
    static constexpr double IMPLAUSIBLE = 10;

    using Clock = std::chrono::steady_clock;

    /// All that a call writes to, laid out once.
    struct Memory {
        std::array<LocalHeights, LARGEST_BATCH> heights;
        std::array<std::array<Batch, BATCH_SIZES.size()>, 2> batches;  ///< by pair and size
        std::array<float, LARGEST_BATCH * CLASSES * MAP_CELLS> logits;  ///< of any of them
        Ranking ranking;
    };

    explicit FootholdSelector(std::array<Network, 2> networks)
        : networks_(std::move(networks)), memory_(std::make_unique<Memory>()) {
        for (Pair pair : PAIRS) {
            const std::size_t planes = contract(pair).encoding.planes.size();
            for (std::size_t i = 0; i < BATCH_SIZES.size(); ++i) {
                memory_->batches[index(pair)][i] = Batch(BATCH_SIZES[i], planes, memory_->logits.data());
            }
        }
    }

    /// The largest batch that `maps` fill, one or more.
    Batch& largest_batch(Pair pair, std::size_t maps) noexcept {
        std::size_t i = BATCH_SIZES.size() - 1;
        while (BATCH_SIZES[i] > maps) --i;
        return memory_->batches[index(pair)][i];
    }

    /// read(pair) -> what messages call the file, and its content or an error.
    template <class Read>
    static Result<FootholdSelector> from_files(const LoadOptions& options, Read&& read) {
        std::array<std::optional<Network>, 2> networks;
        for (Pair pair : PAIRS) {
            const auto [source, content] = read(pair);
            if (!content) return content.error();
            auto network = Network::from_bytes(*content, source);
            if (!network) return network.error();
            if (auto checked = check_origin(network->contract(), pair, source, options); !checked) return checked.error();
            networks[index(pair)] = std::move(*network);
        }
        const ModelContract &front = networks[0]->contract(), &hind = networks[1]->contract();
        if (front.robot != hind.robot) {
            return Error::format(ErrorCode::model, "the model mixes robots: front is '%s', hind is '%s'; export both for one",
                                 front.robot.c_str(), hind.robot.c_str());
        }
        if (!(front.layout == hind.layout) || front.distance_weight != hind.distance_weight) {
            return Error::format(ErrorCode::model, "the model mixes two layouts of '%s'; export both networks in one run",
                                 front.robot.c_str());
        }
        return FootholdSelector({std::move(*networks[0]), std::move(*networks[1])});
    }

    static Result<void> check_origin(const ModelContract& contract, Pair pair, const std::string& source,
                                     const LoadOptions& options) noexcept {
        if (contract.pair != pair) {
            return Error::format(ErrorCode::model,
                                 "%s was trained for the %s legs; put front and hind files back under their names",
                                 source.c_str(), name(contract.pair));
        }
        if (!options.robot.empty() && contract.robot != options.robot) {
            return Error::format(ErrorCode::model, "%s is a model of '%s', not of '%s'; give the model of your robot",
                                 source.c_str(), contract.robot.c_str(), options.robot.c_str());
        }
        return {};
    }

    Result<void> check_request(const ElevationMap& map, LegSet legs, const SelectOptions& options) const noexcept {
        if (memory_ == nullptr) return Error::format(ErrorCode::input, "this selector was moved from");
        if (auto checked = options.check(legs); !checked) return checked;
        return map.check();
    }

    static Result<void> check_pose(const ElevationMap& map, const BasePose& pose) noexcept {
        if (auto checked = pose.check(); !checked) return checked;
        if (!map.contains(pose.x, pose.y)) {
            const double half_x = static_cast<double>(map.nx) * map.resolution / 2;
            const double half_y = static_cast<double>(map.ny) * map.resolution / 2;
            return Error::format(ErrorCode::input,
                                 "the base at x=%g y=%g is off the map; the map spans x %g..%g and y %g..%g m", pose.x, pose.y,
                                 map.position[0] - half_x, map.position[0] + half_x, map.position[1] - half_y,
                                 map.position[1] + half_y);
        }
        return {};
    }

    static Result<void> check_poses(const ElevationMap& map, const BasePose* poses, std::size_t count,
                                    const Selection* selections, LegSet legs,
                                    const PerLeg<const Nominal*>& nominals) noexcept {
        if (count > 0 && (poses == nullptr || selections == nullptr)) {
            return Error::format(ErrorCode::input, "poses or selections are null; give both");
        }
        for (std::size_t pose = 0; pose < count; ++pose) {
            if (auto checked = check_pose(map, poses[pose]); !checked) {
                return Error::format(checked.error().code, "pose %zu: %s", pose, checked.error().what());
            }
            for (Leg leg : LEGS) {
                if (!legs.contains(leg) || nominals[leg] == nullptr) continue;
                if (auto checked = nominals[leg][pose].check(leg); !checked) {
                    return Error::format(checked.error().code, "pose %zu: %s", pose, checked.error().what());
                }
            }
        }
        return {};
    }

    Result<void> check_local_maps(const float* heights, std::size_t maps, Leg leg, const Tilt* tilts) const noexcept {
        if (memory_ == nullptr) return Error::format(ErrorCode::input, "this selector was moved from");
        if (index(leg) >= LEGS.size()) return Error::format(ErrorCode::input, "leg %zu; choose from: LF, RF, LH, RH", index(leg));
        if (heights == nullptr || tilts == nullptr) {
            return Error::format(ErrorCode::input, "local heights or tilts are null; give both");
        }
        if (maps < 1) return Error::format(ErrorCode::input, "no local maps; give one or more");
        for (std::size_t map = 0; map < maps; ++map) {
            if (!is_plausible(tilts[map].roll) || !is_plausible(tilts[map].pitch)) {
                return Error::format(ErrorCode::input, "the tilt of map %zu is not finite or absurd; give angles in rad", map);
            }
        }
        for (std::size_t cell = 0; cell < maps * MAP_CELLS; ++cell) {
            if (std::isinf(heights[cell])) {
                return Error::format(ErrorCode::input, "local heights hold infinite values; mark unknown cells with NaN");
            }
        }
        return {};
    }

    LocalFrame frame_of(Leg leg, const BasePose& pose) const noexcept {
        return {layout().hip_position(leg, pose), Heading(pose.yaw), layout().resolution};
    }

    Vector3 nominal_of(Leg leg, const ElevationMap& map, const BasePose& pose, const Nominal* own) const noexcept {
        if (own != nullptr && own->z) return {own->x, own->y, *own->z};
        const auto xy = own != nullptr ? std::array<double, 2>{own->x, own->y} : layout().nominal_xy(leg, pose);
        return layout().nominal_position(leg, pose, map, xy);
    }

    /// Those of a pair that are asked for, in order; how many in `count`.
    static std::array<Leg, 2> legs_of(Pair pair, LegSet legs, std::size_t& count) noexcept {
        std::array<Leg, 2> result{};
        count = 0;
        for (Leg leg : LEGS) {
            if (pair_of(leg) == pair && legs.contains(leg)) result[count++] = leg;
        }
        return result;
    }

    static std::size_t legs_of_largest_pair(LegSet legs) noexcept {
        std::size_t front = 0, hind = 0;
        legs_of(Pair::front, legs, front), legs_of(Pair::hind, legs, hind);
        return std::max(front, hind);
    }

    /// Poses whose legs of a pair are as many maps as the largest batch, or fewer: what is said of the terrain is kept
    /// for them here.
    Result<void> select_part(const ElevationMap& map, const BasePose* poses, std::size_t count, Selection* selections,
                             LegSet legs, const SelectOptions& options, const PerLeg<const Nominal*>& nominals) noexcept {
        std::array<LocalMapSummary, LARGEST_BATCH> around{};
        for (std::size_t pose = 0; pose < count; ++pose) selections[pose] = Selection{}, selections[pose].legs = legs;
        for (Pair pair : PAIRS) {
            std::size_t in_pair = 0;
            const auto legs_here = legs_of(pair, legs, in_pair);
            for (std::size_t begin = 0; begin < count * in_pair;) {
                Batch& batch = largest_batch(pair, count * in_pair - begin);
                std::array<Ask, LARGEST_BATCH> asks;
                for (std::size_t i = 0; i < batch.maps(); ++i) {
                    const std::size_t pose = (begin + i) / in_pair;
                    const Leg leg = legs_here[(begin + i) % in_pair];
                    const Nominal* own = nominals[leg] != nullptr ? nominals[leg] + pose
                                         : options.nominal[leg]   ? &*options.nominal[leg]
                                                                  : nullptr;
                    const auto summary = extract_local_map(map, frame_of(leg, poses[pose]), memory_->heights[i]);
                    if (!summary) return summary.error();
                    around[pose].known += summary->known;
                    around[pose].nearest = std::min(around[pose].nearest, summary->nearest);
                    asks[i] = {leg, &poses[pose], &selections[pose], summary->known};
                    selections[pose].footholds[leg].nominal = nominal_of(leg, map, poses[pose], own);
                }
                if (auto done = answer(batch, asks, map, options); !done) return done;
                begin += batch.maps();
            }
        }
        const auto far = static_cast<float>(IMPLAUSIBLE * layout().height_range);
        for (std::size_t pose = 0; pose < count; ++pose) {
            selections[pose].far_from_terrain = around[pose].known > 0 && around[pose].nearest >= far;
        }
        return {};
    }

    /// One map of a batch: whose it is, and where the answer belongs.
    struct Ask {
        Leg leg = Leg::LF;
        const BasePose* pose = nullptr;
        Selection* selection = nullptr;
        std::size_t known = 0;  ///< cells with a height
    };

    /// Run the network of a pair on the heights of a batch and choose a cell of each map; right legs are mirrored.
    Result<void> answer(Batch& batch, const std::array<Ask, LARGEST_BATCH>& asks, const ElevationMap& map,
                        const SelectOptions& options) noexcept {
        const auto start = Clock::now();
        const Network& network = networks_[index(pair_of(asks[0].leg))];
        for (std::size_t i = 0; i < batch.maps(); ++i) {
            network.contract().encoding.encode(memory_->heights[i].data(), asks[i].pose->roll, asks[i].pose->pitch,
                                               is_right(asks[i].leg), batch.input(i));
        }
        if (auto done = network.run(batch); !done) return done;
        const double share = milliseconds_since(start) / static_cast<double>(batch.maps());

        for (std::size_t i = 0; i < batch.maps(); ++i) {
            const auto& [leg, pose, selection, known] = asks[i];
            selection->network_ms += share;
            const LegView view{leg, frame_of(leg, *pose), memory_->heights[i], known, batch.infeasible(i), batch.cost(i)};
            const auto& previous = options.previous[leg];
            const float ground = previous ? map.sample((*previous)[0], (*previous)[1]) : std::nanf("");
            auto done = Choice(view, network.contract(), options, memory_->ranking, selection->footholds[leg]).make(*pose, ground);
            if (!done) return done;
        }
        return {};
    }

    /// Write what the network said of map `i` of a batch to the results of map `map`.
    void decode(const Batch& batch, std::size_t i, std::size_t map, const float* heights, Leg leg,
                const CellEvaluation& result) const noexcept {
        const float feasible_below = static_cast<float>(contract(pair_of(leg)).feasible_below);
        for (std::size_t flat = 0; flat < MAP_CELLS; ++flat) {
            const std::size_t seen = is_right(leg) ? mirror_of(flat) : flat, at = map * MAP_CELLS + flat;
            const float infeasible = batch.infeasible(i)[seen];
            const bool known = !std::isnan(heights[at]), feasible = known && infeasible < feasible_below;
            if (result.cost) result.cost[at] = feasible ? batch.cost(i)[seen] : static_cast<float>(INFEASIBLE_COST);
            if (result.feasible) result.feasible[at] = feasible;
            if (result.confidence) result.confidence[at] = known ? 1.0F - infeasible : 0.0F;
            if (result.class_) result.class_[at] = feasible ? batch.likeliest(i, seen) : std::uint8_t{COST_BINS};
        }
    }

    static double milliseconds_since(Clock::time_point start) noexcept {
        return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
    }

    std::array<Network, 2> networks_;
    std::unique_ptr<Memory> memory_;
};

}  // namespace footsel
