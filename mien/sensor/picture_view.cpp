#include "mien/sensor/picture_view.h"

namespace mien::sensor {

PictureView view_of(const CameraMount& camera) {
  return {.crop = camera.crop, .turn_deg = camera.turn_deg, .mirror = camera.mirror};
}

void set_view(CameraMount& camera, const PictureView& view) {
  camera.crop = view.crop;
  camera.turn_deg = view.turn_deg;
  camera.mirror = view.mirror;
}

Result<void> check_crop(const std::array<double, 4>& crop, const std::string& where) {
  const auto& [left, top, width, height] = crop;
  // So written that what is no number fails too.
  if (left >= 0 && top >= 0 && width >= kLeastCrop && height >= kLeastCrop && left + width <= 1 &&
      top + height <= 1)
    return {};
  return fail(ErrorCode::out_of_range, "'crop' leaves the picture, or too little of it", where,
              "give left, top, width and height as shares of the picture");
}

Result<void> check_turn(std::int64_t turn_deg, const std::string& where) {
  if (turn_deg >= 0 && turn_deg <= 270 && turn_deg % 90 == 0) return {};
  return fail(ErrorCode::out_of_range, "'turn_deg' is not 0, 90, 180 or 270", where);
}

Result<PictureView> changed_view(PictureView view, const PictureViewChange& change,
                                 const std::string& where) {
  view.crop = change.crop.value_or(view.crop);
  view.turn_deg = change.turn_deg.value_or(view.turn_deg);
  view.mirror = change.mirror.value_or(view.mirror);
  MIEN_TRY(check_crop(view.crop, where));
  MIEN_TRY(check_turn(view.turn_deg, where));
  return view;
}

}  // namespace mien::sensor
