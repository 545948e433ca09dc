#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/rotation.h"
#include "mien/render/image.h"

namespace mien::lab {

/// A sensor on a picture: a white dot with its number.
struct PlacementDot {
  Vec3 position_m = Vec3::Zero();  ///< Built-in head, frame H.
  std::size_t number = 1;
};

/// What one more sensor would tell at each place, and who is there already.
struct PlacementField {
  std::string title;         ///< Printable ASCII.
  std::vector<double> told;  ///< Share beside the places, 0 to 1.
  std::vector<PlacementDot> dots;
};

/// What a sensor at each place tells most of.
struct PlacementGroups {
  std::vector<std::size_t> group;  ///< In kShapeGroups, beside the places.
  std::vector<double> strength;    ///< 0 (pale) to 1.
};

/// The pictures of `mien study placement`. Places where no candidate is near (lids, lips, hair) keep pale.
struct PlacementPictures {
  render::Image alone;                           ///< The first field, from the front and at three quarters.
  render::Image groups;                          ///< The same of what is told most, in five colours.
  render::Image sets;                            ///< The other fields, four in a row, each to its own scale.
  [[nodiscard]] render::Image together() const;  ///< One below the other.
};

struct PlacementPictureRequest {
  int height_px = 640;       ///< Of the large pictures.
  double spacing_m = 0.008;  ///< Of the places: how far each reaches.
};

/// `places_m`: on the built-in head, frame H. `fields`: at least one. Errors: those of
/// render::Lettering::load(). Cost: about ten seconds.
[[nodiscard]] Result<PlacementPictures> placement_pictures(const std::vector<Vec3>& places_m,
                                                           const std::vector<PlacementField>& fields,
                                                           const PlacementGroups& groups,
                                                           const PlacementPictureRequest& request);

}  // namespace mien::lab
