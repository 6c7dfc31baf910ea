/// Foothold selection for quadruped robots, over onnxruntime. Start at FootholdSelector.
#pragma once

#include "footsel/foothold_selector.hpp"
