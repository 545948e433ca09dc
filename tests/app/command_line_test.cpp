// What is typed wrong, and what asks for help: one clear line, and nothing left behind.
#include <gmock/gmock.h>

#include <algorithm>
#include <map>
#include <sstream>

#include "mien/model/model_file.h"
#include "tests/app/program.h"
#include "tests/project_path.h"
#include "tests/tracker/tiny_model.h"
#include "tests/virtual/three_sensors.h"

namespace mien::app::test::command_line_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::MatchesRegex;

TEST(Program, SaysItsVersion) {
  const Outcome version = run({"--version"});
  EXPECT_EQ(version.status, 0);
  EXPECT_THAT(version.out, MatchesRegex("mien [0-9]+\\.[0-9]+\\.[0-9]+\n"));
  EXPECT_EQ(version.err, "");
}

/// The commands that a help text lists: under one heading, or those of `mien` under four.
std::vector<std::string> commands_in(const std::string& help) {
  std::vector<std::string> commands;
  std::istringstream lines(
      help.substr(std::min(help.size(), std::min(help.find("Subcommands:"), help.find("Capture:")))));
  std::string line;
  while (std::getline(lines, line) && !line.starts_with("Example"))
    if (line.size() > 2 && line.starts_with("  ") && line[2] != ' ')
      commands.push_back(line.substr(2, line.find(' ', 2) - 2));
  return commands;
}

TEST(Program, ListsItsCommandsInFourGroupsALineEach) {
  std::istringstream lines(run({"--help"}).out);
  std::vector<std::string> headings;
  std::size_t commands = 0;
  for (std::string line; std::getline(lines, line);) {
    EXPECT_LE(line.size(), 80U) << line;
    if (line.ends_with(':') && line != "Options:") headings.push_back(line);
    if (!headings.empty() && line.starts_with("  ")) ++commands;
  }
  EXPECT_THAT(headings, ElementsAre("Capture:", "Takes and faces:", "Learn:", "Judge:"));
  EXPECT_EQ(commands, commands_in(run({"--help"}).out).size());
}

void expect_help(const std::vector<std::string>& command) {
  std::vector<std::string> arguments = command;
  arguments.emplace_back("--help");
  const Outcome help = run(arguments);
  SCOPED_TRACE(joined(arguments));
  const bool helped =
      command.size() == 1 && (command[0] == "train" || command[0] == "study" || command[0] == "bench");
  if (helped && help.status == 2) {
    // The helper answers; where it was not built, that is what is said.
    EXPECT_THAT(help.err, HasSubstr("the helper mien-"));
    return;
  }
  EXPECT_EQ(help.status, 0);
  EXPECT_EQ(help.err, "");
  EXPECT_THAT(help.out, HasSubstr("Usage: " + joined(command) + " "));
  EXPECT_THAT(help.out, HasSubstr("Example:"));
  EXPECT_THAT(help.out, HasSubstr("  " + joined(command)));
  for (const std::string& part : commands_in(help.out)) {
    std::vector<std::string> deeper = command;
    deeper.push_back(part);
    expect_help(deeper);
  }
}

TEST(Program, EveryCommandExplainsItselfWithAnExample) {
  const Outcome help = run({"--help"});
  EXPECT_EQ(help.status, 0);
  EXPECT_EQ(help.err, "");
  const std::vector<std::string> commands = commands_in(help.out);
  for (const char* command :
       {"demo", "calibrate", "perform", "train", "solve", "evaluate", "export", "render", "face", "take"})
    EXPECT_THAT(commands, ::testing::Contains(command));
  for (const std::string& command : commands) expect_help({command});
}

/// One wrong command line, and what its one line must name.
struct Wrong {
  std::vector<std::string> arguments;  ///< "@x" stands for the file x in the test's folder.
  std::string names;
};

/// A folder with something wrong of every kind, and a little that is right.
class WrongInput : public ::testing::Test {
 protected:
  void SetUp() override {
    write(folder_ / "empty.mien", "");
    write(folder_ / "garbage.mien", "SQLite format 3" + std::string(3000, '\x5A'));
    write(folder_ / "kept.mien", "somebody's work");
    write(folder_ / "empty.csv", "");
    write(folder_ / "garbage.csv", "Timecode,BlendshapeCount\nyes,\xFF\xFE,no\n");
    write(folder_ / "broken.toml", "name = \"rig\"\n[[sensor]\n");
    write(folder_ / "wrong.toml", "gyro_smell = 3\n");
    write(folder_ / "rig.toml", virt::test::kRig);
    write(folder_ / "garbage.glb", "glTF" + std::string(40, '\x7F'));
    write(folder_ / "garbage.safetensors", std::string(64, '\xFF'));
    ASSERT_TRUE(model::write_model(folder_ / "tiny.safetensors",
                                   tracker::test::tiny_model({"mentalis", "buccinator_L"})));
  }

  void expect_refused(const std::vector<Wrong>& cases) {
    const auto before = folder_.files();
    for (const Wrong& wrong : cases) {
      std::vector<std::string> arguments = wrong.arguments;
      for (std::string& argument : arguments)
        if (argument.starts_with('@')) argument = folder_ / argument.substr(1);
      SCOPED_TRACE(joined(arguments));
      const Outcome refused = run(arguments);
      EXPECT_EQ(refused.status, 2);
      EXPECT_EQ(refused.out, "");
      EXPECT_TRUE(refused.err.starts_with("mien: ")) << refused.err;
      EXPECT_EQ(std::ranges::count(refused.err, '\n'), 1) << refused.err;
      EXPECT_TRUE(refused.err.ends_with('\n'));
      EXPECT_THAT(refused.err, HasSubstr(wrong.names));
      EXPECT_EQ(folder_.files(), before);
    }
    EXPECT_EQ(content(folder_ / "kept.mien"), "somebody's work");
  }

  Folder folder_;
};

TEST_F(WrongInput, CommandsThatDoNotExist) {
  expect_refused({{{}, "no command was given"},
                  {{"dance"}, "dance"},
                  {{"take"}, "they are info, check"},
                  {{"take", "eat", "@kept.mien"}, "eat"},
                  {{"take", "info"}, "take"},
                  {{"perform"}, "--take"},
                  {{"solve", "@kept.mien", "--quickly"}, "--quickly"}});
}

TEST_F(WrongInput, EveryMistakeNamesTheWayOut) {
  expect_refused(
      {{{"liev"}, "mien: there is no command 'liev'; did you mean live? see mien --help"},
       {{"dance"}, "there is no command 'dance'; the commands are demo, live, calibrate"},
       {{"take", "inof", "@kept.mien"}, "mien: take: there is no command 'inof'; did you mean info?"},
       {{"live", "--recrod", "x.mien"},
        "mien: live: there is no option --recrod; did you mean --record? see "
        "mien live --help"},
       {{"solve", "@kept.mien", "--quickly"},
        "mien: solve: there is no option --quickly; see mien solve --help"},
       {{"solve", "@kept.mien", "b.mien", "c.mien"}, "mien: solve: 'b.mien' is a word too many"},
       {{"take", "info"}, "mien: take info: take is missing; see mien take info --help"},
       {{"import", "a.csv", "b.csv"}, "mien: import: 'b.csv' is a word too many"},
       {{"import", "a.csv", "--heda", "a"}, "there is no option --heda; did you mean --head?"},
       {{"perform", "--to", "udp://a:1", "--take", "b.mien"}, "cannot be given together"},
       {{"perform", "--loop"}, "mien: perform: --loop means nothing without --to"},
       {{"perform", "--seed"}, "mien: perform: --seed has no value"},
       {{"perform", "--seed", "x"}, "mien: perform: --seed: x is no whole number from 0 on"},
       {{"perform", "--seed", "-1"}, "mien: perform: --seed: -1 is no whole number from 0 on"},
       {{"study", "loss", "--seed", "-1"}, "mien: study loss: --seed: -1 is no whole number from 0 on"},
       {{"study", "live"}, "mien: study live: --out is missing"},
       {{"study"}, "mien: study: it needs one of its commands; they are ablation, confidence, hours, "},
       {{"bench", "foo"}, "mien: bench: there is no command 'foo'; the commands are live, "},
       {{"study", "live", "--rows", "flying", "--out", "@live"}, "mien: the study has no rows 'flying'"},
       {{"study", "live", "--face", "x", "--out", "@live"},
        "mien: study live: --face means nothing without --takes"},
       {{"study", "live", "--model", "gru", "--out", "@live"}, "mien: gru: a model to compare is NAME=FILE"},
       {{"record"}, "mien: record: --out is missing"},
       {{"perform", "--script", "opera"}, "mien: perform: --script: opera is none of "},
       {{"calibrate", "--wait", "0"}, "mien: calibrate: --wait: 0 is no number from 1 to 3600"}});
}

TEST_F(WrongInput, TakesThatAreNone) {
  std::vector<Wrong> cases;
  for (const char* take : {"none.mien", "empty.mien", "garbage.mien", "kept.mien"})
    for (const std::vector<std::string>& command :
         std::vector<std::vector<std::string>>{{"take", "info"},
                                               {"take", "check"},
                                               {"solve", "--model", "@tiny.safetensors"},
                                               {"evaluate", "--json", "--model", "@tiny.safetensors"}}) {
      cases.push_back({command, take});
      cases.back().arguments.push_back("@" + std::string(take));
    }
  expect_refused(cases);
}

TEST_F(WrongInput, Performances) {
  const auto perform = [](std::vector<std::string> more) {
    std::vector<std::string> arguments = {"perform", "--rig",  "@rig.toml", "--devices",
                                          "lab",     "--take", "@new.mien"};
    // What comes later counts for options that are given twice.
    for (std::size_t i = 0; i + 1 < more.size(); i += 2) {
      const auto found = std::ranges::find(arguments, more[i]);
      if (found != arguments.end())
        *(found + 1) = more[i + 1];
      else
        arguments.insert(arguments.end(), {more[i], more[i + 1]});
    }
    return arguments;
  };
  expect_refused({{perform({"--motion", "@none.csv"}), "none.csv"},
                  {perform({"--motion", "@none.csv", "--seconds", "10801"}), "--seconds"},
                  {perform({"--motion", "@none.csv", "--voice", "babble"}), "--voice"},
                  {perform({"--motion", "@kept.mien"}), "kept.mien"},
                  {perform({"--script", "free", "--voice", "espeak"}), "babble"},
                  {perform({"--motion", "@empty.csv"}), "empty.csv"},
                  {perform({"--motion", "@garbage.csv"}), "garbage.csv"},
                  {perform({"--rig", "@none.toml"}), "none.toml"},
                  {perform({"--rig", "@broken.toml"}), "broken.toml"},
                  {perform({"--rig", "@garbage.mien"}), "garbage.mien"},
                  {perform({"--face", "nobody"}), "nobody"},
                  {perform({"--face", "builtin:many"}), "builtin:many"},
                  // Before a text is read aloud, which would leave the sound.
                  {perform({"--face", "nobody", "--script", "reading", "--sound", "@new.wav"}), "nobody"},
                  {perform({"--face", "@garbage.glb"}), "garbage.glb"},
                  {perform({"--devices", "@none.toml"}), "none.toml"},
                  {perform({"--devices", "@wrong.toml"}), "gyro_smell"},
                  {perform({"--script", "opera"}), "opera"},
                  {perform({"--seconds", "0"}), "--seconds"},
                  {perform({"--seconds", "7300"}), "IMUs alone"},
                  {perform({"--seconds", "nan"}), "--seconds"},
                  {perform({"--prologue", "long"}), "long"},
                  {perform({"--pace", "slow"}), "slow"},
                  {perform({"--seed", "x"}), "--seed"},
                  {perform({"--seed", "1.5"}), "--seed"},
                  {perform({"--take", "@kept.mien"}), "--force"},
                  {perform({"--take", "@nowhere/new.mien"}), "nowhere"}});
}

TEST_F(WrongInput, Prompts) {
  write(folder_ / "smirk.toml", "[[prompt]]\nname = \"a\"\nweights = { smirk = 1 }\n");
  write(folder_ / "empty.toml", "");
  const auto record = [](const std::string& prompts, const std::string& take = "@new.mien") {
    return std::vector<std::string>{
        "record", "--out", take, "--page", "off", "--listen", "udp://127.0.0.1:0", "--prompts", prompts};
  };
  expect_refused({{record("@smirk.toml"), "smirk.toml, line 3"},
                  {record("@empty.toml"), "asks for no pose"},
                  {record("@broken.toml"), "broken.toml"},
                  {record("@none.toml"), "none.toml"},
                  {record("two_minutes"), "there are no such prompts"},
                  {record("components:"), "components:N"},
                  {record("components:0"), "components:N"},
                  {record("components:9999"), "components:N"},
                  {record("components:3:-1"), "components:N"},
                  {record("components:3:1:1"), "components:N"},
                  {record("one_minute", "@new.csv"), ".mien"},
                  {record("one_minute", "@kept.mien"), "--force"}});
}

TEST_F(WrongInput, ModelsFacesAndMotions) {
  const Outcome performed = run({"perform", "--rig", folder_ / "rig.toml", "--devices", "lab", "--seconds",
                                 "1", "--prologue", "none", "--take", folder_ / "sound.mien"});
  ASSERT_EQ(performed.status, 0) << performed.err;
  expect_refused(
      {{{"solve", "@kept.mien", "--model", "@none.safetensors"}, ".mien"},
       {{"evaluate", "@sound.mien", "--model", "@none.safetensors"}, "none.safetensors"},
       {{"evaluate", "@sound.mien", "--model", "@garbage.safetensors"}, "garbage.safetensors"},
       {{"solve", "@kept.mien", "--model", "@tiny.safetensors", "--out", "@new.txt"}, "new.txt"},
       {{"solve", "@kept.mien", "--steps", "0"}, "--steps"},
       {{"solve", "@sound.mien", "--window", "--model", project_path("models/live.safetensors")},
        "leave --window out"},
       {{"evaluate", "@sound.mien", "--steps", "4"}, "--window"},
       {{"evaluate", "@kept.mien", "--no-adapt", "--window"}, "--window"},
       {{"face", "--face", "nobody"}, "nobody"},
       {{"face", "profiles", "openxr_bf_70"}, "did you mean openxr_fb_70?"},
       {{"face", "export", "--out", "@new.txt"}, "new.txt"},
       {{"face", "export", "--names", "arkti", "--out", "@new.glb"}, "did you mean arkit?"},
       {{"face", "export", "--names", "arkit", "--out", "@new.obj"}, "--names"},
       {{"face", "export", "--textures", "204", "--out", "@new.glb"}, "did you mean 2048?"},
       {{"face", "export", "--textures", "2048", "--out", "@new.obj"}, "--textures"},
       {{"face", "export", "--names", "unified", "--out", "@new.vrm"}, "new.vrm"},
       {{"face", "export", "--names", "vrm", "--out", "@new.gltf"}, "new.gltf"},
       {{"export", "--motion", "@garbage.csv", "--names", "arkit", "--out", "@new.csv"}, "new.csv"},
       {{"export", "--motion", "@garbage.csv", "--out", "@new.glb"}, "garbage.csv"},
       {{"export", "--motion", "@none.mien", "--out", "@new.csv"}, "none.mien"},
       {{"export", "--out", "@new.onnx"}, "--model"},
       {{"export", "--motion", "@a.csv", "--model", "@tiny.safetensors", "--out", "@b.onnx"}, "--motion"},
       {{"export", "--motion", "@garbage.csv", "--part", "network", "--out", "@b.csv"}, "--part"},
       {{"export", "--model", "@none.safetensors", "--out", "@new.onnx"}, "none.safetensors"},
       {{"export", "--model", "@garbage.safetensors", "--out", "@new.onnx"}, "garbage.safetensors"},
       {{"export", "--model", "@tiny.safetensors", "--out", "@new.csv"}, "new.csv"},
       {{"export", "--model", "@tiny.safetensors", "--part", "nose", "--out", "@new.onnx"}, "nose"},
       {{"export", "--model", "@tiny.safetensors", "--chain", "2", "--out", "@new.onnx"}, "causal"},
       {{"export", "--model", "@tiny.safetensors", "--chain", "0", "--out", "@new.onnx"}, "--chain"},
       {{"bench", "onnxruntime", "--model", "@none.safetensors"}, "none.safetensors"},
       {{"render", "--weights", "jawOpen=1,beak=1", "--out", "@new.png"}, "beak"},
       {{"render", "--weights", "jawOpen=wide", "--out", "@new.png"}, "jawOpen"},
       {{"render", "--weights", "jawOpen", "--out", "@new.png"}, "'jawOpen' has no number"},
       {{"render", "--weights", "mouthSmileLeft=1,jawOpne=1", "--out", "@new.png"}, "did you mean jawOpen?"},
       {{"render", "--weights", "jawOpen=1,mouthClose=1,jawOpen=1", "--out", "@new.png"},
        "jawOpen is given twice"},
       {{"render", "--weights", "jawOpen=1", "--weights", "jawopen=0", "--out", "@new.png"},
        "'jawopen=0': jawOpen"},
       {{"render", "--weights", "mouthSmile=1,mouthSmileLeft=0", "--out", "@new.png"},
        "mouthSmile_L is given"},
       {{"render", "--weights", "tongueOut=1,tongueOut=0", "--out", "@new.png"}, "tongueOut is given twice"},
       {{"face", "--face", "builtin:-1"}, "a whole number from 0 to 18446744073709551615"},
       {{"face", "--face", "builtin:7,hair=bob,hair=bob"}, "hair is given twice"},
       {{"render", "--face", "nobody", "--out", "@new.png"}, "nobody"},
       {{"render", "--face", "builtin:haan", "--out", "@new.png"}, "did you mean hana?"},
       {{"render", "--face", "builtin:ada,nose_widht=2", "--out", "@new.png"}, "did you mean nose_width?"},
       {{"render", "--face", "builtin:ada,sex=nan", "--out", "@new.png"}, "'sex=nan' has no number"},
       {{"render", "--pose", "smiel", "--out", "@new.png"}, "did you mean smile?"},
       {{"render", "--light", "studoi", "--out", "@new.png"}, "did you mean studio?"},
       {{"render", "--light", "infrared", "--face", "@garbage.glb", "--out", "@new.png"}, "infrared"},
       {{"render", "--view", "behind", "--out", "@new.png"}, "degrees"},
       {{"render", "--size", "20000x20000", "--out", "@new.png"}, "1 to 8192"},
       {{"render", "--size", "0x1", "--out", "@new.png"}, "1 to 8192"},
       {{"render", "--weights", "jawOpen=nan", "--out", "@new.png"}, "out of range"},
       {{"render", "--motion", "@garbage.csv", "--pose", "smile", "--out", "@new.mp4"}, "--pose"},
       {{"render", "--motion", "@garbage.csv", "--out", "@new.mp4"}, "garbage.csv"},
       {{"render", "--out", "@new.gif"}, "new.gif"}});
}

TEST_F(WrongInput, ADemoThatCannotEndDoesNotBegin) {
  expect_refused({{{"demo", "--out", "@demo", "--model", "@none.safetensors"}, "none.safetensors"},
                  {{"demo", "--out", "@demo", "--model", "@garbage.safetensors"}, "garbage.safetensors"},
                  {{"demo", "--out", "@demo", "--seconds", "0"}, "--seconds"}});
}

TEST_F(WrongInput, ValuesBeyondWhatPeopleHaveAreHeldAndSaid) {
  const std::string out = folder_ / "one.png";
  const Outcome outcome =
      run({"render", "--face", "builtin:emil,nose_width=9", "--pose", "grin", "--weights",
           "jawopen=1,mouthSmileLeft=0.5", "--light", "infrared", "--size", "1x1", "--out", out});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "builtin:emil,nose_width=9: nose_width 9 is beyond what people have, held to 3\n");
  EXPECT_TRUE(std::filesystem::exists(out));
}

TEST(Program, AnErrorIsOneLineThatNoTerminalObeys) {
  const Outcome outcome = run({"take", "info", "no\x1b]0;pwned\x07\nsuch.mien"});
  EXPECT_EQ(outcome.status, 2);
  EXPECT_EQ(outcome.err, "mien: no?]0;pwned? such.mien: there is no such file\n");
}

}  // namespace
}  // namespace mien::app::test::command_line_test
