// The headers in a second file of the same program: nothing may be defined twice.
#include <footsel/footsel.hpp>

footsel::Result<footsel::Selection> choose(footsel::FootholdSelector& selector, const footsel::ElevationMap& map) {
    return selector.select(map, {0, 0, 0.48, 0, 0, 0.3});
}
