/// The contract that travels in an ONNX file's metadata: everything a runtime needs to use the network.
#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <string_view>

#include "footsel/input_encoding.hpp"
#include "footsel/json.hpp"
#include "footsel/leg_layout.hpp"
#include "footsel/legs.hpp"
#include "footsel/result.hpp"

namespace footsel {

/// The schema that this library reads; a model of another one is refused.
inline constexpr int CONTRACT_SCHEMA = 2;
/// The key of the metadata entry.
inline constexpr const char* CONTRACT_KEY = "footsel";
/// Classes of the network, the last one is "infeasible".
inline constexpr int CLASSES = 14;
/// Thirteen equal bins of the cost, and the cost of an infeasible cell.
inline constexpr int COST_BINS = 13;
inline constexpr double INFEASIBLE_COST = 255.0;
/// The frame of a contract's local maps, in words; the only one there is so far.
inline constexpr const char* LOCAL_MAP_FRAME =
    "heights relative to the hip point L_i of the leg; gravity-aligned, i along the base's heading, j to its left";
/// Operator sets that exported graphs have had, oldest and newest; onnxruntime says itself if it lacks one of them.
inline constexpr int OLDEST_OPSET = 13, NEWEST_OPSET = 30;

/// What one ONNX file promises.
struct ModelContract {
    std::string robot;
    Pair pair = Pair::front;
    LegLayout layout;
    InputEncoding encoding;
    double feasible_below = 0;   ///< a cell is feasible if its p(infeasible) is below this
    double distance_weight = 0;  ///< k of the final cost, in [cost / m]
    int opset = 0;               ///< of the graph
    std::string recipe, dataset_sha256, version, commit;  ///< where the weights come from

    /// Read the contract of the file that messages call `source`; `text` is the metadata entry. Allocates.
    static Result<ModelContract> parse(std::string_view text, const char* source);
};

namespace detail {

/// Takes fields out of a contract's JSON and remembers the first that was not as it should be.
class ContractFields {
public:
    explicit ContractFields(const Json& document) noexcept : document_(document) {}

    const char* wrong() const noexcept { return wrong_; }

    const Json* object(const Json* parent, const char* key) noexcept {
        const Json* found = parent == nullptr ? nullptr : parent->find(key);
        if (found == nullptr) blame(key);
        return found;
    }
    const Json* object(const char* key) noexcept { return object(&document_, key); }

    std::string text(const char* key) {
        const Json* found = object(key);
        if (found == nullptr || found->string() == nullptr) return blame(key), std::string();
        return *found->string();
    }

    bool boolean(const Json* parent, const char* key) noexcept {
        const Json* found = object(parent, key);
        if (found == nullptr || !found->boolean()) return blame(key), false;
        return *found->boolean();
    }

    /// A finite number within [low, high]; the lowest of them if it is none.
    double number(const Json* parent, const char* key, double low, double high) noexcept {
        const Json* found = object(parent, key);
        const auto value = found == nullptr ? std::nullopt : found->number();
        if (!value || !(*value >= low && *value <= high)) return blame(key), low;
        return *value;
    }
    double number(const char* key, double low, double high) noexcept { return number(&document_, key, low, high); }

    int whole(const char* key, int low, int high) noexcept {
        const double value = number(key, low, high);
        if (value != std::floor(value)) blame(key);
        return static_cast<int>(value);
    }

    PerLeg<Vector3> points(const Json* parent, const char* key) noexcept {
        PerLeg<Vector3> points;
        const Json* legs = object(parent, key);
        for (Leg leg : LEGS) {
            const Json* point = object(legs, name(leg));
            if (point == nullptr || point->elements().size() != 3) return blame(key), points;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const auto value = point->elements()[axis].number();
                if (!value || !std::isfinite(*value)) return blame(key), points;
                points[leg][axis] = *value;
            }
        }
        return points;
    }

    std::vector<Plane> planes(const Json* parent, const char* key) {
        std::vector<Plane> planes;
        const Json* names = object(parent, key);
        if (names == nullptr || names->elements().empty()) return blame(key), planes;
        for (const Json& element : names->elements()) {
            const auto plane = element.string() == nullptr ? std::nullopt : plane_of(*element.string());
            if (!plane) return blame(key), planes;
            planes.push_back(*plane);
        }
        return planes;
    }

    void blame(const char* key) noexcept {
        if (wrong_ == nullptr) wrong_ = key;
    }

private:
    const Json& document_;
    const char* wrong_ = nullptr;
};

}  // namespace detail

inline Result<ModelContract> ModelContract::parse(std::string_view text, const char* source) {
    const std::optional<Json> document = Json::parse(text);
    if (!document) {
        return Error::format(ErrorCode::model, "%s has a damaged footsel contract (no JSON); export the model again", source);
    }
    constexpr double tiny = 1e-9, huge = 1e9;
    detail::ContractFields fields(*document);
    const double schema = fields.number("schema", -huge, huge);
    if (fields.wrong() == nullptr && schema != CONTRACT_SCHEMA) {
        return Error::format(ErrorCode::model,
                             "%s has contract schema %g, this footsel reads %d; export the model again with this version",
                             source, schema, CONTRACT_SCHEMA);
    }

    ModelContract contract;
    contract.robot = fields.text("robot");
    const std::string pair = fields.text("pair"), leg = fields.text("leg");
    if (pair != name(Pair::front) && pair != name(Pair::hind)) fields.blame("pair");
    contract.pair = pair == name(Pair::front) ? Pair::front : Pair::hind;
    if (leg != (contract.pair == Pair::front ? name(Leg::LF) : name(Leg::LH))) fields.blame("leg");
    if (fields.text("frame") != LOCAL_MAP_FRAME) fields.blame("frame");

    const Json* layout = fields.object("layout");
    contract.layout.hips = fields.points(layout, "hips");
    contract.layout.nominal_feet = fields.points(layout, "nominal_feet");
    contract.layout.resolution = fields.number(layout, "resolution", tiny, huge);
    contract.layout.height_range = fields.number(layout, "height_range", tiny, huge);
    contract.layout.foot_radius = fields.number(layout, "foot_radius", 0, huge);

    const Json* encoding = fields.object("encoding");
    contract.encoding.planes = fields.planes(encoding, "planes");
    contract.encoding.quantised = fields.boolean(encoding, "quantised");
    contract.encoding.height_range = fields.number(encoding, "height_range", tiny, huge);

    if (fields.whole("classes", 0, 1000) != CLASSES) fields.blame("classes");
    contract.feasible_below = fields.number("feasible_below", 0, 1);
    if (contract.feasible_below == 0) fields.blame("feasible_below");
    contract.distance_weight = fields.number("distance_weight", 0, huge);
    contract.opset = fields.whole("opset", OLDEST_OPSET, NEWEST_OPSET);
    contract.recipe = fields.text("recipe");
    contract.dataset_sha256 = fields.text("dataset_sha256");
    contract.version = fields.text("version");
    contract.commit = fields.text("commit");

    if (fields.wrong() != nullptr) {
        return Error::format(ErrorCode::model,
                             "%s has a footsel contract whose \"%s\" is missing or makes no sense; export the model again",
                             source, fields.wrong());
    }
    return contract;
}

}  // namespace footsel
