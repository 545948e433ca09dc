#include "mien/face/morph_targets.h"

#include <algorithm>
#include <map>
#include <string_view>
#include <utility>

#include "mien/core/smoothstep.h"
#include "mien/core/toml.h"
#include "mien/face/profile_map.h"
#include "mien/face/target_names.h"

namespace mien::face {

extern const std::string_view kUnifiedTargetsToml;  // unified_targets.toml.

namespace {

enum class Side : std::uint8_t { both, left, right };
enum class Lip : std::uint8_t { both, upper, lower };

/// A target of Unified Expressions: a share of a portion of one shape.
struct Portion {
  std::string name;
  std::size_t shape;  ///< As in Face::shapes.
  float share;
  Side side;
  Lip lip;
};

Portion read_portion(const toml::table& row) {
  const auto word = [&row](std::string_view key) { return row[key].value_or(std::string_view()); };
  Portion portion{.name = std::string(word("name")),
                  .shape = inner_index(word("shape")),
                  .share = static_cast<float>(row["share"].value_or(1.0)),
                  .side = word("side") == "left"    ? Side::left
                          : word("side") == "right" ? Side::right
                                                    : Side::both,
                  .lip = word("lip") == "upper"   ? Lip::upper
                         : word("lip") == "lower" ? Lip::lower
                                                  : Lip::both};
  if (row.contains("shape")) return portion;
  const auto at = std::ranges::find(kUnifiedNames, portion.name) - kUnifiedNames.begin();
  portion.shape = profile_map(OutsideProfile::unified).outward[static_cast<std::size_t>(at)].front().column;
  return portion;
}

/// In their order. Of a file that the tests hold to be sound.
const std::vector<Portion>& unified_portions() {
  static const std::vector<Portion> all = [] {
    const toml::table file = parse_toml(kUnifiedTargetsToml, "unified_targets.toml").value();
    std::vector<Portion> portions;
    for (const toml::node& row : *file["target"].as_array())
      portions.push_back(read_portion(*row.as_table()));
    return portions;
  }();
  return all;
}

constexpr float kMidlineHalfWidth_m = 0.008F;
/// Displacement by jawOpen, of its largest, from which skin begins to be the lower lip's, and is it wholly.
constexpr float kLowerFrom = 0.15F, kLowerTo = 0.5F;

/// Which share of a vertex is left, and which the lower lip's.
class Portions {
 public:
  explicit Portions(const Face& face) : face_(face), lower_(face.neutral_m.size(), 0) {
    if (face.eyes[0].vertex_count > 0 && face.eyes[1].vertex_count > 0)
      middle_x_m_ = 0.5F * (face.eyes[0].centre_m.x() + face.eyes[1].centre_m.x());
    const Shape* const jaw = face.find_shape("jawOpen");
    if (jaw == nullptr) return;
    float largest = 0;
    for (const Vec3f& delta : jaw->delta_m) largest = std::max(largest, delta.norm());
    if (!(largest > 0)) return;
    for (std::size_t i = 0; i < jaw->vertex.size(); ++i)
      lower_[jaw->vertex[i]] = smoothstep(kLowerFrom, kLowerTo, jaw->delta_m[i].norm() / largest);
  }
  [[nodiscard]] float of(const Portion& portion, std::uint32_t vertex) const {
    const float left = smoothstep(middle_x_m_ - kMidlineHalfWidth_m, middle_x_m_ + kMidlineHalfWidth_m,
                                  face_.neutral_m[vertex].x());
    const float lower = lower_[vertex];
    return portion.share *
           (portion.side == Side::both   ? 1
            : portion.side == Side::left ? left
                                         : 1 - left) *
           (portion.lip == Lip::both    ? 1
            : portion.lip == Lip::lower ? lower
                                        : 1 - lower);
  }

 private:
  const Face& face_;
  float middle_x_m_ = 0;  // Between the eyes, where they are known.
  std::vector<float> lower_;
};

/// None where the face lacks it.
const Shape* shape_at(const Face& face, std::size_t k) {
  return k < face.shapes.size() ? &face.shapes[k] : nullptr;
}

void add(MorphTarget& target, const Shape& shape) {
  if (target.vertex.empty()) {
    target.vertex = shape.vertex;
    target.delta_m = shape.delta_m;
    return;
  }
  std::map<std::uint32_t, Vec3f> moved;
  for (std::size_t i = 0; i < target.vertex.size(); ++i) moved.emplace(target.vertex[i], target.delta_m[i]);
  for (std::size_t i = 0; i < shape.vertex.size(); ++i) {
    const auto [at, is_new] = moved.try_emplace(shape.vertex[i], shape.delta_m[i]);
    if (!is_new) at->second += shape.delta_m[i];
  }
  target.vertex.clear();
  target.delta_m.clear();
  for (const auto& [vertex, delta] : moved) {
    target.vertex.push_back(vertex);
    target.delta_m.push_back(delta);
  }
}

MorphTarget sum_of(const Face& face, std::string name, std::vector<std::size_t> shapes) {
  MorphTarget out{.name = std::move(name), .shapes = std::move(shapes), .vertex = {}, .delta_m = {}};
  for (const std::size_t k : out.shapes)
    if (const Shape* const shape = shape_at(face, k)) add(out, *shape);
  return out;
}

std::vector<MorphTarget> arkit_targets(const Face& face) {
  std::vector<MorphTarget> out;
  for (const std::string& name : arkit52().shapes) out.push_back(sum_of(face, name, shapes_of_name(name)));
  return out;
}

std::vector<MorphTarget> unified_targets(const Face& face) {
  const Portions portions(face);
  std::vector<MorphTarget> out;
  for (const Portion& portion : unified_portions()) {
    MorphTarget& target = out.emplace_back();
    target.name = portion.name;
    target.shapes = {portion.shape};
    const Shape* const shape = shape_at(face, portion.shape);
    if (shape == nullptr) continue;
    for (std::size_t i = 0; i < shape->vertex.size(); ++i) {
      const float share = portions.of(portion, shape->vertex[i]);
      if (share <= 0) continue;
      target.vertex.push_back(shape->vertex[i]);
      target.delta_m.push_back(share * shape->delta_m[i]);
    }
  }
  return out;
}

}  // namespace

std::vector<MorphTarget> morph_targets(const Face& face, TargetNames names) {
  switch (names) {
    case TargetNames::arkit:
      return arkit_targets(face);
    case TargetNames::unified:
      return unified_targets(face);
    case TargetNames::ict:
      break;
  }
  std::vector<MorphTarget> out;
  for (std::size_t k = 0; k < face.shapes.size(); ++k) out.push_back(sum_of(face, face.shapes[k].name, {k}));
  return out;
}

float weight_of(const MorphTarget& target, const BlendshapeWeights& weights, float tongue_out) {
  float sum = 0;
  for (const std::size_t k : target.shapes) sum += k < kShapeCount ? weights[k] : tongue_out;
  return sum / static_cast<float>(target.shapes.size());
}

}  // namespace mien::face
