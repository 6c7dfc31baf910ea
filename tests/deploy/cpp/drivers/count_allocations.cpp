// count_allocations MODEL: how often one call asks for memory, as JSON {what: {"own_most", "total"}}.
//
// own_most: requests made from this program's code, ours and the headers' that it is built with, in the worst of a hundred
// calls. total: requests of the whole process in an ordinary call, onnxruntime's own among them. What onnxruntime needs
// for itself is counted beside it, with a session and tensors that know nothing of us: there must be no difference.

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <new>
#include <string>
#include <vector>

#include "footsel/footsel.hpp"
#include "json_output.hpp"

namespace {

// One thread does everything here, so plain counters will do.
long own_requests = 0, all_requests = 0;

}  // namespace

// Where the linker put this program's code.
extern "C" char __executable_start, etext;

#define COUNT_REQUEST()                                                               \
    do {                                                                              \
        const auto* caller = static_cast<const char*>(__builtin_return_address(0));   \
        own_requests += caller >= &__executable_start && caller < &etext;             \
        ++all_requests;                                                               \
    } while (false)

// Everything that hands out memory is replaced, by glibc's own names for it.
extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void __libc_free(void*);

void* malloc(std::size_t size) {
    COUNT_REQUEST();
    return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
    COUNT_REQUEST();
    return __libc_calloc(count, size);
}
void* realloc(void* old, std::size_t size) {
    COUNT_REQUEST();
    return __libc_realloc(old, size);
}
void* memalign(std::size_t alignment, std::size_t size) {
    COUNT_REQUEST();
    return __libc_memalign(alignment, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
    COUNT_REQUEST();
    return __libc_memalign(alignment, size);
}
int posix_memalign(void** result, std::size_t alignment, std::size_t size) {
    COUNT_REQUEST();
    *result = __libc_memalign(alignment, size);
    return *result == nullptr ? ENOMEM : 0;
}
}

void* operator new(std::size_t size) {
    COUNT_REQUEST();
    if (void* memory = __libc_malloc(size)) return memory;
    throw std::bad_alloc();
}
void* operator new[](std::size_t size) {
    COUNT_REQUEST();
    if (void* memory = __libc_malloc(size)) return memory;
    throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { __libc_free(memory); }
void operator delete[](void* memory) noexcept { __libc_free(memory); }
void operator delete(void* memory, std::size_t) noexcept { __libc_free(memory); }
void operator delete[](void* memory, std::size_t) noexcept { __libc_free(memory); }

namespace {

using namespace footsel;

constexpr int WARM_UP = 20, CALLS = 101;

struct Requests {
    long own_most = 0;
    long total = 0;  ///< the median: once in a while onnxruntime rearranges its memory
};

template <class Call>
Requests count(Call&& call) {
    std::array<long, CALLS> totals;
    Requests requests;
    for (int n = -WARM_UP; n < CALLS; ++n) {
        const long own_before = own_requests, all_before = all_requests;
        call();
        if (n < 0) continue;
        requests.own_most = std::max(requests.own_most, own_requests - own_before);
        totals[static_cast<std::size_t>(n)] = all_requests - all_before;
    }
    std::nth_element(totals.begin(), totals.begin() + CALLS / 2, totals.end());
    requests.total = totals[CALLS / 2];
    return requests;
}

/// onnxruntime alone: a session of the file's network, and tensors for some maps.
class Bare {
public:
    explicit Bare(const std::string& path) {
        Ort::SessionOptions options;
        options.SetIntraOpNumThreads(1);
        session_ = Ort::Session(env_, path.c_str(), options);
    }

    struct Tensors {
        Tensors(std::size_t maps, std::size_t planes)
            : input(maps * planes * MAP_CELLS), infeasible(maps * MAP_CELLS), cost(maps * MAP_CELLS) {
            const auto memory = Ort::MemoryInfo::CreateCpu(OrtArenaAllocator, OrtMemTypeDefault);
            const auto n = static_cast<std::int64_t>(maps);
            const std::int64_t in[]{n, static_cast<std::int64_t>(planes), 40, 40}, out[]{n, 40, 40};
            values[0] = Ort::Value::CreateTensor<float>(memory, input.data(), input.size(), in, 4);
            values[1] = Ort::Value::CreateTensor<float>(memory, infeasible.data(), infeasible.size(), out, 3);
            values[2] = Ort::Value::CreateTensor<float>(memory, cost.data(), cost.size(), out, 3);
        }
        std::vector<float> input, infeasible, cost;
        std::array<Ort::Value, 3> values{Ort::Value{nullptr}, Ort::Value{nullptr}, Ort::Value{nullptr}};
    };

    Tensors tensors(std::size_t maps) const {
        const auto shape = session_.GetInputTypeInfo(0).GetTensorTypeAndShapeInfo().GetShape();
        return Tensors(maps, static_cast<std::size_t>(shape[1]));
    }

    void run(Tensors& tensors) {
        const char* inputs[]{"maps"};
        const char* outputs[]{"infeasible", "cost"};
        session_.Run(Ort::RunOptions{nullptr}, inputs, &tensors.values[0], 1, outputs, &tensors.values[1], 2);
    }

private:
    Ort::Env env_{ORT_LOGGING_LEVEL_FATAL, "bare"};
    Ort::Session session_{nullptr};
};

}  // namespace

int main(int, char** argv) {
    const std::string model = argv[1];
    auto selector = FootholdSelector::load(model);
    if (!selector) return std::puts(selector.error().what()), 2;
    std::vector<float> heights(200 * 200, 0.0F);
    for (std::size_t cell = 0; cell < heights.size(); cell += 7) heights[cell] = cell % 3 ? 0.02F : std::nanf("");
    const auto map = ElevationMap::row_major(heights.data(), 200, 200, 0.02);
    const BasePose pose{0.1, 0.0, 0.48, 0.05, 0.02, 0.7};

    // What onnxruntime asks for depends on what it ran before, so both meet the same batches in the same order.
    Bare front(model + "/front.onnx"), hind(model + "/hind.onnx");
    auto one = front.tensors(1), two = front.tensors(2), four = front.tensors(4), eight = front.tensors(8);
    std::vector<float> local(13 * MAP_CELLS, -0.48F), cost(local.size()), confidence(local.size());
    const std::vector<Tilt> tilts(13);
    const CellEvaluation result{cost.data(), nullptr, confidence.data(), nullptr};
    std::vector<std::uint8_t> classes(local.size());
    const CellEvaluation with_classes{nullptr, nullptr, nullptr, classes.data()};
    const std::vector<BasePose> poses(5, pose);
    std::vector<Selection> selections(poses.size());

    SelectOptions choosy;
    choosy.top_k = MOST_CANDIDATES;
    choosy.nominal[Leg::LF] = Nominal{0.5, 0.3, std::nullopt};
    choosy.verify = [](Leg, const BasePose&, Cell cell, const Vector3&) { return cell.i % 2 == 0; };
    SelectOptions spendthrift;
    spendthrift.verify = [](auto...) { return std::vector<float>(100).size() == 100; };
    const BasePose off_the_map{1e3, 0, 0};

    JsonWriter json(stdout);
    const auto write = [&](const char* key, const Requests& requests) {
        json.open('{', key).number(static_cast<double>(requests.own_most), "own_most");
        json.number(static_cast<double>(requests.total), "total").close('}');
    };
    json.open('{');
    write("onnxruntime_one_leg", count([&] { front.run(one); }));
    write("select_one_leg", count([&] { (void)selector->select(map, pose, {Leg::LF}); }));
    write("onnxruntime_four_legs", count([&] { front.run(two), hind.run(two); }));
    write("select_four_legs", count([&] { (void)selector->select(map, pose); }));
    write("select_four_legs_choosy", count([&] { (void)selector->select(map, pose, {}, choosy); }));
    write("onnxruntime_batch", count([&] { front.run(eight), front.run(four), front.run(one); }));
    write("evaluate_batch", count([&] { (void)selector->evaluate(local.data(), 13, Leg::RF, tilts.data(), result); }));
    write("onnxruntime_five_poses", count([&] { front.run(eight), hind.run(eight), front.run(two), hind.run(two); }));
    write("select_five_poses", count([&] { (void)selector->select_many(map, poses.data(), 5, selections.data()); }));
    write("evaluate_classes", count([&] { (void)selector->evaluate(local.data(), 13, Leg::LH, tilts.data(), with_classes); }));
    write("select_refused", count([&] { (void)selector->select(map, off_the_map); }));
    // That the counters count: this verify asks for memory once, and is asked once.
    write("select_one_leg_spendthrift", count([&] { (void)selector->select(map, pose, {Leg::LF}, spendthrift); }));
    json.close('}');
    return 0;
}
