#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/face/profile.h"

namespace mien::speech {

/// The visemes of XR_META_face_tracking_visemes, in its order; "sil" is the mouth at rest.
inline constexpr std::size_t kVisemeCount = 15;
inline constexpr std::array<std::string_view, kVisemeCount> kVisemeNames = {
    "sil", "PP", "FF", "TH", "DD", "kk", "CH", "SS", "nn", "RR", "aa", "E", "ih", "oh", "ou"};
inline constexpr std::uint8_t kSilence = 0;

/// What the mouth does for a viseme, and how it comes and goes among its neighbours.
struct Viseme {
  std::array<float, face::kShapeCount> weights{};  ///< Of the sound alone, 0 to 1.
  float tongue = 0;                                ///< Tongue out, 0 to 1.
  bool closes = false;                             ///< The lips meet, whatever the jaw does.
  double onset_s = 0.05, release_s = 0.05;         ///< Sigma of the influence before and after the sound.
  float jaw = 0, lips = 0;                         ///< Influence against its neighbours, 0 to 1.
};

/// A part of a sound: which viseme, and what share of its time.
struct VisemePart {
  std::uint8_t viseme = kSilence;
  double share = 1;
};
/// What one sound is made of, in order: one part, two of a diphthong; none for what leaves the mouth as it
/// is.
using VisemeParts = std::span<const VisemePart>;

/// From speech sounds to visemes, and from these to shapes. Immutable.
class Visemes {
 public:
  /// The table that is part of the program: rigs/visemes.toml, whose comments define the keys.
  [[nodiscard]] static const Visemes& standard();
  /// Errors: malformed (not TOML; a key, class, shape or viseme that is unknown, missing or there twice; a
  /// shape that is not of mouth or jaw),
  /// out_of_range.
  [[nodiscard]] static Result<Visemes> parse(std::string_view toml, const std::string& where);

  [[nodiscard]] const Viseme& operator[](std::size_t viseme) const { return visemes_[viseme]; }
  /// By an ARPAbet symbol without its stress ("AH"); none for silence, noises and what is unknown.
  [[nodiscard]] VisemeParts of_arpabet(std::string_view symbol) const;
  /// By one letter of the IPA, UTF-8.
  [[nodiscard]] VisemeParts of_ipa(std::string_view letter) const;

 private:
  struct Named {
    std::string name;
    std::vector<VisemePart> parts;
  };
  static VisemeParts find(const std::vector<Named>& sounds, std::string_view name);

  std::array<Viseme, kVisemeCount> visemes_;
  std::vector<Named> arpabet_, ipa_;  // By name.
};

}  // namespace mien::speech
