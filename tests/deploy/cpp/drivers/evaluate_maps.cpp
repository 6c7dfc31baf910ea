// evaluate_maps MODEL LEG N: N tilts (roll, pitch) of 64 bits and N local maps of 32 bits on stdin; cost and confidence of
// every cell on stdout, then whether it is feasible, then its class.

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <vector>

#include "footsel/footsel.hpp"

using namespace footsel;

int main(int, char** argv) {
    auto selector = FootholdSelector::load(argv[1]);
    if (!selector) return std::puts(selector.error().what()), 2;
    const std::size_t maps = std::strtoul(argv[3], nullptr, 10), cells = maps * MAP_CELLS;
    std::vector<Tilt> tilts(maps);
    std::vector<float> heights(cells), cost(cells), confidence(cells);
    const auto feasible = std::make_unique<bool[]>(cells);
    std::vector<std::uint8_t> classes(cells);
    for (Tilt& tilt : tilts) {
        if (std::fread(&tilt.roll, sizeof(double), 1, stdin) + std::fread(&tilt.pitch, sizeof(double), 1, stdin) != 2) return 2;
    }
    if (std::fread(heights.data(), sizeof(float), cells, stdin) != cells) return 2;
    const auto done = selector->evaluate(heights.data(), maps, *leg_of(argv[2]), tilts.data(),
                                         {cost.data(), feasible.get(), confidence.data(), classes.data()});
    if (!done) return std::puts(done.error().what()), 2;
    std::fwrite(cost.data(), sizeof(float), cells, stdout);
    std::fwrite(confidence.data(), sizeof(float), cells, stdout);
    std::fwrite(feasible.get(), sizeof(bool), cells, stdout);
    std::fwrite(classes.data(), 1, cells, stdout);
    return 0;
}
