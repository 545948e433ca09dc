// What goes through what when the built-in face moves.
#include "tests/builtin_face/contact.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "mien/builtin_face/builtin_face.h"
#include "mien/builtin_face/correctives.h"
#include "mien/core/random.h"
#include "mien/performer/performer.h"

namespace mien::builtin_face::contact_test {
namespace {

constexpr double kTouch_mm = 0.3;  ///< Deeper is through.

class Face {
 public:
  Contacts contacts(const face::BlendshapeWeights& weights, float tongue_out = 0, bool corrected = false) {
    face::evaluate(face_, weights, tongue_out, vertices_m_);
    if (corrected) face::add_correctives(correctives_, weights, vertices_m_);
    face::turn_eyes(face_, weights, vertices_m_);
    return finder_.find(vertices_m_);
  }

 private:
  face::Face face_ = make_builtin();
  std::vector<face::Corrective> correctives_ = make_correctives(face_, {});
  ContactFinder finder_{face_};
  std::vector<Vec3f> vertices_m_ = face_.neutral_m;
};

TEST(Contact, NothingGoesThroughAnythingInAnyShapeAlone) {
  Face face;
  const auto expect_none = [&](const Contacts& contacts, std::string_view where) {
    for (std::size_t k = 0; k < kContactCount; ++k) {
      const auto kind = static_cast<Contact>(k);
      EXPECT_LE(contacts[k], kind == Contact::inverted ? 0 : kTouch_mm)
          << contact_name(kind) << ", " << where;
    }
  };
  for (std::size_t k = 0; k < face::kShapeCount; ++k) {
    face::BlendshapeWeights weights;
    weights[k] = 1;
    // mouthClose is the answer to a dropped jaw: nobody closes lips without one.
    if (face::kShapeNames[k] == "mouthClose") weights[face::shape("jawOpen")] = 1;
    expect_none(face.contacts(weights), face::kShapeNames[k]);
    expect_none(face.contacts(weights, 0, true), face::kShapeNames[k]);
  }
  expect_none(face.contacts({}, 1), "tongueOut");
  expect_none(face.contacts({}), "neutral");
}

/// Shapes add up, and what each keeps clear of may still meet: the most of 2,000 frames (mm; triangles), and
/// in how many of them it is more than kTouch_mm. Another compiler's program draws other performers.
/// docs/experiments/builtin_face.md has the figures.
struct Bound {
  double most;
  int frames;
};

void expect_little_in_performances(const Bound (&bounds)[kContactCount], bool corrected) {
  constexpr int kPeople = 40, kFrames = 50;
  Face face;
  Contacts most{};
  std::array<int, kContactCount> frames{};
  for (int i = 0; i < kPeople; ++i) {
    Random random(static_cast<std::uint64_t>(100 + i));
    const performer::Style style = performer::draw_style(random);
    const face::Motion motion = performer::perform(
        performer::default_script(performer::Block::mixed, kFrames), style, random.fork("m"));
    for (int f = 0; f < kFrames; ++f) {
      const auto& weights = motion.frames[static_cast<std::size_t>(60 * f + i)].weights;
      const Contacts now = face.contacts(weights, 0, corrected);
      for (std::size_t k = 0; k < kContactCount; ++k) {
        most[k] = std::max(most[k], now[k]);
        frames[k] += now[k] > kTouch_mm ? 1 : 0;
      }
    }
  }
  for (std::size_t k = 0; k < kContactCount; ++k) {
    const std::string_view name = contact_name(static_cast<Contact>(k));
    EXPECT_LE(most[k], bounds[k].most) << name;
    EXPECT_LE(frames[k], bounds[k].frames) << name;
  }
}

TEST(Contact, LittleGoesThroughInWhatVirtualPerformersDo) {
  constexpr Bound kBounds[] = {{0.5, 4}, {2.9, 30}, {0.3, 0}, {1.1, 10}, {7.6, 60}, {30, 100}};
  expect_little_in_performances(kBounds, false);
}

TEST(Contact, StillLessDoesWithCorrectives) {
  constexpr Bound kBounds[] = {{0.4, 2}, {2.1, 14}, {0.3, 0}, {1.2, 10}, {0.1, 0}, {30, 100}};
  expect_little_in_performances(kBounds, true);
}

}  // namespace
}  // namespace mien::builtin_face::contact_test
