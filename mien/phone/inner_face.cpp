#include "mien/phone/inner_face.h"

#include <algorithm>

namespace mien::phone {

face::Provenance provenance_of(Origin origin) {
  switch (origin) {
    case Origin::measured:
      return face::Provenance::measured;
    case Origin::audio:
      return face::Provenance::audio;
    case Origin::held:
      return face::Provenance::held;
    case Origin::untold:
    case Origin::predicted:
      return face::Provenance::predicted;
  }
  return face::Provenance::predicted;
}

float confidence_of(float told, Origin origin) {
  if (origin == Origin::held) return 0;
  return told == kUntold ? kDefaultConfidence : told;
}

InnerFace inner_face(const ToldFace& face) {
  InnerFace inner;
  const auto weight = [&](std::size_t i) { return std::clamp(face.weights[i], 0.0F, 1.0F); };
  const face::ProfileMap* const map = map_of(face.set);
  for (std::size_t k = 0; k < face::kInnerCount; ++k) {
    if (map == nullptr) {
      if (face.weights[k] == kUntold) continue;
      inner.known[k] = true;
      inner.weights[k] = weight(k);
      inner.confidence[k] = confidence_of(face.confidence[k], face.origin);
      continue;
    }
    float all = 0, told = 0, sum = 0, confidence = 0;
    for (const face::ProfileTerm& term : map->inward[k]) {
      all += term.factor;
      if (face.weights[term.column] == kUntold) continue;
      told += term.factor;
      sum += term.factor * weight(term.column);
      confidence += term.factor * confidence_of(face.confidence[term.column], face.origin);
    }
    if (!(told > 0)) continue;
    inner.known[k] = true;
    inner.weights[k] = std::clamp(told == all ? sum : sum * (all / told), 0.0F, 1.0F);
    inner.confidence[k] = std::clamp(confidence / all, 0.0F, 1.0F);
  }
  return inner;
}

}  // namespace mien::phone
