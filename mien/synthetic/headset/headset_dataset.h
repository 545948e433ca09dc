#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/face/face.h"
#include "mien/face/motion.h"
#include "mien/headset/headset_camera.h"
#include "mien/sensor/rig.h"
#include "mien/synthetic/headset/headset_film.h"
#include "mien/virtual/headset/headset_simulator.h"

namespace mien::synthetic {

/// Of the poses in a headset_motion(), shares of those that drawing shapes alone would hardly give; none of
/// them, as wearers of studies move. Raising one: that is learnt better, of all else less is seen.
struct PoseShares {
  double eyes_alone = 0;   ///< The eyes look elsewhere; the face stays, or in half of them comes to rest.
  double winks = 0;        ///< One lid is shut.
  double closed_lips = 0;  ///< The jaw opens, with as much mouthClose.
  bool operator==(const PoseShares&) const = default;
};

/// Films to learn from: the [data] table of a recipe for a headset's network of pictures.
struct HeadsetDataRecipe {
  std::uint64_t seed = 1;
  int wearers = 300;            ///< In training, each with a face, looks and a headset of their own.
  int validation_wearers = 20;  ///< None of whom is in training.
  int donnings = 2;             ///< Times that each puts the headset on anew.
  int frames = 128;             ///< Of motion a donning, after the neutral.
  int neutral_frames = 8;       ///< The face rests at each donning, looking ahead.
  /// Pictures a second, of donnings in turn. Raising: more frames that look alike, of cameras as quick as
  /// the rig's; lowering: more of a wearer, of cameras that are slower.
  std::vector<double> rates_hz = {30, 60};
  double failing = 0.15;  ///< Share of donnings in which something hides the face, most of them for a while.
  PoseShares poses;
  int side = 96;  ///< Pixels of a view either way.
  bool operator==(const HeadsetDataRecipe&) const = default;
};

/// Reads the table's text. Errors: malformed (no TOML); out_of_range (a value), bad_usage (a key), which they
/// name.
[[nodiscard]] Result<HeadsetDataRecipe> parse_headset_data_recipe(std::string_view toml,
                                                                  const std::string& where);

/// Failures that training sees; the others are kept for tests of what confidence is worth.
[[nodiscard]] std::vector<virt::HeadsetFailure> training_failures();
[[nodiscard]] std::vector<virt::HeadsetFailure> test_failures();

/// One donning of a wearer: rests, then performs.
struct HeadsetTakeRequest {
  int frames = 128;        ///< Of motion, after the neutral.
  int neutral_frames = 8;  ///< At rest, looking ahead.
  double rate_hz = 30;
  virt::HeadsetFailure failure = virt::HeadsetFailure::none;
  /// It happens in frames [fails_from, fails_to), the neutral's counted too.
  int fails_from = 0, fails_to = std::numeric_limits<int>::max();
  std::optional<virt::HeadsetSeat> seat;  ///< None: drawn.
  int side = 96;
  /// After each so many frames of motion the headset is worn on for so long before the next is filmed, s.
  int filmed_at_once = std::numeric_limits<int>::max();
  double unfilmed_s = 0;
};
/// The frames of `motion` as these cameras see it, the neutral before.
[[nodiscard]] std::vector<FilmFrame> film_wearer(const virt::HeadsetWearer& wearer,
                                                 const virt::HeadsetFaults& faults,
                                                 const face::Motion& motion,
                                                 const HeadsetTakeRequest& request, const Random& random);

/// The rig's cameras as views of `side` pixels in films need them: films show what is cut out already.
/// Errors: headset_cameras'.
[[nodiscard]] Result<std::vector<headset::HeadsetCamera>> film_cameras(const sensor::Rig& rig,
                                                                       std::size_t side);

/// What a wearer does: a random script, and poses of single shapes and few, quickly changing.
[[nodiscard]] face::Motion headset_motion(double seconds, const Random& random, const PoseShares& poses = {});

/// Films of training and validation, a file a wearer.
struct HeadsetFilms {
  std::vector<HeadsetFilm> train, validation;
};
/// Renders into `folder` what is not there yet, and opens all; a run that was stopped goes on. The same
/// recipe and rig give the same bits on any number of threads; 0 threads: one a core. Errors: those of the
/// wearers; io; mismatch (films of another recipe stand there); cancelled. Cost: mien bench headset,
/// pictures_per_s.
[[nodiscard]] Result<HeadsetFilms> make_headset_films(const HeadsetDataRecipe& recipe, const sensor::Rig& rig,
                                                      const std::filesystem::path& folder,
                                                      const Progress& progress, unsigned threads = 0);

}  // namespace mien::synthetic
