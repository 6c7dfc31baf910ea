#include <cstdio>
#include <vector>

#include <footsel/footsel.hpp>

footsel::Result<footsel::Selection> choose(footsel::FootholdSelector& selector, const footsel::ElevationMap& map);

int main(int, char** argv) {
    auto selector = footsel::FootholdSelector::load(argv[1]);
    if (!selector) return std::puts(selector.error().what()), 2;
    const std::vector<float> flat(200 * 200, 0.0F);
    const auto selection = choose(*selector, footsel::ElevationMap::row_major(flat.data(), 200, 200, 0.02));
    if (!selection) return std::puts(selection.error().what()), 2;
    std::printf("%s\n", (*selection)[footsel::Leg::RH].status_name());
    return 0;
}
