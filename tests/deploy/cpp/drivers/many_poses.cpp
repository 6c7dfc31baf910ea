// many_poses MODEL COUNT OWN: a case on stdin, COUNT base poses of six numbers, and if OWN is 1 as many nominal footholds
// (x, y) of LF; the footholds at each pose, one line of JSON each, then which pose is cheapest, -1 for none.

#include <cstdlib>
#include <vector>

#include "case.hpp"
#include "json_output.hpp"

using namespace footsel;

int main(int, char** argv) {
    auto selector = FootholdSelector::load(argv[1]);
    Case given;
    if (!selector || !read_case(stdin, given)) return 2;
    const std::size_t count = std::strtoul(argv[2], nullptr, 10);
    std::vector<BasePose> poses(count);
    for (BasePose& pose : poses) {
        for (double* value : {&pose.x, &pose.y, &pose.z, &pose.roll, &pose.pitch, &pose.yaw}) {
            if (std::fread(value, sizeof *value, 1, stdin) != 1) return 2;
        }
    }
    std::vector<Nominal> own(argv[3][0] == '1' ? count : 0);
    for (Nominal& nominal : own) {
        if (std::fread(&nominal.x, sizeof(double), 1, stdin) + std::fread(&nominal.y, sizeof(double), 1, stdin) != 2) return 2;
    }
    PerLeg<const Nominal*> nominals;
    if (!own.empty()) nominals[Leg::LF] = own.data();

    std::vector<Selection> selections(count);
    const auto done =
        selector->select_many(given.map, poses.data(), count, selections.data(), given.legs, given.options, nominals);
    JsonWriter json(stdout);
    if (!done) {
        json.open('{').text(done.error().what(), "error").close('}');
        return 0;
    }
    json.open('[');
    for (const Selection& selection : selections) {
        json.open('{');
        write_footholds(json, selection, "footholds");
        json.number(selection.pose_cost(), "pose_cost").close('}');
    }
    const auto best = cheapest(selections.data(), count);
    json.number(best ? static_cast<double>(*best) : -1.0).close(']');
    return 0;
}
