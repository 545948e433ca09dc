#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "mien/core/random.h"
#include "mien/performer/head_motion.h"
#include "mien/performer/speech.h"

namespace mien::performer {

/// Kind of performance.
enum class Block : std::uint8_t {
  reading,          ///< Calm reading.
  expressions,      ///< Classified expressions: neutral, ramp, hold, ramp.
  acted,            ///< Lines acted with one emotion.
  range_of_motion,  ///< Every group of shapes through its range, slowly and fast.
  free,             ///< Crude random motion of all shapes: a broad prior for training.
  eating,           ///< A meal: bites, chewing, sips from a cup.
  rapid,            ///< The fastest motions of faces and heads.
  mixed,            ///< The blocks from reading to free in turn.
};
/// "reading", "range_of_motion", ...
[[nodiscard]] std::string_view block_name(Block block);
/// Errors: not_found, listing the names.
[[nodiscard]] Result<Block> parse_block(std::string_view name);

/// The basic emotions (Ekman) and contempt.
enum class Emotion : std::uint8_t { neutral, joy, sadness, anger, fear, disgust, surprise, contempt };
inline constexpr std::size_t kEmotionCount = 8;

/// One piece of a script.
struct Segment {
  Block block = Block::free;  ///< Not mixed.
  double duration_s = 10;
  Emotion emotion = Emotion::neutral;  ///< Of acted lines.
  double intensity = 0.7;              ///< Of the emotion, 0 to 1.
  std::string language = "en";         ///< Of reading and acted lines: one of languages().
  /// Speech of the segment; random in `language` where absent. A shorter one is followed by silence, a longer
  /// one is cut.
  std::optional<Utterance> utterance;
};

/// A performance: segments in order, and the head's motion.
struct Script {
  std::string name;
  std::vector<Segment> segments;
  /// False: upright head, and has_head false in the motion.
  bool moves_head = true;
  /// Head episodes in order of begin_s; empty: chosen by block.
  std::vector<HeadEpisode> head;

  [[nodiscard]] double duration_s() const;
};

/// A script of one kind, `seconds` long (at least 1/60). Reading goes through all languages, acted lines
/// through all emotions, mixed through all blocks.
[[nodiscard]] Script default_script(Block kind, double seconds);

/// A script for training: segments of 5 to 20 s of the blocks from reading to free, nearly half of them free.
[[nodiscard]] Script random_script(double seconds, Random& random);

}  // namespace mien::performer
