// fuzz --overrun | fuzz MODEL COUNT SEED [FILE ...]: random inputs through every way in; anything but an answer or an error is a failure.
//
// FILE: maps, contracts and networks, to be read with some of their bytes changed. Prints how many of each were answered.

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <iterator>
#include <fstream>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "footsel/footsel.hpp"
#include "npz.hpp"

namespace {

using namespace footsel;

void require(bool holds, const char* what) {
    if (holds) return;
    std::fprintf(stderr, "fuzz: %s\n", what);
    std::abort();
}

class Fuzzer {
public:
    Fuzzer(FootholdSelector& selector, unsigned seed) : selector_(selector), random_(seed) {}

    /// Whether a random request was answered, with or without footholds.
    bool select() {
        const std::size_t nx = below(90), ny = below(90);
        // Exactly as large as the map: a read beyond it is found.
        std::vector<float> heights(nx * ny);
        const double roughness = one_in(3) ? 0.0 : 0.3 * uniform(), holes = one_in(2) ? 0.0 : uniform();
        for (float& height : heights) height = static_cast<float>(roughness * uniform());
        for (float& height : heights) {
            if (uniform() < holes) height = std::nanf("");
        }
        if (!heights.empty() && one_in(4)) heights[below(heights.size())] = odd_float();
        auto map = one_in(2) ? ElevationMap::row_major(heights.data(), nx, ny, 0.02 + 0.03 * uniform())
                             : ElevationMap::column_major(heights.data(), nx, ny, 0.02 + 0.03 * uniform());
        if (one_in(2)) map.position = {uniform(), uniform()};
        BasePose pose{map.position[0] + 0.2 * uniform(), map.position[1] - 0.2 * uniform(), 0.3 + 0.3 * uniform(),
                      0.4 * uniform() - 0.2, 0.4 * uniform() - 0.2, 6 * uniform() - 3};
        SelectOptions options;
        options.top_k = one_in(10) ? below(40) : 1 + below(5);
        if (one_in(4)) options.max_distance = 0.3 * uniform();
        if (one_in(3)) options.nominal[LEGS[below(4)]] = Nominal{uniform(), uniform(), std::nullopt};
        if (one_in(3)) options.previous[LEGS[below(4)]] = {uniform() - 0.5, uniform() - 0.5};
        if (one_in(10)) options.hysteresis = odd_double();
        if (one_in(4)) options.verify = [this](auto...) { return one_in(20) ? throw 7 : one_in(2); };
        LegSet legs;
        if (one_in(2)) legs = LegSet::none(), legs.insert(LEGS[below(4)]);

        if (one_in(3)) {
            double* numbers[]{&pose.x, &pose.y, &pose.z, &pose.roll, &pose.pitch, &pose.yaw, &map.resolution,
                              &map.position[0], &map.position[1], &options.max_distance};
            *numbers[below(std::size(numbers))] = odd_double();
        }
        if (one_in(20)) options.nominal[LEGS[below(4)]] = Nominal{odd_double(), odd_double(), odd_double()};
        if (one_in(30)) map.elevation = nullptr;
        if (one_in(4)) return select_many(map, pose, legs, options);
        const auto selection = selector_.select(map, pose, legs, options);
        if (!selection) return require(selection.error().what()[0] != '\0', "an error without words"), false;
        for (Leg leg : LEGS) check(*selection, leg, options);
        return true;
    }

    bool evaluate() {
        const std::size_t maps = one_in(10) ? below(6) : 1;
        std::vector<float> heights(maps * MAP_CELLS), cost(heights.size()), confidence(heights.size());
        std::vector<Tilt> tilts(maps);
        for (float& height : heights) height = one_in(5) ? std::nanf("") : static_cast<float>(uniform() - 1);
        for (Tilt& tilt : tilts) tilt = {uniform() - 0.5, uniform() - 0.5};
        if (maps > 0 && one_in(3)) heights[below(heights.size())] = odd_float();
        if (maps > 0 && one_in(4)) tilts[below(maps)].roll = odd_double();
        const auto leg = static_cast<Leg>(below(one_in(10) ? 256 : 4));
        std::vector<std::uint8_t> classes(heights.size());
        const CellEvaluation result{cost.data(), nullptr, one_in(2) ? confidence.data() : nullptr,
                                    one_in(4) ? classes.data() : nullptr};
        if (!selector_.evaluate(one_in(50) ? nullptr : heights.data(), maps, leg, tilts.data(), result)) return false;
        for (std::size_t cell = 0; cell < heights.size(); ++cell) {
            require(cost[cell] >= 0 && cost[cell] <= 255.001F, "a cost out of its range");
            require(!std::isnan(heights[cell]) || cost[cell] == 255, "a cost on an unknown cell");
            require(classes[cell] <= 13, "a class that there is not");
        }
        return true;
    }

    /// A contract or a map with bytes changed, cut or doubled.
    bool read_damaged(std::string bytes) {
        for (std::size_t n = below(4); n > 0 && !bytes.empty(); --n) {
            const std::size_t at = below(bytes.size());
            if (one_in(3)) bytes.erase(at, below(40));
            else if (one_in(3)) bytes.insert(at, bytes.substr(below(bytes.size()), below(40)));
            else bytes[at] = static_cast<char>(below(256));
        }
        if (bytes.substr(0, 1) == "{") {
            const auto contract = ModelContract::parse(bytes, "fuzz");
            if (contract) require(contract->feasible_below > 0 && contract->layout.resolution > 0, "a bad contract passed");
            return static_cast<bool>(contract);
        }
        const auto map = parse_map(bytes);
        if (!map) return false;
        require(map->elevation.size() == map->nx * map->ny, "a map of another size than it says");
        // Some are as a robot might meet them: to be used, or refused in words.
        (void)selector_.select(map->view(), {map->position[0], map->position[1], 0.5, 0, 0, 0}, {Leg::RF});
        return true;
    }

    /// Networks with bytes changed: onnxruntime may take them or not.
    bool load_damaged(std::string bytes) {
        for (std::size_t n = 1 + below(4); n > 0; --n) {
            const std::size_t at = below(bytes.size());
            if (one_in(3)) bytes.resize(at + 1);
            else bytes[at] = static_cast<char>(below(256));
        }
        return static_cast<bool>(Network::from_bytes(bytes, "fuzz"));
    }

private:
    /// Whether a few poses on a map were answered.
    bool select_many(const ElevationMap& map, const BasePose& pose, LegSet legs, const SelectOptions& options) {
        std::vector<BasePose> poses(below(7), pose);
        for (BasePose& each : poses) each.yaw += uniform();
        if (!poses.empty() && one_in(20)) poses.back().z = odd_double();
        std::vector<Selection> selections(poses.size());
        std::vector<Nominal> own(poses.size(), Nominal{uniform(), one_in(20) ? odd_double() : uniform(), std::nullopt});
        PerLeg<const Nominal*> nominals;
        if (one_in(2)) nominals[LEGS[below(4)]] = own.data();
        const auto done = selector_.select_many(map, poses.data(), poses.size(), selections.data(), legs, options, nominals);
        if (!done) return require(done.error().what()[0] != '\0', "an error without words"), false;
        for (const Selection& selection : selections) {
            for (Leg leg : LEGS) check(selection, leg, options);
        }
        const auto best = cheapest(selections.data(), selections.size());
        require(!best || selections[*best].pose_cost() < std::numeric_limits<double>::infinity(), "a cheapest pose without footholds");
        return true;
    }

    void check(const Selection& selection, Leg leg, const SelectOptions& options) const {
        const Foothold& foothold = selection[leg];
        if (!foothold.ok()) {
            require(foothold.reason[0] != '\0' && foothold.alternative_count == 0, "none without a reason");
            return;
        }
        require(selection.legs.contains(leg), "a foothold that nobody asked for");
        require(foothold.cell.i >= 0 && foothold.cell.i < 40 && foothold.cell.j >= 0 && foothold.cell.j < 40, "no cell");
        for (double value : {foothold.position[0], foothold.position[1], foothold.position[2], foothold.cost, foothold.final_cost,
                             foothold.nominal[0], foothold.nominal[1], foothold.nominal[2], foothold.confidence, foothold.distance_to_nominal}) {
            require(std::isfinite(value), "a foothold with a number that is not finite");
        }
        require(foothold.distance_to_nominal <= options.max_distance, "a foothold too far away");
        require(foothold.alternative_count < options.top_k, "more candidates than were asked for");
    }

    double uniform() { return std::uniform_real_distribution<double>()(random_); }
    std::size_t below(std::size_t end) { return std::uniform_int_distribution<std::size_t>(0, end - 1)(random_); }
    bool one_in(std::size_t n) { return below(n) == 0; }

    double odd_double() {
        using limits = std::numeric_limits<double>;
        const double values[]{limits::quiet_NaN(), limits::infinity(), -limits::infinity(), limits::max(), limits::lowest(),
                              limits::denorm_min(), limits::min(), 0.0, -0.0, -1.0, 1e6, 1e-12, 1e300, 3e38, 1e18, -1e18};
        return values[below(std::size(values))];
    }
    float odd_float() {
        using limits = std::numeric_limits<float>;
        const float values[]{limits::quiet_NaN(), limits::infinity(), -limits::infinity(), limits::max(), limits::lowest(),
                             limits::denorm_min(), -0.0F, 1e6F, -1e30F};
        return values[below(std::size(values))];
    }

    FootholdSelector& selector_;
    std::mt19937 random_;
};

/// Whether a file is none of the forms that we read ourselves.
bool is_network(const std::string& bytes) { return bytes.substr(0, 1) != "{" && bytes.substr(0, 2) != "PK"; }

}  // namespace

int main(int argc, char** argv) {
    // To see that the sanitizers are at work: a map that is one row shorter than it says.
    if (argc == 2 && std::string(argv[1]) == "--overrun") {
        const std::vector<float> short_of_a_row(9 * 10, 0.0F);
        return std::isnan(ElevationMap::row_major(short_of_a_row.data(), 10, 10, 0.1).sample(0.45, 0.0));
    }
    auto selector = FootholdSelector::load(argv[1]);
    if (!selector) return std::puts(selector.error().what()), 2;
    const long count = std::strtol(argv[2], nullptr, 10);
    Fuzzer fuzzer(*selector, static_cast<unsigned>(std::strtoul(argv[3], nullptr, 10)));
    std::vector<std::string> files;
    for (int at = 4; at < argc; ++at) {
        std::ifstream file(argv[at], std::ios::binary);
        files.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
    }
    long selected = 0, evaluated = 0, read = 0, inputs = 0;
    for (; inputs < count; ++inputs) {
        const std::string* file = files.empty() ? nullptr : &files[static_cast<std::size_t>(inputs / 4) % files.size()];
        if (inputs % 4 == 3 && file != nullptr) read += is_network(*file) ? fuzzer.load_damaged(*file) : fuzzer.read_damaged(*file);
        else if (inputs % 4 == 2) evaluated += fuzzer.evaluate();
        else selected += fuzzer.select();
    }
    std::printf("{\"inputs\": %ld, \"selected\": %ld, \"evaluated\": %ld, \"read\": %ld}\n", inputs, selected, evaluated, read);
    return 0;
}
