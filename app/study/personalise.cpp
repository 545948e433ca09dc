#include <fmt/format.h>

#include <memory>

#include "app/command.h"
#include "app/json_output.h"
#include "mien/modalities/modalities.h"
#include "mien/model/model_file.h"
#include "mien/study/prompted.h"
#include "mien/study/solve.h"
#include "mien/take/take.h"

namespace mien::app {
namespace {

struct PersonaliseOptions {
  std::string take, model, out;
  bool force = false;
  bool json = false;
};

Result<void> run_personalise(PersonaliseOptions options) {
  MIEN_TRY(check_output(options.out, {".safetensors"}));
  if (!options.force && std::filesystem::exists(options.out))
    return fail(ErrorCode::bad_usage, "it exists already", options.out, "use --force to replace it");
  MIEN_TRY_ASSIGN(const take::Take take, take::Take::open(options.take));
  if (!modalities::has_window_models(take.rig()))
    return fail(ErrorCode::unsupported,
                "its sensors do not sit on the skin, and how skin turns is what is learnt", options.take,
                "glasses learn their wearer from a calibration (docs/guide/eyewear.md)");
  MIEN_TRY_ASSIGN(options.model, path_or(options.model, "models/live.safetensors"));
  MIEN_TRY_ASSIGN(model::ModelFile file, model::read_model(options.model));
  MIEN_TRY_ASSIGN(const std::vector<model::FeatureFrame> features, study::take_features(take));
  auto made = study::personalise_on(take, features, file);
  if (!made) {
    made.error().where = options.take;
    return std::unexpected(std::move(made).error());
  }
  const tracker::Personalisation& learnt = *made;
  if (!learnt.taken)
    return fail(
        ErrorCode::not_found,
        fmt::format("what was learnt foretells prompts that were held out no better than the standard skin "
                    "does (surprise {:.3f}, without it {:.3f}), so nothing was written",
                    learnt.surprise_after, learnt.surprise_before),
        options.take, "check the sensors and record the prompts again; without it use " + options.model);
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
      commands.add("personalise", "Learns how one wearer's skin moves from a minute of prompted expressions",
                   "mien personalise minute.mien --out me.safetensors && mien live --model me.safetensors",
                   [options] { return run_personalise(*options); });
  command.add_option("take", options->take, "A take with a full prologue or prompts").required();
  command.add_option("--out", options->out, "The wearer's own model, .safetensors").required();
  command.add_option(
      "--model", options->model,
      "The model to begin with (default: models/live.safetensors); a wearer's skin in it is not built upon");
  command.add_flag("--force", options->force, "Replace an existing model");
  command.add_flag("--json", options->json, "Print one JSON object");
}

}  // namespace mien::app
