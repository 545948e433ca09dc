#pragma once

#include <array>
#include <memory>
#include <string>

#include "mien/core/error.h"
#include "mien/face/face.h"
#include "mien/render/image.h"
#include "mien/study/headset/hand_study.h"

namespace mien::study {

/// Draws moments of a hand before the mouth: what the network sees of one mouth camera, the face as it was,
/// and as it was shown without a microphone and with one.
class HandPainter {
 public:
  /// `face` must outlive it. `font`: a file to write headings with; empty: no headings. Errors: the
  /// font's.
  [[nodiscard]] static Result<HandPainter> create(const face::Face& face, const std::string& font);
  HandPainter(HandPainter&&) noexcept;
  HandPainter& operator=(HandPainter&&) noexcept;
  ~HandPainter();

  /// The moment's four pictures with their headings, of one size each.
  static constexpr std::size_t kPanels = 4;
  [[nodiscard]] std::array<render::Image, kPanels> panels(const HandMoment& moment);
  /// All side by side; sides are even, as films need them.
  [[nodiscard]] render::Image across(const HandMoment& moment);

 private:
  struct State;
  explicit HandPainter(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// Moments before, under and after the hand, a column each. Errors: bad_usage (no moments), the font's.
[[nodiscard]] Result<render::Image> hand_sheet(const HandPerson& person, double hand_s,
                                               const face::Face& face, const std::string& font);

}  // namespace mien::study
