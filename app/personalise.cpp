#include <fmt/format.h>

#include <memory>
#include <utility>
#include <vector>

#include "app/command.h"
#include "app/json_output.h"
#include "app/phone_option.h"
#include "mien/builtin_face/load_face.h"
#include "mien/core/time.h"
#include "mien/model/model_file.h"
#include "mien/sensor/rig_part.h"
#include "mien/solve/phone_truth.h"
#include "mien/solve/prompted.h"
#include "mien/solve/solve.h"
#include "mien/solve/trace_features.h"
#include "mien/take/take.h"

namespace mien::app {
namespace {

/// Shorter takes made some virtual strangers worse (docs/experiments/phone_truth.md), s.
constexpr double kSafe_s = 60;

struct PersonaliseOptions {
  std::string take, model, out;
  PhoneOption phone;  // Not given: prompts.
  bool force = false;
  bool json = false;
};

/// From what a phone told.
Result<void> learn_by_phone(const PersonaliseOptions& options, const take::Take& take,
                            const std::vector<model::FeatureFrame>& features, model::ModelFile file) {
  MIEN_TRY_ASSIGN(const solve::PhoneTrack track, options.phone.open(take, features));
  MIEN_TRY_ASSIGN(const face::Face face, builtin_face::load_face(take.header().face));
  auto made = solve::learn_from_phone(take, features, track, face, file, terminal_progress("personalise"));
  if (!made) {
    made.error().where = options.take;
    return std::unexpected(std::move(made).error());
  }
  const tracker::LearntCorrection& learnt = made->learnt;
  if (!learnt.taken)
    return fail(ErrorCode::not_found,
                fmt::format("what was learnt is no better where it was held out (squared error {:.4f}, "
                            "without it {:.4f}), so nothing was written",
                            learnt.mse_after, learnt.mse_before),
                options.take,
                "record two minutes of speech and expressions; without it use " + options.model);
  MIEN_TRY(model::write_model(options.out, file));
  const double seconds = static_cast<double>(learnt.frames) / kFrameRateHz;
  if (options.json)
    print_json({{"take", options.take},
                {"model", options.model},
                {"out", options.out},
                {"truth", options.phone.truth()},
                {"seconds", seconds},
                {"shapes", learnt.shapes},
                {"mse_before", learnt.mse_before},
                {"mse_after", learnt.mse_after},
                {"skin_before_mm", learnt.skin_before_mm},
                {"skin_after_mm", learnt.skin_after_mm},
                {"agreement", made->alignment.agreement},
                {"offset_ms", 1e3 * made->alignment.offset_s},
                {"offset_sigma_ms", 1e3 * made->alignment.offset_sigma_s}});
  else
    fmt::print(
        "{:.0f} s of truth, {:.1f} ms +- {:.1f} off, agreement {:.2f}\n"
        "{} of {} shapes are corrected; squared error where it was held out {:.4f}, before {:.4f}; of the "
        "skin {:.2f} mm, before {:.2f}\n"
        "wrote {}; use it with --model\n"
        "{}",
        seconds, 1e3 * made->alignment.offset_s, 1e3 * made->alignment.offset_sigma_s,
        made->alignment.agreement, learnt.shapes, face::kShapeCount, learnt.mse_after, learnt.mse_before,
        learnt.skin_after_mm, learnt.skin_before_mm, options.out,
        seconds < kSafe_s ? "That is a short take: what was held out is of the same mood as what was learnt, "
                            "and other moods may become worse; two minutes are safer.\n"
                          : "");
  return {};
}

Result<void> run_personalise(PersonaliseOptions options) {
  MIEN_TRY(check_output(options.out, {".safetensors"}));
  std::error_code ignored;
  if (!options.force && std::filesystem::exists(options.out, ignored))
    return fail(ErrorCode::bad_usage, "it exists already", options.out, "use --force to replace it");
  MIEN_TRY_ASSIGN(const take::Take take, take::Take::open(options.take));
  if (solve::traced_sensor_names(take.rig()).empty())
    return fail(ErrorCode::unsupported, "it has no sensors on the skin, and how skin turns is what is learnt",
                options.take, "glasses learn their wearer from a calibration (docs/guide/eyewear.md)");
  MIEN_TRY_ASSIGN(options.model, path_or(options.model, "models/live.safetensors"));
  MIEN_TRY_ASSIGN(model::ModelFile file, model::read_model(options.model));
  MIEN_TRY_ASSIGN(const std::vector<model::FeatureFrame> features, solve::take_features(take));
  if (options.phone.given()) return learn_by_phone(options, take, features, std::move(file));
  auto made = solve::personalise_on(take, features, file);
  if (!made) {
    made.error().where = options.take;
    if (made.error().code == ErrorCode::not_found && !sensor::truths_of(take.rig()).empty())
      made.error().fix = "a phone looked on: learn from it with --truth phone";
    return std::unexpected(std::move(made).error());
  }
  const tracker::Personalisation& learnt = *made;
  if (!learnt.taken)
    return fail(ErrorCode::not_found,
                fmt::format("what was learnt foretells prompts that were held out no better than the "
                            "standard skin does (surprise {:.3f}, without it {:.3f}), so nothing was written",
                            learnt.surprise_after, learnt.surprise_before),
                options.take,
                "check the sensors and record the prompts again; without it use " + options.model);
  MIEN_TRY(model::write_model(options.out, file));
  if (options.json)
    print_json({{"take", options.take},
                {"model", options.model},
                {"out", options.out},
                {"prompts", learnt.prompts},
                {"frames", learnt.frames},
                {"surprise_before", learnt.surprise_before},
                {"surprise_after", learnt.surprise_after}});
  else
    fmt::print(
        "{} prompts, {} frames; surprise at prompts that were held out {:.3f}, on the standard skin {:.3f}\n"
        "wrote {}; use it with --model\n",
        learnt.prompts, learnt.frames, learnt.surprise_after, learnt.surprise_before, options.out);
  return {};
}

}  // namespace

void add_personalise_command(Commands& commands) {
  auto options = std::make_shared<PersonaliseOptions>();
  const Command command =
      commands.add("personalise", "Learns one wearer, from a minute of prompts or from a phone",
                   "mien personalise minute.mien --out me.safetensors && mien live --model me.safetensors",
                   [options] { return run_personalise(*options); });
  command.add_option("take", options->take, "A take with a full prologue or prompts, or with a truth")
      .required();
  options->phone.add_to(command, "Learn what the answers lack");
  command.add_option("--out", options->out, "The wearer's own model, .safetensors").required();
  command.add_option("--model", options->model,
                     "The model to begin with (default: models/live.safetensors). Prompts do not build upon "
                     "a wearer's skin in it; a phone does");
  command.add_flag("--force", options->force, "Replace an existing model");
  add_json_flag(command, options->json);
}

}  // namespace mien::app
