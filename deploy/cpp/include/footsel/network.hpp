/// One ONNX network and its contract, and the buffers that a batch of maps goes through.
#pragma once

#include <onnxruntime_cxx_api.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "footsel/model_contract.hpp"
#include "footsel/result.hpp"

namespace footsel {

/// Names in the graph. The logits (n, 14, 40, 40) stay where they are but for the class of every cell: a choice needs no
/// more than two planes a map.
inline constexpr const char* INPUT = "maps";
inline constexpr const char* LOGITS_OUTPUT = "logits";
inline constexpr const char* INFEASIBLE_OUTPUT = "infeasible";
inline constexpr const char* COST_OUTPUT = "cost";

/// Memory for a fixed number of maps, laid out once and bound to tensors that onnxruntime reads and writes in place.
class Batch {
public:
    Batch() noexcept = default;
    /// Allocates. logits: (maps, 14, 40, 40) that may be shared with batches that do not run at the same time.
    Batch(std::size_t maps, std::size_t planes, float* logits)
        : maps_(maps),
          logits_(logits),
          input_(maps * planes * MAP_CELLS),
          infeasible_(maps * MAP_CELLS),
          cost_(maps * MAP_CELLS) {
        const auto memory = Ort::MemoryInfo::CreateCpu(OrtArenaAllocator, OrtMemTypeDefault);
        const auto n = static_cast<std::int64_t>(maps), side = static_cast<std::int64_t>(CELLS);
        const std::array<std::int64_t, 4> in{n, static_cast<std::int64_t>(planes), side, side};
        const std::array<std::int64_t, 3> out{n, side, side};
        const std::array<std::int64_t, 4> scores{n, CLASSES, side, side};
        input_tensor_ = Ort::Value::CreateTensor<float>(memory, input_.data(), input_.size(), in.data(), in.size());
        const auto bind = [&](std::vector<float>& plane) {
            return Ort::Value::CreateTensor<float>(memory, plane.data(), plane.size(), out.data(), out.size());
        };
        output_tensors_ = {bind(infeasible_), bind(cost_),
                           Ort::Value::CreateTensor<float>(memory, logits_, maps * CLASSES * MAP_CELLS, scores.data(),
                                                           scores.size())};
    }

    std::size_t maps() const noexcept { return maps_; }

    /// Where the planes of a map are to be written, (planes, 40, 40).
    float* input(std::size_t map) noexcept { return input_.data() + map * (input_.size() / maps_); }

    /// What the network said of a map, (40, 40): p(infeasible), and the mean cost over all classes, in [0, 255].
    const float* infeasible(std::size_t map) const noexcept { return infeasible_.data() + map * MAP_CELLS; }
    const float* cost(std::size_t map) const noexcept { return cost_.data() + map * MAP_CELLS; }

    /// The most probable of the feasible classes at a cell, if the logits were asked for.
    std::uint8_t likeliest(std::size_t map, std::size_t cell) const noexcept {
        const float* scores = logits_ + map * CLASSES * MAP_CELLS + cell;
        std::uint8_t best = 0;
        for (std::uint8_t other = 1; other < COST_BINS; ++other) {
            if (scores[other * MAP_CELLS] > scores[best * MAP_CELLS]) best = other;
        }
        return best;
    }

private:
    friend class Network;

    std::size_t maps_ = 0;
    float* logits_ = nullptr;
    std::vector<float> input_, infeasible_, cost_;
    Ort::Value input_tensor_{nullptr};
    std::array<Ort::Value, 3> output_tensors_{Ort::Value{nullptr}, Ort::Value{nullptr}, Ort::Value{nullptr}};
};

/// An onnxruntime session that keeps what its contract says. Copies share the session, which is safe to run from
/// several threads at once, each with a Batch of its own.
class Network {
public:
    /// From the content of the file that messages call `source`.
    static Result<Network> from_bytes(std::string_view content, const std::string& source) noexcept {
        return detail::guarded(ErrorCode::model, source.c_str(), [&]() -> Result<Network> {
            // The first thing to ask: nothing of onnxruntime's C++ interface works without its table of functions.
            if (OrtGetApiBase()->GetApi(ORT_API_VERSION) == nullptr) {
                return Error::format(ErrorCode::engine,
                                     "the onnxruntime library is %s, but this program was built with headers of 1.%d; "
                                     "install that version or a newer one",
                                     OrtGetApiBase()->GetVersionString(), ORT_API_VERSION);
            }
            auto session = start_session(content, source);
            if (!session) return session.error();
            auto contract = read_contract(**session, source);
            if (!contract) return contract.error();
            if (auto ports = check_ports(**session, *contract, source); !ports) return ports.error();
            return Network(std::move(*session), std::move(*contract));
        });
    }

    const ModelContract& contract() const noexcept { return *contract_; }

    /// Evaluate what stands in the batch's input. Allocates nothing of ours; onnxruntime has its own scratch memory.
    Result<void> run(Batch& batch, bool with_logits = false) const noexcept {
        return detail::guarded(ErrorCode::engine, "onnxruntime", [&]() -> Result<void> {
            static constexpr const char* outputs[]{INFEASIBLE_OUTPUT, COST_OUTPUT, LOGITS_OUTPUT};
            session_->session.Run(Ort::RunOptions{nullptr}, &INPUT, &batch.input_tensor_, 1, outputs,
                                  batch.output_tensors_.data(), with_logits ? 3 : 2);
            return {};
        });
    }

private:
    /// A session and the environment that it must not outlive.
    struct Session {
        Ort::Env env{ORT_LOGGING_LEVEL_FATAL, "footsel"};
        Ort::Session session{nullptr};
    };

    Network(std::shared_ptr<Session> session, ModelContract contract)
        : session_(std::move(session)), contract_(std::make_shared<const ModelContract>(std::move(contract))) {}

    /// One thread that sleeps when idle: a second gains nothing here, and spinning starves the robot's controller.
    static Ort::SessionOptions session_options() {
        Ort::SessionOptions options;
        options.SetIntraOpNumThreads(1);
        options.SetInterOpNumThreads(1);
        options.SetExecutionMode(ORT_SEQUENTIAL);
        options.SetGraphOptimizationLevel(ORT_ENABLE_ALL);
        options.AddConfigEntry("session.intra_op.allow_spinning", "0");
        // Failures reach the caller as results; onnxruntime need not print them as well.
        options.SetLogSeverityLevel(ORT_LOGGING_LEVEL_FATAL);
        return options;
    }

    static Result<std::shared_ptr<Session>> start_session(std::string_view content, const std::string& source) {
        auto session = std::make_shared<Session>();
        try {
            session->session = Ort::Session(session->env, content.data(), content.size(), session_options());
        } catch (const Ort::Exception& exception) {
            const std::string_view text = exception.what();
            for (const char* cause : {"Opset ", "IR version", "domain_version"}) {
                if (text.find(cause) == text.npos) continue;
                return Error::format(ErrorCode::model,
                                     "%s is written for another onnxruntime than %s (%s); install another onnxruntime, or "
                                     "export the model again",
                                     source.c_str(), OrtGetApiBase()->GetVersionString(), cause);
            }
            const auto first_line = static_cast<int>(std::min(text.find('\n'), text.size()));
            return Error::format(ErrorCode::model, "%s is damaged or no ONNX model (%.*s); copy or export it again",
                                 source.c_str(), first_line, text.data());
        }
        return session;
    }

    static Result<ModelContract> read_contract(const Session& session, const std::string& source) {
        Ort::AllocatorWithDefaultOptions allocator;
        const auto metadata = session.session.GetModelMetadata();
        const auto text = metadata.LookupCustomMetadataMapAllocated(CONTRACT_KEY, allocator);
        if (text == nullptr) {
            return Error::format(ErrorCode::model, "%s carries no footsel contract; use a model written by `footsel export`",
                                 source.c_str());
        }
        return ModelContract::parse(text.get(), source.c_str());
    }

    /// Refuse a graph whose inputs and outputs are not what the contract says, with a free batch axis.
    static Result<void> check_ports(const Session& session, const ModelContract& contract, const std::string& source) {
        Ort::AllocatorWithDefaultOptions allocator;
        const auto side = static_cast<std::int64_t>(CELLS);
        const auto planes = static_cast<std::int64_t>(contract.encoding.planes.size());
        const auto is = [](const Ort::TypeInfo& type, const std::vector<std::int64_t>& shape) {
            if (type.GetONNXType() != ONNX_TYPE_TENSOR) return false;
            const auto tensor = type.GetTensorTypeAndShapeInfo();
            return tensor.GetElementType() == ONNX_TENSOR_ELEMENT_DATA_TYPE_FLOAT && tensor.GetShape() == shape;
        };
        const auto& graph = session.session;
        bool right = graph.GetInputCount() == 1 && graph.GetOutputCount() == 3 &&
                     graph.GetInputNameAllocated(0, allocator).get() == std::string_view(INPUT) &&
                     is(graph.GetInputTypeInfo(0), {-1, planes, side, side});
        for (std::size_t i = 0; right && i < 3; ++i) {
            const auto allocated = graph.GetOutputNameAllocated(i, allocator);
            const std::string_view name = allocated.get();
            const auto type = graph.GetOutputTypeInfo(i);
            right = (name == LOGITS_OUTPUT && is(type, {-1, CLASSES, side, side})) ||
                    ((name == INFEASIBLE_OUTPUT || name == COST_OUTPUT) && is(type, {-1, side, side}));
        }
        if (right) return {};
        return Error::format(ErrorCode::model,
                             "%s has other inputs or outputs than its contract says: float tensors maps [n, %d, 40, 40] -> "
                             "logits [n, 14, 40, 40], infeasible [n, 40, 40], cost [n, 40, 40]; export the model again",
                             source.c_str(), static_cast<int>(planes));
    }

    std::shared_ptr<Session> session_;
    std::shared_ptr<const ModelContract> contract_;
};

}  // namespace footsel
