#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/face/profile.h"
#include "mien/model/causal_network.h"
#include "mien/model/confidence.h"
#include "mien/model/safetensors.h"
#include "mien/speech/log_mel.h"

namespace mien::speech {

/// Numbers that a network reads of one block.
inline constexpr std::size_t kConditionOfBlock = kFramesPerBlock * kMelBands;

/// A trained network from sound to the mouth with its provenance: one safetensors file
/// (docs/method/speech.md). A causal network, a step a block: condition of two log-mel frames, each band (log
/// - mean) / scale; outputs in [-1, 1] for [0, 1] of every shape, of how far the lips are closed, and of
/// whether there is a voice.
struct SpeechNetworkFile {
  model::Architecture architecture;
  std::vector<std::string> shapes;  ///< Names, in the outputs' order; closure and voice follow.
  /// What its answer is delayed by, blocks: the answer after a block is of the mouth in the middle of the one
  /// so many before. 0 to 1.
  std::size_t look_ahead = 0;
  std::array<float, kMelBands> mean{}, scale{};  ///< Of each band; scales above 0.
  std::string recipe;                            ///< Text of the training recipe (TOML).
  std::string results;                           ///< Measurements of the training, JSON; may be empty.
  std::vector<model::Tensor> network;
  /// What its answers are worth by Heard::voice as coverage (mien study speech); none: nobody
  /// measured it.
  std::optional<model::ConfidenceTable> confidence;

  [[nodiscard]] std::size_t closure_output() const { return shapes.size(); }
  [[nodiscard]] std::size_t voice_output() const { return shapes.size() + 1; }
};

/// Errors: as parse_safetensors; malformed, out_of_range, mismatch (sizes, names twice or of no shape);
/// unsupported (another file's format, a newer version).
[[nodiscard]] Result<SpeechNetworkFile> parse_speech_network(std::span<const std::byte> bytes,
                                                             std::string_view where);
[[nodiscard]] Result<SpeechNetworkFile> read_speech_network(const std::filesystem::path& path);
/// Inverse of parse_speech_network, with the same errors.
[[nodiscard]] Result<std::vector<std::byte>> format_speech_network(const SpeechNetworkFile& file);
/// Writes the file atomically. Errors: as format_speech_network, io.
[[nodiscard]] Result<void> write_speech_network(const std::filesystem::path& path,
                                                const SpeechNetworkFile& file);

/// The condition of a block's frames.
void encode_mel(const SpeechNetworkFile& file, std::span<const MelFrame, kFramesPerBlock> frames,
                std::span<float> out);

/// What a network makes of a block.
struct HeardMouth {
  face::BlendshapeWeights weights;  ///< Shapes that it does not answer for: 0.
  float closure = 0;                ///< How far the lips are closed, 0 to 1.
  float voice = 0;                  ///< Whether there is a voice, 0 to 1.
};

/// A SpeechNetworkFile on a stream of blocks. One stream, one thread.
class SpeechNetwork {
 public:
  /// Errors: the network's.
  [[nodiscard]] static Result<SpeechNetwork> create(SpeechNetworkFile file);

  /// The next block's frames (LogMel::push). No allocation. Cost: the network's flop_count().
  void step(std::span<const MelFrame, kFramesPerBlock> frames, HeardMouth& out);
  void reset() { state_.reset(); }
  [[nodiscard]] const SpeechNetworkFile& file() const { return file_; }

 private:
  SpeechNetwork(SpeechNetworkFile file, model::CausalNetwork network);

  SpeechNetworkFile file_;
  model::CausalNetwork network_;
  model::CausalNetwork::State state_;
  std::vector<std::size_t> places_;  // Of each output its shape.
  std::array<float, kConditionOfBlock> condition_{};
  std::vector<float> answer_;
};

}  // namespace mien::speech
