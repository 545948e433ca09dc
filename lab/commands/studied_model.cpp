#include "lab/commands/studied_model.h"

#include <fmt/format.h>

#include <utility>
#include <vector>

#include "app/command.h"
#include "lab/eyewear/faulty_wearer.h"
#include "lab/eyewear/watched_wearer.h"
#include "lab/imu/faulty_person.h"
#include "mien/builtin_face/builtin_face.h"
#include "mien/core/files.h"
#include "mien/eyewear/light_grid.h"
#include "mien/model/model_file.h"
#include "mien/sensor/rig.h"
#include "mien/synthetic/imu/watched_person.h"

namespace mien::lab {
namespace {

std::string virtual_people_are(int people) {
  return fmt::format("{} virtual people", people);
}

/// `shifted`: every second one is unlike those of training.
std::string faulty_people_are(int people, bool shifted) {
  return shifted ? fmt::format("{} of both kinds", people) : virtual_people_are(people);
}
std::string shifted_people_are(int people) {
  return fmt::format("{} of other kinds", people);
}

class StudiedImuModel final : public StudiedModel {
 public:
  StudiedImuModel(model::ModelFile model, sensor::Rig rig) : model_(std::move(model)), rig_(std::move(rig)) {}
  [[nodiscard]] const std::optional<model::ConfidenceTable>& table() const override {
    return model_.confidence;
  }
  void use(model::ConfidenceTable table) override { model_.confidence = std::move(table); }
  [[nodiscard]] Result<void> write(const std::string& path) const override {
    return model::write_model(path, model_);
  }
  [[nodiscard]] std::string rig_name() const override { return rig_.name; }
  [[nodiscard]] Result<synthetic::WatchedGroup> virtual_people(int people, double seconds, std::uint64_t seed,
                                                               const std::string& title) const override {
    MIEN_TRY_ASSIGN(std::vector<synthetic::ImuPerson> all,
                    synthetic::watch_virtual(people, seconds, seed, rig_, app::terminal_progress(title), 0));
    return group(virtual_people_are(people), std::move(all));
  }
  [[nodiscard]] Result<synthetic::WatchedGroup> shifted_people(int people, double seconds, std::uint64_t seed,
                                                               const std::string& title) const override {
    MIEN_TRY_ASSIGN(std::vector<synthetic::ImuPerson> all,
                    synthetic::watch_shifted(people, seconds, seed, rig_, app::terminal_progress(title), 0));
    return group(shifted_people_are(people), std::move(all));
  }
  [[nodiscard]] Result<synthetic::WatchedGroup> recorded(std::string who, const face::Motion& motion,
                                                         const Random& random) const override {
    MIEN_TRY_ASSIGN(synthetic::ImuPerson person,
                    synthetic::watch_recorded(motion, builtin_face::make_builtin(), rig_, random));
    std::vector<synthetic::ImuPerson> one;
    one.push_back(std::move(person));
    return group(std::move(who), std::move(one));
  }
  [[nodiscard]] Result<synthetic::FaultyGroup> faulty_people(int people, double seconds, bool shifted,
                                                             std::uint64_t seed) const override {
    return lab::faulty_people(model_, rig_, faulty_people_are(people, shifted), people, seconds, shifted,
                              seed);
  }

 private:
  [[nodiscard]] synthetic::WatchedGroup group(std::string who,
                                              std::vector<synthetic::ImuPerson> people) const {
    return synthetic::watched_by(model_, rig_.face_sensor_names(), std::move(who), std::move(people));
  }

  model::ModelFile model_;
  sensor::Rig rig_;
};

class StudiedEyewearModel final : public StudiedModel {
 public:
  StudiedEyewearModel(eyewear::MarkerNetworkFile model, eyewear::MarkedFace marked, sensor::Rig rig)
      : model_(std::move(model)), marked_(std::move(marked)), rig_(std::move(rig)) {}
  [[nodiscard]] const std::optional<model::ConfidenceTable>& table() const override {
    return model_.confidence;
  }
  void use(model::ConfidenceTable table) override { model_.confidence = std::move(table); }
  [[nodiscard]] Result<void> write(const std::string& path) const override {
    return eyewear::write_marker_network(path, model_);
  }
  [[nodiscard]] std::string rig_name() const override { return rig_.name; }
  [[nodiscard]] Result<synthetic::WatchedGroup> virtual_people(int people, double seconds, std::uint64_t seed,
                                                               const std::string& title) const override {
    MIEN_TRY_ASSIGN(std::vector<LightPerson> all,
                    watch_wearers(people, seconds, seed, rig_, app::terminal_progress(title), 0));
    return group(virtual_people_are(people), std::move(all));
  }
  [[nodiscard]] Result<synthetic::WatchedGroup> shifted_people(int people, double seconds, std::uint64_t seed,
                                                               const std::string& title) const override {
    MIEN_TRY_ASSIGN(std::vector<LightPerson> all,
                    watch_shifted_wearers(people, seconds, seed, rig_, app::terminal_progress(title), 0));
    return group(shifted_people_are(people), std::move(all));
  }
  [[nodiscard]] Result<synthetic::WatchedGroup> recorded(std::string who, const face::Motion& motion,
                                                         const Random& random) const override {
    MIEN_TRY_ASSIGN(LightPerson person, watch_wearer(motion, builtin_face::make_builtin(), rig_, random));
    std::vector<LightPerson> one;
    one.push_back(std::move(person));
    return group(std::move(who), std::move(one));
  }
  [[nodiscard]] Result<synthetic::FaultyGroup> faulty_people(int people, double seconds, bool shifted,
                                                             std::uint64_t seed) const override {
    return faulty_wearers(model_, marked_, rig_, faulty_people_are(people, shifted), people, seconds, shifted,
                          seed);
  }

 private:
  [[nodiscard]] Result<synthetic::WatchedGroup> group(std::string who,
                                                      std::vector<LightPerson> people) const {
    return lab::watched_by(model_, marked_, eyewear::photo_sensor_names(rig_), std::move(who),
                           std::move(people));
  }

  eyewear::MarkerNetworkFile model_;
  eyewear::MarkedFace marked_;
  sensor::Rig rig_;
};

Result<std::unique_ptr<StudiedModel>> eyewear_model(eyewear::MarkerNetworkFile file, const std::string& rig) {
  MIEN_TRY_ASSIGN(const std::filesystem::path rig_file, app::path_or(rig, "rigs/eyewear.toml"));
  MIEN_TRY_ASSIGN(sensor::Rig read, sensor::read_rig(rig_file));
  MIEN_TRY_ASSIGN(const std::filesystem::path markers, find_resource("rigs/markers.toml"));
  MIEN_TRY_ASSIGN(const builtin_face::MarkerSet set, builtin_face::read_markers(markers));
  MIEN_TRY_ASSIGN(eyewear::MarkedFace marked, eyewear::MarkedFace::of(file, set));
  return std::make_unique<StudiedEyewearModel>(std::move(file), std::move(marked), std::move(read));
}

}  // namespace

Result<std::unique_ptr<StudiedModel>> read_studied_model(const std::string& model, const std::string& rig) {
  auto file = model::read_model(model);
  // Each format refuses the other's by its name; what is wrong with one of its own files is its to say.
  if (!file && file.error().code == ErrorCode::unsupported) {
    auto markers = eyewear::read_marker_network(model);
    if (markers) return eyewear_model(*std::move(markers), rig);
    return std::unexpected(markers.error().code == ErrorCode::unsupported ? file.error() : markers.error());
  }
  if (!file) return std::unexpected(file.error());
  MIEN_TRY_ASSIGN(const std::filesystem::path rig_file, app::path_or(rig, "rigs/default.toml"));
  MIEN_TRY_ASSIGN(sensor::Rig read, sensor::read_rig(rig_file));
  return std::make_unique<StudiedImuModel>(*std::move(file), std::move(read));
}

}  // namespace mien::lab
