// Latency on this machine, as JSON: footsel_bench MODEL MAP.npz ... [--calls N] [--seed S] [--int8]
//
// Maps take turns; base poses are drawn over the middle of each. One leg and four legs go from the elevation map to footholds; a batch
// goes from local heights to a cost per cell. The figures have the names that `footsel bench` gives them.

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "footsel/footsel.hpp"
#include "json_output.hpp"
#include "npz.hpp"

namespace {

using namespace footsel;

constexpr int WARM_UP = 20;  // calls: onnxruntime lays out its memory, caches fill
constexpr std::size_t BATCHES[]{1, 4, 64, 256};

int fail(const Error& error) {
    std::fprintf(stderr, "footsel_bench: %s\n", error.what());
    return 2;
}

/// A base pose on a map.
struct Request {
    ElevationMap map;
    BasePose pose;
};

/// Tilted poses at the standing height over the middle of the maps.
std::vector<Request> draw_requests(const std::vector<LoadedMap>& maps, const LegLayout& layout, std::size_t count, unsigned seed) {
    std::mt19937 random(seed);
    const auto within = [&](double most) { return std::uniform_real_distribution<double>(-most, most)(random); };
    std::vector<Request> requests(count);
    for (std::size_t n = 0; n < count; ++n) {
        const ElevationMap map = requests[n].map = maps[n % maps.size()].view();
        BasePose& pose = requests[n].pose;
        const double reach_x = static_cast<double>(map.nx) * map.resolution / 4;
        const double reach_y = static_cast<double>(map.ny) * map.resolution / 4;
        pose.x = map.position[0] + within(reach_x);
        pose.y = map.position[1] + within(reach_y);
        const float ground = map.sample(pose.x, pose.y);
        pose.z = (std::isfinite(ground) ? static_cast<double>(ground) : 0.0) + layout.standing_height();
        pose.roll = within(0.17), pose.pitch = within(0.17), pose.yaw = within(3.14);
    }
    return requests;
}

/// Milliseconds of every call; `call(n)` is the n-th.
template <class Call>
std::vector<double> time_calls(std::size_t calls, Call&& call) {
    std::vector<double> times;
    times.reserve(calls);
    for (std::size_t n = 0; n < std::min<std::size_t>(calls, WARM_UP); ++n) call(n);
    for (std::size_t n = 0; n < calls; ++n) {
        const auto start = std::chrono::steady_clock::now();
        call(n);
        times.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
    }
    std::sort(times.begin(), times.end());
    return times;
}

/// Between the two nearest of the sorted times, as numpy does by default.
double percentile(const std::vector<double>& sorted, double share) {
    const double at = share * static_cast<double>(sorted.size() - 1);
    const auto low = static_cast<std::size_t>(at);
    const std::size_t high = std::min(low + 1, sorted.size() - 1);
    return sorted[low] + (at - std::floor(at)) * (sorted[high] - sorted[low]);
}

void write_percentiles(JsonWriter& json, const char* key, const std::vector<double>& sorted) {
    json.open('{', key).number(percentile(sorted, 0.5), "p50").number(percentile(sorted, 0.99), "p99");
    json.number(percentile(sorted, 0.999), "p999").close('}');
}

}  // namespace

int main(int argc, char** argv) {
    std::vector<std::string> places;
    LoadOptions load;
    std::size_t calls = 1000;
    unsigned seed = 0;
    for (int at = 1; at < argc; ++at) {
        const std::string word = argv[at];
        if (word == "--int8") load.variant = Variant::int8;
        else if (word == "--calls" && at + 1 < argc) calls = std::max(1UL, std::strtoul(argv[++at], nullptr, 10));
        else if (word == "--seed" && at + 1 < argc) seed = static_cast<unsigned>(std::strtoul(argv[++at], nullptr, 10));
        else places.push_back(word);
    }
    if (places.size() < 2) {
        return std::fputs("usage: footsel_bench MODEL MAP.npz ... [--calls N] [--seed S] [--int8]\n", stderr), 2;
    }
    std::vector<LoadedMap> maps;
    for (std::size_t n = 1; n < places.size(); ++n) {
        auto map = load_map(places[n]);
        if (!map) return fail(map.error());
        maps.push_back(*std::move(map));
    }
    auto selector = FootholdSelector::load(places[0], load);
    if (!selector) return fail(selector.error());
    const auto requests = draw_requests(maps, selector->layout(), std::max(calls, maps.size()), seed);
    for (std::size_t n = 0; n < maps.size(); ++n) {
        if (auto tried = selector->select(requests[n].map, requests[n].pose); !tried) return fail(tried.error());
    }

    JsonWriter json(stdout);
    json.open('{').text(OrtGetApiBase()->GetVersionString(), "onnxruntime").number(1, "threads");
    json.number(static_cast<double>(calls), "calls");

    double network_ms = 0;
    std::vector<double> network;
    write_percentiles(json, "select_one_leg_ms", time_calls(calls, [&](std::size_t n) {
        network_ms = selector->select(requests[n].map, requests[n].pose, {LEGS[n % 4]})->network_ms;
        network.push_back(network_ms);
    }));
    network.erase(network.begin(), network.end() - static_cast<std::ptrdiff_t>(calls));
    std::sort(network.begin(), network.end());
    write_percentiles(json, "network_ms", network);
    write_percentiles(json, "select_four_legs_ms",
                      time_calls(calls, [&](std::size_t n) { (void)selector->select(requests[n].map, requests[n].pose); }));

    // Batches of one leg's local maps, from heights to a cost per cell.
    std::array<std::vector<double>, std::size(BATCHES)> times;
    for (std::size_t k = 0; k < times.size(); ++k) {
        const std::size_t batch = BATCHES[k];
        std::vector<float> heights(batch * MAP_CELLS), cost(heights.size());
        std::vector<Tilt> tilts(batch);
        LocalHeights local;
        for (std::size_t n = 0; n < batch; ++n) {
            const auto& [map, pose] = requests[n % requests.size()];
            const LocalFrame frame{selector->layout().hip_position(Leg::LF, pose), Heading(pose.yaw), selector->layout().resolution};
            if (auto cut = extract_local_map(map, frame, local); !cut) return fail(cut.error());
            std::copy(local.begin(), local.end(), heights.begin() + static_cast<std::ptrdiff_t>(n * MAP_CELLS));
            tilts[n] = {pose.roll, pose.pitch};
        }
        const CellEvaluation result{cost.data(), nullptr, nullptr, nullptr};
        times[k] = time_calls(std::max<std::size_t>(calls / batch, 3), [&](std::size_t) {
            (void)selector->evaluate(heights.data(), batch, Leg::LF, tilts.data(), result);
        });
    }
    json.open('{', "evaluate_ms");
    for (std::size_t k = 0; k < times.size(); ++k) write_percentiles(json, std::to_string(BATCHES[k]).c_str(), times[k]);
    json.close('}').open('{', "maps_per_second");
    for (std::size_t k = 0; k < times.size(); ++k) {
        json.number(static_cast<double>(BATCHES[k]) * 1e3 / percentile(times[k], 0.5), std::to_string(BATCHES[k]).c_str());
    }
    json.close('}').close('}');
    std::fputc('\n', stdout);
    return 0;
}
