// The main job from the command line: perform, look, solve, evaluate, export.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "mien/face/livelink_csv.h"
#include "mien/model/model_file.h"
#include "tests/app/program.h"
#include "tests/tracker/tiny_model.h"
#include "tests/virtual/three_sensors.h"

namespace mien::app::test::main_job_test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

/// A rig, a motion and a model in a folder.
class MainJob : public ::testing::Test {
 protected:
  void SetUp() override {
    write(folder_ / "rig.toml", virt::test::kRig);
    write(folder_ / "talking.csv",
          face::format_livelink_csv(face::livelink_from_motion(virt::test::talking(90, false))));
    ASSERT_TRUE(model::write_model(folder_ / "tiny.safetensors",
                                   tracker::test::tiny_model({"mentalis", "buccinator_L"})));
    ASSERT_TRUE(model::write_model(causal_, tracker::test::tiny_causal_model({"mentalis", "buccinator_L"})));
    ASSERT_TRUE(model::write_model(folder_ / "strangers.safetensors",
                                   tracker::test::tiny_model({"frontalis_L", "frontalis_R"})));
  }

  /// Runs to success; stdout is one JSON object and nothing else.
  static nlohmann::json json_of(std::vector<std::string> arguments) {
    arguments.emplace_back("--json");
    SCOPED_TRACE(joined(arguments));
    const Outcome done = run(arguments);
    EXPECT_EQ(done.status, 0) << done.err;
    const auto json = nlohmann::json::parse(done.out, nullptr, false);
    EXPECT_TRUE(json.is_object()) << done.out;
    return json;
  }
  std::vector<std::string> perform(const std::string& take) {
    return {"perform",
            "--motion",
            folder_ / "talking.csv",
            "--rig",
            folder_ / "rig.toml",
            "--devices",
            "lab",
            "--take",
            folder_ / take,
            "--seed",
            "3"};
  }

  Folder folder_;
  std::string model_ = folder_ / "tiny.safetensors", causal_ = folder_ / "causal.safetensors";
};

TEST_F(MainJob, GoesFromAMotionToFilesThatOthersOpen) {
  const std::string take = folder_ / "a.mien";
  const auto performed = json_of(perform("a.mien"));
  EXPECT_EQ(performed["take"], take);
  const int frames = performed["frames"];
  EXPECT_GT(frames, 90 + 180);
  EXPECT_EQ(performed["packets"], 2 * frames);

  const auto info = json_of({"take", "info", take});
  EXPECT_EQ(info["finished"], true);
  EXPECT_EQ(info["devices"], "lab");
  EXPECT_EQ(info["ticks"], frames);
  EXPECT_EQ(info["log"]["entries"], 2 * frames + 1) << "the calibration's command is first";
  // Times count from the take's begin, whatever the devices' clocks say.
  ASSERT_FALSE(info["events"].empty());
  for (const auto& event : info["events"]) {
    EXPECT_GE(event["begin_s"], -1.0);
    EXPECT_LE(event["end_s"], info["duration_s"].get<double>() + 1);
  }
  EXPECT_EQ(info["truth"]["evaluated"], 90);
  EXPECT_EQ(json_of({"take", "check", take})["sound"], true);

  const auto solved = json_of({"solve", take, "--model", model_});
  EXPECT_EQ(solved["frames"], frames);
  EXPECT_THAT(solved["hash"].get<std::string>(), ::testing::SizeIs(64));
  EXPECT_FALSE(solved["kernels"].get<std::string>().empty());
  EXPECT_EQ(json_of({"solve", take, "--model", model_})["hash"], solved["hash"]);
  EXPECT_NE(json_of({"solve", take, "--model", model_, "--steps", "3"})["hash"], solved["hash"]);

  const auto evaluated = json_of({"evaluate", take, "--model", model_, "--report", folder_ / "a.html"});
  EXPECT_EQ(evaluated["frames"], 90);
  EXPECT_EQ(evaluated["takes"], 1);
  EXPECT_EQ(evaluated["face"], "builtin");
  EXPECT_EQ(evaluated["adapted"], false);
  for (const auto& part : {evaluated["model"], evaluated["baselines"]["mean_pose"],
                           evaluated["baselines"]["hold_last"], evaluated["baselines"]["ridge"]}) {
    EXPECT_GT(part["mse"], 0.0);
    EXPECT_GT(part["pve_mm"]["mean"], 0.0);
    EXPECT_GT(part["lmk_mm"]["mean"], 0.0);
  }
  EXPECT_THAT(content(folder_ / "a.html"), HasSubstr("</html>"));

  // Shaped as a session would, and with each step left out.
  write(folder_ / "smooth.json", R"({"smoothing": 1})");
  const auto shaped = json_of({"solve", take, "--model", model_, "--shaping", folder_ / "smooth.json"});
  EXPECT_NE(shaped["hash"], solved["hash"]);
  const auto ablated =
      json_of({"evaluate", take, "--model", model_, "--shaping", folder_ / "smooth.json", "--ablate"});
  ASSERT_EQ(ablated["ablations"].size(), 11U);
  for (const auto& one : ablated["ablations"]) {
    if (one["without"] == "smoothing") {
      EXPECT_EQ(one["changed"], true);
      EXPECT_GT(one["metrics"]["jitter_ratio"], ablated["model"]["jitter_ratio"]);
    } else if (one["without"] == "recentring") {
      EXPECT_EQ(one["changed"], false) << "not asked for";
    } else if (one["without"] == "every step") {
      EXPECT_EQ(one["metrics"]["mse"], evaluated["model"]["mse"]) << "the tracker's own";
    }
  }

  // The capture as a CSV: as many frames as the take has ticks.
  json_of({"solve", take, "--model", model_, "--out", folder_ / "capture.csv"});
  const auto capture = face::parse_livelink_csv(content(folder_ / "capture.csv"), "capture.csv");
  ASSERT_TRUE(capture) << capture.error().message();
  EXPECT_EQ(face::motion_from_livelink(*capture, "capture").motion.frames.size(),
            static_cast<std::size_t>(frames));
  // The truth comes back as it was performed.
  json_of({"export", "--motion", take, "--out", folder_ / "truth.csv"});
  const auto truth = face::parse_livelink_csv(content(folder_ / "truth.csv"), "truth.csv");
  ASSERT_TRUE(truth) << truth.error().message();
  const face::Motion back = face::motion_from_livelink(*truth, "truth").motion;
  const face::Motion given = virt::test::talking(90, false);
  ASSERT_GE(back.frames.size(), given.frames.size());
  for (std::size_t f = 0; f < given.frames.size(); ++f)
    for (const std::size_t k :
         {face::shape("jawOpen"), face::shape("mouthSmile_L"), face::shape("browDown_R")})
      ASSERT_NEAR(back.frames[back.frames.size() - given.frames.size() + f].weights[k],
                  given.frames[f].weights[k], 2e-3)
          << f;
  json_of({"export", "--motion", folder_ / "talking.csv", "--out", folder_ / "talking.glb"});
  EXPECT_TRUE(content(folder_ / "talking.glb").starts_with("glTF"));
}

TEST_F(MainJob, WhatIsWrongInAMotionIsSaidWhereverItIsPerformed) {
  std::string motion = content(folder_ / "talking.csv");
  motion.replace(motion.find("JawOpen"), 7, "JawOpne");
  motion.resize(motion.size() - 30);
  write(folder_ / "talking.csv", motion);
  for (const auto& arguments :
       {perform("a.mien"), std::vector<std::string>{"export", "--motion", folder_ / "talking.csv", "--out",
                                                    folder_ / "b.csv"}}) {
    const Outcome done = run(arguments);
    EXPECT_EQ(done.status, 0) << done.err;
    for (const char* said : {"talking.csv: the blendshape jawOpen has no column and is taken as 0\n",
                             "talking.csv: the unknown column 'JawOpne' is left out\n",
                             "talking.csv: the last row, line 91, is cut short and left out\n"})
      EXPECT_THAT(done.err, HasSubstr(said));
  }
}

TEST_F(MainJob, PeopleReadItToo) {
  Outcome done = run(perform("a.mien"));
  EXPECT_EQ(done.status, 0) << done.err;
  EXPECT_THAT(done.out, HasSubstr("frames"));
  const std::string take = folder_ / "a.mien";
  done = run({"take", "info", take});
  EXPECT_EQ(done.status, 0) << done.err;
  EXPECT_THAT(done.out, HasSubstr("mentalis"));
  done = run({"solve", take, "--model", model_});
  EXPECT_EQ(done.status, 0) << done.err;
  EXPECT_THAT(done.out, HasSubstr("hash"));
  done = run({"evaluate", take, "--model", model_});
  EXPECT_EQ(done.status, 0) << done.err;
  for (const char* row : {"model", "ridge", "hold last", "mean pose"}) EXPECT_THAT(done.out, HasSubstr(row));
}

TEST_F(MainJob, ACausalModelIsAskedFrameByFrame) {
  json_of(perform("a.mien"));
  const std::string take = folder_ / "a.mien";
  const auto solved = json_of({"solve", take, "--model", causal_});
  EXPECT_EQ(json_of({"solve", take, "--model", causal_})["hash"], solved["hash"]);
  const auto evaluated = json_of({"evaluate", take, "--model", causal_, "--report", folder_ / "a.html"});
  EXPECT_TRUE(evaluated["steps"].is_null());
  EXPECT_GT(evaluated["model"]["mse"].get<double>(), 0);
  EXPECT_TRUE(evaluated["baselines"]["ridge"].is_object());
  EXPECT_THAT(content(folder_ / "a.html"), HasSubstr("frame by frame"));
  EXPECT_FALSE(evaluated.contains("wears"));
  const auto performed_anew = json_of({"evaluate", take, "--model", causal_, "--wears", "3"});
  EXPECT_EQ(performed_anew["model"], evaluated["model"]) << "the take itself is measured as without";
  EXPECT_EQ(performed_anew["wears"]["count"], 3);
  const double once = evaluated["model"]["mse"];
  EXPECT_NEAR(performed_anew["wears"]["mse"]["mean"], once, 0.01 * once)
      << "in lab sensors sit where they belong";
  const Outcome stepped = run({"solve", take, "--model", causal_, "--steps", "3"});
  EXPECT_EQ(stepped.status, 2);
  EXPECT_THAT(stepped.err, HasSubstr("without denoising steps"));
}

TEST_F(MainJob, TheLiveModelStandsWithTheProgram) {
  json_of({"perform", "--motion", folder_ / "talking.csv", "--devices", "lab", "--take", folder_ / "a.mien"});
  const std::string take = folder_ / "a.mien";
  const auto evaluated = json_of({"evaluate", take});
  // Made blinks are measured beside the answer, and never in it.
  write(folder_ / "blinks.json", R"({"blinks_per_min": 60})");
  const auto blinking = json_of({"evaluate", take, "--shaping", folder_ / "blinks.json", "--blink"});
  EXPECT_EQ(blinking["model"], evaluated["model"]);
  EXPECT_GT(blinking["blinking"]["shut"], blinking["model"]["shut"]);
  EXPECT_FALSE(evaluated.contains("blinking"));
  EXPECT_THAT(run({"evaluate", take, "--blink"}).out, HasSubstr("with blinks"));
  EXPECT_THAT(evaluated["model_file"].get<std::string>(), ::testing::EndsWith("models/live.safetensors"));
  EXPECT_TRUE(evaluated["steps"].is_null());
  // It was trained for this rig, so it beats not looking.
  EXPECT_LT(evaluated["model"]["mse"].get<double>(),
            evaluated["baselines"]["mean_pose"]["mse"].get<double>());
  // What is measured is what the model file's table of confidence says of this rig, on every frame.
  EXPECT_EQ(evaluated["provenance"]["jawOpen"], (nlohmann::json{{"measured", 1.0}}));
  for (const char* shape : {"eyeBlink_L", "jawLeft", "mouthFunnel", "eyeLookUp_L"})
    EXPECT_EQ(evaluated["provenance"][shape], (nlohmann::json{{"predicted", 1.0}})) << shape;
  // Who prompted nothing hears nothing of it.
  EXPECT_THAT(run({"evaluate", take, take}).err, Not(HasSubstr("learnt")));
  const auto solved = json_of({"solve", take});
  EXPECT_THAT(solved["model"].get<std::string>(), ::testing::EndsWith("models/live.safetensors"));
  EXPECT_EQ(json_of({"solve", take})["hash"], solved["hash"]);
}

TEST_F(MainJob, EvaluateLearnsTheWearerOrSaysWhyNot) {
  // On the standard skin: what is learnt is about as good, and by this seed a little worse.
  json_of({"perform", "--motion", folder_ / "talking.csv", "--devices", "lab", "--prologue", "full", "--seed",
           "2", "--take", folder_ / "a.mien"});
  const Outcome done = run({"evaluate", folder_ / "a.mien", "--json"});
  ASSERT_EQ(done.status, 0) << done.err;
  const bool adapted = nlohmann::json::parse(done.out)["adapted"];
  const auto said =
      HasSubstr("the wearer was not learnt: what was learnt foretells prompts that were held out no better");
  if (adapted) {
    EXPECT_THAT(done.err, Not(HasSubstr("not learnt")));
  } else {
    EXPECT_THAT(done.err, said);
  }
}

TEST_F(MainJob, ReplacesATakeOnlyWhenToldTo) {
  EXPECT_EQ(run(perform("a.mien")).status, 0);
  const std::string before = content(folder_ / "a.mien");
  Outcome again = run(perform("a.mien"));
  EXPECT_EQ(again.status, 2);
  EXPECT_EQ(content(folder_ / "a.mien"), before);
  std::vector<std::string> forced = perform("a.mien");
  forced.emplace_back("--force");
  EXPECT_EQ(run(forced).status, 0);
}

TEST_F(MainJob, RefusesModelsAndTakesThatDoNotBelongTogether) {
  ASSERT_EQ(run(perform("a.mien")).status, 0);
  const auto before = folder_.files();
  Outcome refused = run({"solve", folder_ / "a.mien", "--model", folder_ / "strangers.safetensors", "--out",
                         folder_ / "new.csv"});
  EXPECT_EQ(refused.status, 2);
  EXPECT_THAT(refused.err, HasSubstr("none of the model's sensors"));
  EXPECT_EQ(std::ranges::count(refused.err, '\n'), 1) << refused.err;
  refused = run({"evaluate", folder_ / "a.mien", "--model", model_, "--face", "nobody", "--report",
                 folder_ / "new.html"});
  EXPECT_EQ(refused.status, 2);
  EXPECT_THAT(refused.err, HasSubstr("nobody"));
  refused = run({"export", "--motion", folder_ / "a.mien", "--out", folder_ / "new.txt"});
  EXPECT_EQ(refused.status, 2);
  EXPECT_THAT(refused.err, HasSubstr("new.txt"));
  EXPECT_EQ(folder_.files(), before);
}

TEST_F(MainJob, APathOfAnyBytesIsNoDefect) {
  const auto performed = json_of(perform("caf\xE9.mien"));
  EXPECT_THAT(performed["take"].get<std::string>(), HasSubstr("caf"));
  EXPECT_TRUE(std::filesystem::exists(folder_ / "caf\xE9.mien"));
}

}  // namespace
}  // namespace mien::app::test::main_job_test
