#include "mien/face/gltf/names.h"

#include <algorithm>

#include "mien/core/ascii.h"

namespace mien::face::gltf {

std::string plain(std::string_view name) {
  std::string out;
  for (const char c : name)
    if (const char low = ascii_lower(c); (low >= 'a' && low <= 'z') || (low >= '0' && low <= '9')) out += low;
  return out;
}

bool has_word(std::string_view text, std::initializer_list<std::string_view> words) {
  return std::ranges::any_of(words,
                             [&](std::string_view w) { return text.find(w) != std::string_view::npos; });
}

Material guess_material(const std::string& names) {
  if (has_word(names, {"brow", "hair", "beard"})) return Material::hair;
  if (has_word(names, {"lash"})) return Material::lash;
  if (has_word(names, {"tongue"})) return Material::tongue;
  if (has_word(names, {"gum"})) return Material::gums;
  if (has_word(names, {"teeth", "tooth"})) return Material::teeth;
  if (has_word(names, {"cornea", "occlusion", "tearline", "lacrimal"})) return Material::cornea;
  if (has_word(names, {"iris"})) return Material::iris;
  if (has_word(names, {"pupil"})) return Material::pupil;
  if (has_word(names, {"eyeline"})) return Material::lash;
  if (has_word(names, {"eye", "sclera"})) return Material::sclera;
  if (has_word(names, {"mouth", "oral"})) return Material::mouth_inside;
  if (has_word(names, {"cloth", "shirt"})) return Material::cloth;
  if (has_word(names, {"accessor", "glasses"})) return Material::other;
  return Material::skin;
}

std::string printable(std::string name) {
  if (name.size() > 80) name.resize(80);
  for (char& c : name)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = ' ';
  return name;
}

}  // namespace mien::face::gltf
