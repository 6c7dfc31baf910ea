// A foothold for each leg, as JSON: footsel_select MODEL MAP.npz --pose X Y Z ROLL PITCH YAW [--legs LF ...] [--top-k K]

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include "footsel/footsel.hpp"
#include "json_output.hpp"
#include "npz.hpp"

namespace {

constexpr const char* USAGE =
    "usage: footsel_select MODEL MAP.npz --pose X Y Z ROLL PITCH YAW [--legs LEG ...] [--top-k K] [--int8]\n"
    "  MODEL    folder of a released model\n"
    "  MAP.npz  elevation map\n"
    "  --pose   base in the world frame [m, rad]\n"
    "  --legs   among LF RF LH RH (default: all)\n"
    "  --top-k  candidates per leg, the chosen one and its alternatives (default: 3)\n"
    "  --int8   the quantised networks\n";

struct Arguments {
    std::string model, map;
    footsel::BasePose pose;
    footsel::LegSet legs;
    footsel::SelectOptions select;
    footsel::LoadOptions load;
};

std::optional<double> number(const char* word) {
    char* end = nullptr;
    const double value = std::strtod(word, &end);
    return end != word && *end == '\0' ? std::optional<double>(value) : std::nullopt;
}

/// What the words say, or nothing if they say it wrong.
std::optional<Arguments> parse(const std::vector<const char*>& words) {
    Arguments arguments;
    arguments.select.top_k = 3;
    std::vector<std::string> places;
    bool posed = false;
    for (std::size_t at = 0; at < words.size(); ++at) {
        const std::string word = words[at];
        if (word == "--pose") {
            auto& pose = arguments.pose;
            for (double* value : {&pose.x, &pose.y, &pose.z, &pose.roll, &pose.pitch, &pose.yaw}) {
                const auto read = ++at < words.size() ? number(words[at]) : std::nullopt;
                if (!read) return std::nullopt;
                *value = *read;
            }
            posed = true;
        } else if (word == "--legs") {
            arguments.legs = footsel::LegSet::none();
            while (at + 1 < words.size() && footsel::leg_of(words[at + 1])) arguments.legs.insert(*footsel::leg_of(words[++at]));
        } else if (word == "--top-k") {
            const auto read = ++at < words.size() ? number(words[at]) : std::nullopt;
            if (!read || !(*read >= 1 && *read <= 1e6)) return std::nullopt;
            arguments.select.top_k = static_cast<std::size_t>(*read);
        } else if (word == "--int8") {
            arguments.load.variant = footsel::Variant::int8;
        } else {
            places.push_back(word);
        }
    }
    if (!posed || places.size() != 2) return std::nullopt;
    arguments.model = places[0];
    arguments.map = places[1];
    return arguments;
}

int fail(const footsel::Error& error) {
    std::fprintf(stderr, "footsel_select: %s\n", error.what());
    return 2;
}

}  // namespace

int main(int argc, char** argv) {
    const auto arguments = parse({argv + 1, argv + argc});
    if (!arguments) return std::fputs(USAGE, stderr), 2;
    const auto map = footsel::load_map(arguments->map);
    if (!map) return fail(map.error());
    auto selector = footsel::FootholdSelector::load(arguments->model, arguments->load);
    if (!selector) return fail(selector.error());

    // The first call lays out memory, which a robot does once: the second one is timed.
    (void)selector->select(map->view(), arguments->pose, arguments->legs, arguments->select);
    const auto selection = selector->select(map->view(), arguments->pose, arguments->legs, arguments->select);
    if (!selection) return fail(selection.error());

    if (selection->far_from_terrain) {
        std::fputs("footsel_select: no terrain near the legs: is the map in metres, and in the frame of the pose?\n", stderr);
    }

    const auto& pose = arguments->pose;
    footsel::JsonWriter json(stdout);
    json.open('{').text(selector->robot().c_str(), "robot").text("cnn", "selector");
    json.numbers(std::array{pose.x, pose.y, pose.z, pose.roll, pose.pitch, pose.yaw}, "pose");
    footsel::write_footholds(json, *selection, "footholds");
    json.open('{', "time_ms").number(selection->total_ms, "total").number(selection->network_ms, "network").close('}').close('}');
    std::fputc('\n', stdout);
    return 0;
}
