#include "app/study/studied_model.h"

#include <fmt/format.h>

#include <utility>
#include <vector>

#include "app/command.h"
#include "mien/builtin_face/builtin_face.h"
#include "mien/model/model_file.h"
#include "mien/sensor/rig.h"
#include "mien/study/imu/watched_person.h"

namespace mien::app {
namespace {

std::string virtual_people_are(int people) {
  return fmt::format("{} virtual people", people);
}

class ImuModel final : public StudiedModel {
 public:
  ImuModel(model::ModelFile model, sensor::Rig rig) : model_(std::move(model)), rig_(std::move(rig)) {}
  [[nodiscard]] const std::optional<model::ConfidenceTable>& table() const override {
    return model_.confidence;
  }
  void use(model::ConfidenceTable table) override { model_.confidence = std::move(table); }
  [[nodiscard]] Result<void> write(const std::string& path) const override {
    return model::write_model(path, model_);
  }
  [[nodiscard]] std::string rig_name() const override { return rig_.name; }
  [[nodiscard]] Result<study::WatchedGroup> virtual_people(int people, double seconds, std::uint64_t seed,
                                                           const std::string& title) const override {
    MIEN_TRY_ASSIGN(std::vector<study::ImuPerson> all,
                    study::watch_virtual(people, seconds, seed, rig_, terminal_progress(title), 0));
    return group(virtual_people_are(people), std::move(all));
  }
  [[nodiscard]] Result<study::WatchedGroup> recorded(std::string who, const face::Motion& motion,
                                                     const Random& random) const override {
    MIEN_TRY_ASSIGN(study::ImuPerson person,
                    study::watch_recorded(motion, builtin_face::make_builtin(), rig_, random));
    std::vector<study::ImuPerson> one;
    one.push_back(std::move(person));
    return group(std::move(who), std::move(one));
  }

 private:
  [[nodiscard]] study::WatchedGroup group(std::string who, std::vector<study::ImuPerson> people) const {
    return study::watched_by(model_, rig_.face_sensor_names(), std::move(who), std::move(people));
  }

  model::ModelFile model_;
  sensor::Rig rig_;
};

}  // namespace

Result<std::unique_ptr<StudiedModel>> read_studied_model(const std::string& model, const std::string& rig) {
  MIEN_TRY_ASSIGN(model::ModelFile file, model::read_model(model));
  MIEN_TRY_ASSIGN(const std::filesystem::path rig_file, path_or(rig, "rigs/default.toml"));
  MIEN_TRY_ASSIGN(sensor::Rig read, sensor::read_rig(rig_file));
  return std::make_unique<ImuModel>(std::move(file), std::move(read));
}

}  // namespace mien::app
