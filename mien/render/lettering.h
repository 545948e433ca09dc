#pragma once

#include <filesystem>
#include <memory>
#include <string_view>

#include "mien/core/error.h"
#include "mien/render/image.h"

namespace mien::render {

enum class Align { left, centre, right };

/// Where Debian's package fonts-dejavu-core has DejaVu Sans.
inline constexpr std::string_view kFontFile = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";

/// A font, to write on pictures with. One thread at a time.
class Lettering {
 public:
  /// Errors: not_found (names the package to install), unsupported (no font that can be scaled).
  [[nodiscard]] static Result<Lettering> load(const std::filesystem::path& file = kFontFile);
  ~Lettering();
  Lettering(Lettering&&) noexcept;
  Lettering& operator=(Lettering&&) noexcept;

  /// Writes a line of printable ASCII; other bytes show as the font's box. `x` and `baseline` in pixels,
  /// `size_px` the height of a capital letter's line (capitals are 0.7 of it). Soft edges; what falls outside
  /// the picture is left out.
  void draw(Image& picture, std::string_view text, float x, float baseline, float size_px, Rgb ink,
            Align align = Align::left) const;

  /// Width of the line in pixels.
  [[nodiscard]] float width(std::string_view text, float size_px) const;

 private:
  struct Font;
  explicit Lettering(std::unique_ptr<Font> font);
  std::unique_ptr<Font> font_;
};

}  // namespace mien::render
