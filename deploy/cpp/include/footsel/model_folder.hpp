/// The files of a released model, and the checksums that hold them together.
#pragma once

#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <sstream>
#include <string>
#include <system_error>
#include <utility>

#include "footsel/legs.hpp"
#include "footsel/result.hpp"
#include "footsel/sha256.hpp"

namespace footsel {

inline constexpr const char* SUMS_FILE = "SHA256SUMS";

/// What a model folder has of each network.
enum class Variant {
    float32,  ///< as it was trained
    int8,     ///< quantised
};

/// Name of a pair's network in a model folder, such as `front.onnx`.
inline std::string network_file(Pair pair, Variant variant) {
    return std::string(name(pair)) + (variant == Variant::int8 ? ".int8.onnx" : ".onnx");
}

/// The whole content of a file, or nothing if it cannot be read. Allocates.
inline std::optional<std::string> read_file(const std::string& path) {
    std::error_code ignored;
    // A folder can be opened like a file, and reading it throws.
    if (!std::filesystem::is_regular_file(path, ignored)) return std::nullopt;
    std::ifstream file(path, std::ios::binary);
    std::string content{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    return file.is_open() && !file.bad() ? std::optional<std::string>(std::move(content)) : std::nullopt;
}

/// The content of a model's file, taken as it is. Allocates.
inline Result<std::string> read_unchecked(const std::string& path) {
    if (auto content = read_file(path)) return *std::move(content);
    return Error::format(ErrorCode::model, "cannot read %s; copy or export the whole model folder again", path.c_str());
}

/// A file of a model folder, after it matched its line in SHA256SUMS. Allocates.
inline Result<std::string> read_released(const std::string& folder, const std::string& file) {
    const auto sums = read_file(folder + "/" + SUMS_FILE);
    if (!sums) {
        return Error::format(ErrorCode::model, "%s has no %s; give a folder written by `footsel export`", folder.c_str(),
                             SUMS_FILE);
    }
    std::istringstream lines(*sums);
    std::string digest;
    for (std::string line; std::getline(lines, line);) {
        if (line.size() > 66 && line.compare(64, 2, "  ") == 0 && line.compare(66, std::string::npos, file) == 0) {
            digest = line.substr(0, 64);
        }
    }
    if (digest.empty()) {
        return Error::format(ErrorCode::model, "%s/%s does not list %s; give a folder that has this variant", folder.c_str(),
                             SUMS_FILE, file.c_str());
    }
    auto content = read_unchecked(folder + "/" + file);
    if (content && sha256(*content) != digest) {
        return Error::format(ErrorCode::model,
                             "%s/%s is not the file that was released (its SHA-256 differs from %s); "
                             "copy or export the whole model folder again",
                             folder.c_str(), file.c_str(), SUMS_FILE);
    }
    return content;
}

}  // namespace footsel
