#include "mien/render/lettering.h"

#include <ft2build.h>
#include FT_FREETYPE_H

#include <algorithm>
#include <cmath>
#include <system_error>
#include <utility>

namespace mien::render {
namespace {

constexpr float kCapitals = 0.7F;  // Height of capitals over the size of the line.
constexpr float kFixed = 64;       // FreeType counts 64ths of a pixel.

/// What the font is asked for in place of a byte that is no printable ASCII: it has nothing there but its
/// box.
constexpr FT_ULong kNoCharacter = 0xFFFF;

FT_ULong character(char c) {
  return c >= ' ' && c <= '~' ? static_cast<FT_ULong>(c) : kNoCharacter;
}

}  // namespace

struct Lettering::Font {
  FT_Library library = nullptr;
  FT_Face face = nullptr;
  float capital = 1;  // Height of an H over the font's size.

  Font() = default;
  Font(const Font&) = delete;
  Font& operator=(const Font&) = delete;
  ~Font() {
    if (face != nullptr) FT_Done_Face(face);
    if (library != nullptr) FT_Done_FreeType(library);
  }

  void set_size(float size_px) const {
    FT_Set_Char_Size(face, 0, static_cast<FT_F26Dot6>(std::lround(kFixed * kCapitals * size_px / capital)),
                     72, 72);
  }
  /// Makes `c` the face's glyph, moved to the right by a part of a pixel; false where that fails.
  [[nodiscard]] bool load(char c, float part, FT_Int32 flags) const {
    FT_Vector move{.x = static_cast<FT_Pos>(std::lround(kFixed * part)), .y = 0};
    FT_Set_Transform(face, nullptr, &move);
    return FT_Load_Char(face, character(c), FT_LOAD_NO_HINTING | flags) == 0;
  }
  /// Pixels to the next character.
  [[nodiscard]] float advance() const { return static_cast<float>(face->glyph->linearHoriAdvance) / 65536; }
};

Lettering::Lettering(std::unique_ptr<Font> font) : font_(std::move(font)) {}
Lettering::~Lettering() = default;
Lettering::Lettering(Lettering&&) noexcept = default;
Lettering& Lettering::operator=(Lettering&&) noexcept = default;

Result<Lettering> Lettering::load(const std::filesystem::path& file) {
  auto font = std::make_unique<Font>();
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored))
    return fail(ErrorCode::not_found, "the font for lettering is missing", file.string(),
                "install Debian's fonts-dejavu-core");
  if (FT_Init_FreeType(&font->library) != 0)
    return fail(ErrorCode::internal, "FreeType does not start", file.string());
  if (FT_New_Face(font->library, file.c_str(), 0, &font->face) != 0 || !FT_IS_SCALABLE(font->face))
    return fail(ErrorCode::unsupported, "this is no font that can be scaled", file.string(),
                "install Debian's fonts-dejavu-core");
  if (FT_Load_Char(font->face, 'H', FT_LOAD_NO_SCALE) == 0 && font->face->glyph->metrics.height > 0)
    font->capital =
        static_cast<float>(font->face->glyph->metrics.height) / static_cast<float>(font->face->units_per_EM);
  return Lettering(std::move(font));
}

float Lettering::width(std::string_view text, float size_px) const {
  font_->set_size(size_px);
  float sum = 0;
  for (const char c : text)
    if (font_->load(c, 0, FT_LOAD_DEFAULT)) sum += font_->advance();
  return sum;
}

void Lettering::draw(Image& picture, std::string_view text, float x, float baseline, float size_px, Rgb ink,
                     Align align) const {
  if (align == Align::centre) x -= 0.5F * width(text, size_px);
  if (align == Align::right) x -= width(text, size_px);
  font_->set_size(size_px);
  const auto base = static_cast<int>(std::lround(baseline));
  for (const char c : text) {
    const float whole = std::floor(x);
    if (!font_->load(c, x - whole, FT_LOAD_RENDER)) continue;
    const FT_GlyphSlotRec& glyph = *font_->face->glyph;
    const int left = static_cast<int>(whole) + glyph.bitmap_left, top = base - glyph.bitmap_top;
    for (int row = 0; row < static_cast<int>(glyph.bitmap.rows); ++row)
      for (int column = 0; column < static_cast<int>(glyph.bitmap.width); ++column) {
        const int px = left + column, py = top + row;
        if (px < 0 || py < 0 || px >= picture.width || py >= picture.height) continue;
        const float cover = static_cast<float>(glyph.bitmap.buffer[row * glyph.bitmap.pitch + column]) / 255;
        std::uint8_t* out = picture.pixel(px, py);
        for (std::size_t k = 0; k < 3; ++k)
          out[k] = static_cast<std::uint8_t>(
              static_cast<float>(out[k]) + cover * (static_cast<float>(ink[k]) - static_cast<float>(out[k])) +
              0.5F);
      }
    x += font_->advance();
  }
}

}  // namespace mien::render
