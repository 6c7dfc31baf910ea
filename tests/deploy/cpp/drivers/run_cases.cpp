// run_cases [--int8] MODEL [HIND]: footholds of every case on stdin, one line of JSON each; a model that cannot be loaded
// gives {"error"} and exit code 2.

#include <string>
#include <vector>

#include "case.hpp"
#include "json_output.hpp"

namespace {

int write_error(const footsel::Error& error) {
    footsel::JsonWriter json(stdout);
    json.open('{').text(error.what(), "error").number(static_cast<int>(error.code), "code").close('}');
    std::fputc('\n', stdout);
    return 2;
}

}  // namespace

int main(int argc, char** argv) {
    std::vector<std::string> places;
    footsel::LoadOptions load;
    for (int at = 1; at < argc; ++at) {
        const std::string word = argv[at];
        if (word == "--int8") load.variant = footsel::Variant::int8;
        else if (word == "--robot" && at + 1 < argc) load.robot = argv[++at];
        else places.push_back(word);
    }
    auto selector = places.size() == 2 ? footsel::FootholdSelector::load_files(places[0], places[1], load)
                                       : footsel::FootholdSelector::load(places.at(0), load);
    if (!selector) return write_error(selector.error());
    for (Case next; read_case(stdin, next);) {
        const auto selection = selector->select(next.map, next.pose, next.legs, next.options);
        if (!selection) {
            write_error(selection.error());
            continue;
        }
        footsel::JsonWriter json(stdout);
        json.open('{');
        footsel::write_footholds(json, *selection, "footholds");
        json.number(selection->far_from_terrain, "far_from_terrain").close('}');
        std::fputc('\n', stdout);
    }
    return 0;
}
