/// Elevation maps from `.npz` files: a zip of `.npy` arrays, stored or deflated. For the programs; a robot has its map
/// in memory.
#pragma once

#include <zlib.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "footsel/elevation_map.hpp"
#include "footsel/model_folder.hpp"
#include "footsel/result.hpp"

namespace footsel {

/// Heights that belong to us, and the view that a selector takes.
struct LoadedMap {
    std::vector<float> elevation;
    std::size_t nx = 0, ny = 0;
    double resolution = 0;
    std::array<double, 2> position{0, 0};

    ElevationMap view() const noexcept { return ElevationMap::row_major(elevation.data(), nx, ny, resolution, position); }
};

namespace npz {

/// Little-endian numbers of `Bytes` wide at an offset; nothing beyond the end.
template <class T>
std::optional<T> number_at(std::string_view bytes, std::size_t at) noexcept {
    T value;
    if (at > bytes.size() || bytes.size() - at < sizeof value) return std::nullopt;
    std::memcpy(&value, bytes.data() + at, sizeof value);
    return value;
}

/// An array of real numbers, whatever type it was stored as.
struct Array {
    std::vector<std::size_t> shape;
    std::vector<double> values;
};

/// What stands after `key` in the header's dictionary, such as 'descr': '<f4'.
inline std::string_view header_value(std::string_view header, std::string_view key) noexcept {
    const auto at = header.find(key);
    if (at == header.npos) return {};
    const auto begin = header.find_first_not_of(" ", at + key.size());
    return begin == header.npos ? std::string_view{} : header.substr(begin);
}

template <class T>
bool read_values(std::string_view bytes, std::vector<double>& values) {
    if (bytes.size() / sizeof(T) < values.size()) return false;
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<double>(*number_at<T>(bytes, i * sizeof(T)));
    return true;
}

/// A little-endian `.npy` of floats or integers.
inline std::optional<Array> parse_npy(std::string_view bytes) {
    if (bytes.substr(0, 6) != "\x93NUMPY" || bytes.size() < 10) return std::nullopt;
    const bool first_version = bytes[6] == 1;
    const auto length = first_version ? number_at<std::uint16_t>(bytes, 8).value_or(0) : number_at<std::uint32_t>(bytes, 8).value_or(0);
    const std::size_t begin = first_version ? 10 : 12;
    if (begin > bytes.size() || bytes.size() - begin < length) return std::nullopt;
    const std::string_view header = bytes.substr(begin, length), data = bytes.substr(begin + length);
    const std::string_view type = header_value(header, "'descr':").substr(0, 5);
    std::string_view shape = header_value(header, "'shape':");
    if (shape.empty() || shape.front() != '(') return std::nullopt;
    shape = shape.substr(1, shape.find(')') - 1);

    Array array;
    std::size_t count = 1;
    for (std::size_t at = 0; at < shape.size();) {
        std::size_t side = 0, digits = 0;
        for (; at < shape.size() && shape[at] >= '0' && shape[at] <= '9' && digits < 9; ++at, ++digits) {
            side = side * 10 + static_cast<std::size_t>(shape[at] - '0');
        }
        if (digits > 0) array.shape.push_back(side);
        else ++at;
        // No array is larger than the bytes that hold it.
        if (digits > 0 && (side > data.size() || (side > 0 && count > data.size() / side))) return std::nullopt;
        if (digits > 0) count *= side;
    }
    array.values.resize(count);
    const bool read = type == "'<f4'"   ? read_values<float>(data, array.values)
                      : type == "'<f8'" ? read_values<double>(data, array.values)
                      : type == "'<i4'" ? read_values<std::int32_t>(data, array.values)
                      : type == "'<i8'" ? read_values<std::int64_t>(data, array.values)
                                        : false;
    if (!read) return std::nullopt;
    if (header_value(header, "'fortran_order':").substr(0, 4) == "True" && array.shape.size() == 2) {
        const std::size_t rows = array.shape[0], columns = array.shape[1];
        std::vector<double> turned(count);
        for (std::size_t k = 0; k < count; ++k) turned[(k % rows) * columns + k / rows] = array.values[k];
        array.values = std::move(turned);
    }
    return array;
}

/// The bytes of a deflated member of `size` bytes.
inline std::optional<std::string> inflate_member(std::string_view packed, std::size_t size) {
    std::string bytes(size, '\0');
    z_stream stream{};
    if (inflateInit2(&stream, -MAX_WBITS) != Z_OK) return std::nullopt;
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
    stream.avail_in = static_cast<uInt>(packed.size());
    stream.next_out = reinterpret_cast<Bytef*>(bytes.data());
    stream.avail_out = static_cast<uInt>(size);
    const int end = inflate(&stream, Z_FINISH);
    inflateEnd(&stream);
    return end == Z_STREAM_END && stream.avail_out == 0 ? std::optional<std::string>(std::move(bytes)) : std::nullopt;
}

/// A member of a zip, found through its central directory; nothing if it is not there or damaged.
inline std::optional<std::string> member(std::string_view zip, std::string_view name) {
    constexpr std::size_t directory_end = 22, entry_head = 46, local_head = 30, most = std::size_t{1} << 31;
    const auto end = zip.rfind("PK\x05\x06");
    if (end == zip.npos || zip.size() - end < directory_end) return std::nullopt;
    const std::size_t entries = *number_at<std::uint16_t>(zip, end + 10);
    std::size_t at = *number_at<std::uint32_t>(zip, end + 16);
    for (std::size_t entry = 0; entry < entries; ++entry) {
        if (at > zip.size() || zip.size() - at < entry_head || zip.substr(at, 4) != "PK\x01\x02") return std::nullopt;
        const auto method = *number_at<std::uint16_t>(zip, at + 10);
        const auto checksum = *number_at<std::uint32_t>(zip, at + 16);
        const std::size_t packed_size = *number_at<std::uint32_t>(zip, at + 20), size = *number_at<std::uint32_t>(zip, at + 24);
        const std::size_t name_size = *number_at<std::uint16_t>(zip, at + 28);
        const std::size_t local = *number_at<std::uint32_t>(zip, at + 42);
        const std::string_view found = zip.substr(at + entry_head).substr(0, name_size);
        at += entry_head + name_size + *number_at<std::uint16_t>(zip, at + 30) + *number_at<std::uint16_t>(zip, at + 32);
        if (found != name) continue;

        if (local > zip.size() || zip.size() - local < local_head) return std::nullopt;
        const std::size_t data = local + local_head + *number_at<std::uint16_t>(zip, local + 26) + *number_at<std::uint16_t>(zip, local + 28);
        if (data > zip.size() || zip.size() - data < packed_size || size > most) return std::nullopt;
        const std::string_view packed = zip.substr(data, packed_size);
        auto bytes = method == 0   ? std::optional<std::string>(packed)
                     : method == 8 ? inflate_member(packed, size)
                                   : std::nullopt;
        if (!bytes || bytes->size() != size) return std::nullopt;
        const auto sum = crc32(0, reinterpret_cast<const Bytef*>(bytes->data()), static_cast<uInt>(bytes->size()));
        return sum == checksum ? bytes : std::nullopt;
    }
    return std::nullopt;
}

}  // namespace npz

/// An elevation map from the bytes of an `.npz`: the keys `elevation`, `resolution` and, if not centred on the world's
/// origin, `position`. Other keys are never read.
inline Result<LoadedMap> parse_map(std::string_view zip) {
    const auto array = [&](const char* key) {
        const auto bytes = npz::member(zip, std::string(key) + ".npy");
        return bytes ? npz::parse_npy(*bytes) : std::nullopt;
    };
    const auto elevation = array("elevation"), resolution = array("resolution"), position = array("position");
    if (!elevation || !resolution || elevation->shape.size() != 2 || resolution->values.size() != 1) {
        return Error::format(ErrorCode::map, "no elevation map: expected an .npz with elevation (nx, ny) and resolution");
    }
    LoadedMap map;
    map.elevation.assign(elevation->values.begin(), elevation->values.end());
    map.nx = elevation->shape[0];
    map.ny = elevation->shape[1];
    map.resolution = resolution->values[0];
    if (position && position->values.size() == 2) map.position = {position->values[0], position->values[1]};
    return map;
}

inline Result<LoadedMap> load_map(const std::string& path) {
    const auto bytes = read_file(path);
    if (!bytes) return Error::format(ErrorCode::map, "cannot read %s; give an elevation map .npz", path.c_str());
    return parse_map(*bytes);
}

}  // namespace footsel
