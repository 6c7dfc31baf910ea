// threads MODEL: four threads with a selector each, over the same networks, must choose what one thread chooses.

#include <cstdio>
#include <thread>
#include <vector>

#include "footsel/footsel.hpp"

using namespace footsel;

namespace {

BasePose pose_of(int n) { return {0.01 * n, -0.02 * n, 0.48, 0.01 * n, -0.01 * n, 0.3 * n}; }

std::vector<double> choose_all(FootholdSelector& selector, const ElevationMap& map) {
    std::vector<double> costs;
    for (int n = 0; n < 25; ++n) {
        const auto selection = selector.select(map, pose_of(n));
        for (Leg leg : LEGS) costs.push_back(selection && (*selection)[leg].ok() ? (*selection)[leg].final_cost : -1);
    }
    return costs;
}

}  // namespace

int main(int, char** argv) {
    auto selector = FootholdSelector::load(argv[1]);
    if (!selector) return std::puts(selector.error().what()), 2;
    std::vector<float> heights(200 * 200);
    for (std::size_t cell = 0; cell < heights.size(); ++cell) heights[cell] = static_cast<float>(cell * 7919 % 101) * 1e-3F;
    const auto map = ElevationMap::row_major(heights.data(), 200, 200, 0.02);
    const auto expected = choose_all(*selector, map);

    std::vector<std::vector<double>> found(4);
    std::vector<std::thread> threads;
    for (auto& costs : found) {
        threads.emplace_back([&] {
            auto own = selector->sibling();
            if (own) costs = choose_all(*own, map);
        });
    }
    for (auto& thread : threads) thread.join();
    int right = 0;
    for (const auto& costs : found) right += costs == expected;
    std::printf("%d of %zu threads agree\n", right, found.size());
    return right == 4 ? 0 : 1;
}
