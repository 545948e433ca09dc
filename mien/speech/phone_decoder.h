#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string_view>

#include "mien/core/error.h"
#include "mien/speech/sound_block.h"

namespace mien::speech {

/// One phone of what is being said, as it is understood so far.
struct HeardPhone {
  /// ARPAbet without stress, "AH"; "SIL" for silence and noises. Ended by a zero.
  std::array<char, 4> symbol{};
  std::uint64_t begin = 0;  ///< Frames of 10 ms since the decoder's first block.
  std::uint64_t end = 0;    ///< Its last frame and one.
  bool open = false;        ///< Of what is being said: it may be revised yet.
  [[nodiscard]] std::string_view name() const { return symbol.data(); }
};

/// PocketSphinx as an all-phone recogniser of a stream, with its English acoustic model: any language is
/// heard as English phones. What it says of the newest 40 ms is not there yet, and what it said of an
/// utterance may be revised until that ends: in a pause of 0.4 s, or after 12 s of speech. The mean of the
/// spectrum, which it takes off, is followed from utterance to utterance. The same blocks from create() on
/// give the same phones (no dither). One stream, one thread.
class PhoneDecoder {
 public:
  /// Debian's pocketsphinx-en-us.
  static constexpr std::string_view kModel = "/usr/share/pocketsphinx/model/en-us";

  /// Whether the model is installed. Errors: not_found, which names the package.
  [[nodiscard]] static Result<void> check(const std::filesystem::path& model = kModel);
  /// Reads 11 MB, which takes a tenth of a second. Errors: check()'s, internal.
  [[nodiscard]] static Result<PhoneDecoder> create(const std::filesystem::path& model = kModel);
  PhoneDecoder(PhoneDecoder&&) noexcept;
  PhoneDecoder& operator=(PhoneDecoder&&) noexcept;
  ~PhoneDecoder();

  /// The next block; what was said lately, oldest first and none within another: valid until the next call.
  /// Takes up to 3 ms of an idle core; the first block of an utterance five times that, since the quiet ones
  /// before it count.
  std::span<const HeardPhone> push(const Block& block);
  /// Ends what is being said; the next block is the first again.
  void reset();

 private:
  struct State;
  explicit PhoneDecoder(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace mien::speech
