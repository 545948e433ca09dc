#include "mien/performer/script.h"

#include <algorithm>
#include <array>

#include "mien/core/time.h"

namespace mien::performer {

namespace {

constexpr std::array<std::string_view, 8> kBlockNames = {"reading", "expressions", "acted", "range_of_motion",
                                                         "free",    "eating",      "rapid", "mixed"};

template <std::size_t N>
Result<std::size_t> find_name(const std::array<std::string_view, N>& names, std::string_view name,
                              std::string_view kind) {
  const auto found = std::ranges::find(names, name);
  if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
  std::string known;
  for (const auto& n : names) known += (known.empty() ? "" : ", ") + std::string(n);
  return fail(ErrorCode::not_found, "there is no " + std::string(kind) + " '" + std::string(name) + "'", {},
              "take one of: " + known);
}

/// Cuts `seconds` into `count` equal segments of a kind.
std::vector<Segment> even_segments(Block block, double seconds, std::size_t count) {
  Segment segment;
  segment.block = block;
  segment.duration_s = seconds / static_cast<double>(count);
  return std::vector<Segment>(count, segment);
}

}  // namespace

std::string_view block_name(Block block) {
  return kBlockNames[static_cast<std::size_t>(block)];
}

Result<Block> parse_block(std::string_view name) {
  MIEN_TRY_ASSIGN(const std::size_t i, find_name(kBlockNames, name, "block"));
  return static_cast<Block>(i);
}

double Script::duration_s() const {
  double sum = 0;
  for (const Segment& segment : segments) sum += segment.duration_s;
  return sum;
}

Script default_script(Block kind, double seconds) {
  seconds = std::max(seconds, 1 / kFrameRateHz);
  Script script{.name = std::string(block_name(kind)), .segments = {}, .moves_head = true, .head = {}};
  // Least length of a piece; short scripts have fewer pieces.
  const auto pieces = [&](std::size_t wanted, double least_s) {
    return std::clamp<std::size_t>(static_cast<std::size_t>(seconds / least_s), 1, wanted);
  };
  switch (kind) {
    case Block::reading:
      script.segments = even_segments(kind, seconds, pieces(languages().size(), 6));
      for (std::size_t i = 0; i < script.segments.size(); ++i) script.segments[i].language = languages()[i];
      break;
    case Block::acted:
      script.segments = even_segments(kind, seconds, pieces(kEmotionCount - 1, 5));
      for (std::size_t i = 0; i < script.segments.size(); ++i)
        script.segments[i].emotion = static_cast<Emotion>(1 + i % (kEmotionCount - 1));
      break;
    case Block::mixed: {
      constexpr std::array kOrder = {Block::range_of_motion, Block::expressions, Block::reading, Block::acted,
                                     Block::free};
      const std::size_t count = pieces(kOrder.size(), 5);
      for (std::size_t i = 0; i < count; ++i) {
        const Script part = default_script(kOrder[i], seconds / static_cast<double>(count));
        script.segments.insert(script.segments.end(), part.segments.begin(), part.segments.end());
      }
      break;
    }
    default:
      script.segments = even_segments(kind, seconds, 1);
  }
  return script;
}

Script random_script(double seconds, Random& random) {
  Script script{.name = "random", .segments = {}, .moves_head = true, .head = {}};
  double left_s = std::max(seconds, 1 / kFrameRateHz);
  while (left_s > 0) {
    const double which = random.uniform();
    Segment segment;
    segment.block = which < 0.45   ? Block::free
                    : which < 0.67 ? Block::range_of_motion
                    : which < 0.79 ? Block::expressions
                    : which < 0.90 ? Block::reading
                                   : Block::acted;
    segment.duration_s = random.uniform(5, 20);
    if (left_s - segment.duration_s < 3) segment.duration_s = left_s;
    segment.language = languages()[random.below(languages().size())];
    segment.emotion = static_cast<Emotion>(1 + random.below(kEmotionCount - 1));
    segment.intensity = random.uniform(0.25, 1.0);
    left_s -= segment.duration_s;
    script.segments.push_back(std::move(segment));
  }
  return script;
}

}  // namespace mien::performer
