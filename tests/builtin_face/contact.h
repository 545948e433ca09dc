#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mien/face/face.h"

/// Where parts of a built-in face go through each other, found by rays.
namespace mien::builtin_face {

/// Which two parts, or which part with itself.
enum class Contact : std::uint8_t {
  skin_eyeball,  ///< Skin and lids in an eyeball, the cornea's bulge included.
  skin_teeth,    ///< Skin, lips and the mouth's lining in a tooth.
  tongue_teeth,  ///< The tongue in a tooth.
  lip_lip,       ///< One lip in the other.
  lid_lid,       ///< The upper lid's margin beyond the lower's.
  inverted,      ///< Triangles of skin, lips or lids that face against the surface around them: how many.
  count
};
inline constexpr std::size_t kContactCount = static_cast<std::size_t>(Contact::count);
[[nodiscard]] std::string_view contact_name(Contact contact);

/// The deepest of each kind, mm; of inverted triangles their number. 0 where nothing touches.
using Contacts = std::array<double, kContactCount>;

/// What touches what on one built-in face, of any identity.
class ContactFinder {
 public:
  /// `face` outlives the finder.
  explicit ContactFinder(const face::Face& face);

  /// Shape: as the face's neutral; eyes turned already.
  [[nodiscard]] Contacts find(std::span<const Vec3f> vertices_m) const;

 private:
  using Triangle = std::array<std::uint32_t, 3>;
  /// A closed surface, and the vertices that make it.
  struct Body {
    std::vector<Triangle> triangles;
    std::vector<std::uint32_t> vertices;
  };
  [[nodiscard]] double deepest_in_eyeballs(std::span<const Vec3f> v) const;
  [[nodiscard]] double deepest_in_teeth(std::span<const Vec3f> v, std::span<const std::uint32_t> who) const;
  [[nodiscard]] double deepest_lip(std::span<const Vec3f> v) const;
  [[nodiscard]] double deepest_lid(std::span<const Vec3f> v) const;
  /// Of each triangle of surface_.
  [[nodiscard]] std::vector<bool> inverted(std::span<const Vec3f> v) const;

  const face::Face& face_;
  std::array<Body, 2> eyeballs_;
  std::array<std::vector<std::uint32_t>, 2> about_eye_;  ///< Outer skin near each.
  std::vector<Body> teeth_;
  std::vector<std::uint32_t> about_mouth_, tongue_;
  std::array<std::vector<Triangle>, 2> lips_;           ///< Upper, lower; lining near them included.
  std::array<std::vector<std::uint32_t>, 2> lip_rows_;  ///< Their vertices.
  std::array<std::array<std::vector<std::uint32_t>, 2>, 2> margin_;  ///< Lids' by eye; upper, lower.
  std::vector<Triangle> surface_;
};

}  // namespace mien::builtin_face
