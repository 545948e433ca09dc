// `mien live --audio` from outside: a sound in, a moving mouth out, and the same from the take.

#include <gmock/gmock.h>
#include <sys/wait.h>

#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>
#include <thread>

#include "mien/core/files.h"
#include "mien/core/wav.h"
#include "mien/speech/sound_block.h"
#include "mien/take/take.h"
#include "tests/app/program.h"
#include "tests/project_path.h"

namespace mien::app::test::sound_test {
namespace {

using testing::HasSubstr;

/// A second of a tone.
Sound tone(std::uint32_t rate_hz) {
  Sound sound{.rate_hz = rate_hz, .samples = std::vector<float>(rate_hz)};
  for (std::size_t i = 0; i < rate_hz; ++i)
    sound.samples[i] =
        static_cast<float>(0.2 * std::sin(2 * std::numbers::pi * 200 * static_cast<double>(i) / rate_hz));
  return sound;
}

/// A sentence read aloud by the helper, of 22.05 kHz; false where the program was built without it.
bool read_aloud(const std::string& wav) {
  const std::filesystem::path helper = std::filesystem::path(program_path()).parent_path() / "mien-media";
  if (!std::filesystem::exists(helper)) return false;
  const std::string command =
      helper.string() + " speak --text 'Father saw papa open five more maps' --wav " + wav + " > /dev/null";
  return std::system(command.c_str()) == 0;
}

struct SoundProgram : testing::Test {
  Folder folder;
  std::vector<std::string> live(std::vector<std::string> more) const {
    std::vector<std::string> arguments = {"live", "--listen", "udp://127.0.0.1:0", "--page", "off"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
  void write_sound(const std::string& name, const std::vector<std::byte>& bytes) const {
    ASSERT_TRUE(write_file(folder / name, bytes));
  }
};

/// The largest value of a column of a Live Link Face CSV.
double most(const std::string& csv, const std::string& column) {
  std::istringstream lines(csv);
  std::string line, cell;
  std::getline(lines, line);
  std::size_t place = 0;
  for (std::istringstream names(line); std::getline(names, cell, ',') && cell != column;) ++place;
  double largest = 0;
  EXPECT_EQ(cell, column);
  while (std::getline(lines, line)) {
    std::istringstream cells(line);
    for (std::size_t i = 0; i <= place; ++i) std::getline(cells, cell, ',');
    largest = std::max(largest, std::stod(cell));
  }
  return largest;
}

TEST_F(SoundProgram, ASoundMovesTheMouthAndTheTakeHearsTheSame) {
  // Of another rate, beside a rig of IMUs that are all silent: it gets a microphone.
  if (!read_aloud(folder / "talk.wav")) GTEST_SKIP() << "built without mien-media, which reads aloud";
  const Outcome outcome = run(live({"--audio", folder / "talk.wav", "--record", folder / "talk.mien", "--out",
                                    "csv:" + (folder / "talk.csv"), "--for", "4", "--json"}));
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const auto said = nlohmann::json::parse(outcome.out);
  EXPECT_GT(said["frames"].get<int>(), 60);
  EXPECT_EQ(said["missed"].get<int>(), 0);
  EXPECT_EQ(said["malformed"].get<int>(), 0);
  EXPECT_GT(most(content(folder / "talk.csv"), "JawOpen"), 0.2);
  EXPECT_GT(most(content(folder / "talk.csv"), "MouthClose"), 0.05) << "p and m";

  const auto take = take::Take::open(folder / "talk.mien");
  ASSERT_TRUE(take) << take.error().message();
  ASSERT_TRUE(take->rig().find("microphone"));
  EXPECT_EQ(take->rig().sensors.size(), 13U);
  auto samples = take->samples();
  ASSERT_TRUE(samples) << samples.error().message();
  const Sound sound = parse_wav(read_file(folder / "talk.wav").value(), "talk.wav").value();
  EXPECT_NEAR(static_cast<double>(samples->size()), std::min(sound.duration_s(), 4.0) * 50, 5)
      << "blocks of 20 ms";

  for (int i = 0; i < 10; ++i) {
    const Outcome replayed = run({"live", "--replay", folder / "talk.mien", "--json"});
    ASSERT_EQ(replayed.status, 0) << replayed.err;
    EXPECT_EQ(nlohmann::json::parse(replayed.out)["hash"], said["hash"]);
  }
  // The sound of the take: 16 kHz, the loudness that was heard.
  const Outcome exported = run({"take", "sound", folder / "talk.mien", "--out", folder / "heard.wav"});
  ASSERT_EQ(exported.status, 0) << exported.err;
  const Sound heard = parse_wav(read_file(folder / "heard.wav").value(), "heard.wav").value();
  EXPECT_EQ(heard.rate_hz, 16'000U);
  EXPECT_NEAR(heard.duration_s(), std::min(sound.duration_s(), 4.0), 0.1);
  EXPECT_NEAR(*std::ranges::max_element(heard.samples), *std::ranges::max_element(sound.samples), 0.1);
  EXPECT_THAT(run({"take", "sound", folder / "talk.mien", "--out", folder / "heard.mp3"}).err,
              HasSubstr(".wav"));

  const Outcome solved = run({"solve", folder / "talk.mien", "--out", folder / "solved.csv"});
  ASSERT_EQ(solved.status, 0) << solved.err;
  EXPECT_EQ(solved.err.find("prologue"), std::string::npos) << "a sound needs none: " << solved.err;
  EXPECT_GT(most(content(folder / "solved.csv"), "JawOpen"), 0.2);
}

TEST_F(SoundProgram, ARigsOwnMicrophoneIsTheOneThatHears) {
  write_sound("tone.wav", format_wav(tone(16'000)));
  const std::string rig =
      "name = \"ears\"\nreference = \"mine\"\n[[sensor]]\nname = \"mine\"\nkind = \"speech\"\nrole = "
      "\"face\"\n";
  write(folder / "bound.toml", rig + "device = \"02:00:00:00:00:07\"\n");
  write(folder / "plain.toml", rig);  // Virtual nodes.
  for (const char* name : {"bound.toml", "plain.toml"}) {
    const std::string recorded = folder / (std::string(name) + ".mien");
    const Outcome outcome = run(
        live({"--rig", folder / name, "--audio", folder / "tone.wav", "--record", recorded, "--for", "1.5"}));
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_THAT(outcome.out, HasSubstr("sound:tone.wav is over"));
    EXPECT_EQ(outcome.out.find("is lost"), std::string::npos) << outcome.out;
    EXPECT_EQ(outcome.err.find("cut short"), std::string::npos) << outcome.err;
    const auto take = take::Take::open(recorded);
    ASSERT_TRUE(take) << take.error().message();
    EXPECT_EQ(take->rig().sensors.size(), 1U);
    EXPECT_EQ(take->samples().value().size(), 50U) << name;
  }
  const std::string other =
      "[[sensor]]\nname = \"other\"\nkind = \"gaze\"\nrole = \"face\"\ndevice = \"02:00:00:00:00:08\"\n";
  write(folder / "unbound.toml", rig + other);
  const Outcome outcome = run(live({"--rig", folder / "unbound.toml", "--audio", folder / "tone.wav"}));
  EXPECT_EQ(outcome.status, 2);
  EXPECT_THAT(outcome.err, HasSubstr("the microphone 'mine' has no device"));
}

TEST_F(SoundProgram, TheMouthIsHeardByPhonesWhereTheRigSaysSo) {
  if (!read_aloud(folder / "talk.wav")) GTEST_SKIP() << "built without mien-media, which reads aloud";
  const Outcome outcome = run(live({"--audio", folder / "talk.wav", "--hears-by", "phones", "--record",
                                    folder / "talk.mien", "--for", "3", "--json"}));
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const auto take = take::Take::open(folder / "talk.mien");
  ASSERT_TRUE(take) << take.error().message();
  EXPECT_EQ(take->rig().sensors.back().hears_by, "phones") << "so a replay hears the same";
  const Outcome replayed = run({"live", "--replay", folder / "talk.mien", "--json"});
  ASSERT_EQ(replayed.status, 0) << replayed.err;
  EXPECT_EQ(nlohmann::json::parse(replayed.out)["hash"], nlohmann::json::parse(outcome.out)["hash"]);
  EXPECT_EQ(run(live({"--audio", folder / "talk.wav", "--hears-by", "ear"})).status, 2);
}

TEST_F(SoundProgram, ABrowserIsHeardWhereThereIsAPageOnly) {
  const Outcome none = run(live({"--audio", "page"}));
  EXPECT_EQ(none.status, 2);
  EXPECT_THAT(none.err, HasSubstr("--audio page: there is no page"));
}

TEST_F(SoundProgram, WithoutAudioNoMicrophoneIsOpened) {
  const Outcome both = run(live({"--no-audio", "--audio", "default"}));
  EXPECT_EQ(both.status, 2);
  EXPECT_THAT(both.err, HasSubstr("--no-audio"));
  write(folder / "ears.toml",
        "name = \"ears\"\nreference = \"mine\"\n[[sensor]]\nname = \"mine\"\nkind = \"speech\"\nrole = "
        "\"face\"\n"
        "device = \"02:4D:49:53:4E:00/0\"\n");
  // Its own microphone waits for the page's switch; with --no-audio it is not even there.
  for (const std::vector<std::string>& more : {std::vector<std::string>{}, {"--no-audio"}}) {
    std::vector<std::string> arguments = {"--rig",    folder / "ears.toml", "--for",  "1.2",
                                          "--record", folder / "t.mien",    "--force"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome outcome = run(live(arguments));
    EXPECT_EQ(outcome.status, 1) << outcome.out;
    EXPECT_THAT(outcome.err, HasSubstr("no frame came"));
    EXPECT_EQ(outcome.out.find("microphone"), std::string::npos) << outcome.out;
  }
  const Outcome unknown = run(live({"--audio", "a microphone that nobody has"}));
  EXPECT_NE(unknown.status, 0);
  EXPECT_THAT(unknown.err, HasSubstr("--audio a microphone that nobody has"));
}

TEST_F(SoundProgram, APerformersSoundIsWritten) {
  if (!read_aloud(folder / "talk.wav")) GTEST_SKIP() << "built without mien-media, which reads aloud";
  const Outcome outcome = run({"perform", "--script", "reading", "--seconds", "6", "--take",
                               folder / "p.mien", "--sound", folder / "p.wav"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const Sound sound = parse_wav(read_file(folder / "p.wav").value(), "p.wav").value();
  EXPECT_NEAR(sound.duration_s(), 6, 1);
  const Outcome unheard = run({"perform", "--script", "free", "--seconds", "2", "--take", folder / "q.mien",
                               "--sound", folder / "q.wav"});
  EXPECT_EQ(unheard.status, 2);
  EXPECT_THAT(unheard.err, HasSubstr("nothing is heard of this performance"));
}

/// Where a session says that it listens; empty: it does not say so within half a minute.
std::string listening_at(const std::string& said_to) {
  for (int i = 0; i < 3000; ++i) {
    const std::string said = content(said_to);
    const std::size_t at = said.find("udp://127.0.0.1:");
    const std::size_t end = said.find_first_of(" \n", at);
    if (at != std::string::npos && end != std::string::npos) return said.substr(at, end - at);
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return {};
}

std::size_t blocks_in(const take::Take& take) {
  std::size_t blocks = 0;
  const std::vector<take::LogEntry> entries = take.entries().value();
  for (const take::LogEntry& entry : entries) blocks += speech::logged_block(entry.bytes, {}) ? 1 : 0;
  return blocks;
}

TEST_F(SoundProgram, AVirtualMicrophoneIsHeardFromATake) {
  if (!read_aloud(folder / "talk.wav")) GTEST_SKIP() << "built without mien-media, which reads aloud";
  const std::string rig = project_path("rigs/imu_microphone.toml");
  const Outcome performed =
      run({"perform", "--script", "reading", "--seconds", "6", "--rig", rig, "--take", folder / "p.mien"});
  ASSERT_EQ(performed.status, 0) << performed.err;
  EXPECT_EQ(performed.err.find("nobody speaks"), std::string::npos) << performed.err;
  EXPECT_GT(blocks_in(take::Take::open(folder / "p.mien").value()), 600U) << "a prologue, and six seconds";
  std::string hash;
  for (int i = 0; i < 3; ++i) {
    const Outcome replayed = run({"live", "--replay", folder / "p.mien", "--json"});
    ASSERT_EQ(replayed.status, 0) << replayed.err;
    const auto said = nlohmann::json::parse(replayed.out)["hash"].get<std::string>();
    EXPECT_TRUE(i == 0 || said == hash);
    hash = said;
  }
  const Outcome solved = run({"solve", folder / "p.mien", "--out", folder / "solved.csv"});
  ASSERT_EQ(solved.status, 0) << solved.err;
  EXPECT_GT(most(content(folder / "solved.csv"), "JawOpen"), 0.1);
  const Outcome exported = run({"take", "sound", folder / "p.mien", "--out", folder / "heard.wav"});
  ASSERT_EQ(exported.status, 0) << exported.err;
  const Sound heard = parse_wav(read_file(folder / "heard.wav").value(), "heard.wav").value();
  EXPECT_GT(*std::ranges::max_element(heard.samples), 0.1);
  // A performance that nobody hears is told of.
  const Outcome quiet = run({"perform", "--script", "free", "--seconds", "1", "--prologue", "none", "--rig",
                             rig, "--take", folder / "q.mien"});
  ASSERT_EQ(quiet.status, 0) << quiet.err;
  EXPECT_THAT(quiet.err, HasSubstr("nobody speaks"));
  EXPECT_GT(blocks_in(take::Take::open(folder / "q.mien").value()), 50U);
}

TEST_F(SoundProgram, AMicrophoneOnTheNetworkIsHeardWhereItIsAskedFor) {
  if (!read_aloud(folder / "talk.wav")) GTEST_SKIP() << "built without mien-media, which reads aloud";
  const std::string rig = project_path("rigs/imu_microphone.toml");
  const auto session = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments =
        live({"--rig", rig, "--json", "--record", folder / "n.mien", "--force"});
    arguments.insert(arguments.end(), more.begin(), more.end());
    const pid_t process = start(arguments, folder / "out", folder / "err");
    ASSERT_GT(process, 0);
    const std::string to = listening_at(folder / "err");
    EXPECT_NE(to, "") << content(folder / "err");
    if (!to.empty()) {
      const Outcome performed = run({"perform", "--script", "reading", "--seconds", "3", "--rig", rig,
                                     "--prologue", "none", "--to", to});
      EXPECT_EQ(performed.status, 0) << performed.err;
    }
    ::kill(process, SIGINT);
    int status = 0;
    ::waitpid(process, &status, 0);
    EXPECT_EQ(status, 0) << content(folder / "err");
  };
  session({"--audio", "network"});
  const auto said = nlohmann::json::parse(content(folder / "out"));
  EXPECT_GT(blocks_in(take::Take::open(folder / "n.mien").value()), 100U);
  const Outcome replayed = run({"live", "--replay", folder / "n.mien", "--json"});
  ASSERT_EQ(replayed.status, 0) << replayed.err;
  EXPECT_EQ(nlohmann::json::parse(replayed.out)["hash"], said["hash"]);

  session({"--no-audio"});
  EXPECT_EQ(blocks_in(take::Take::open(folder / "n.mien").value()), 0U);
  session({});
  EXPECT_EQ(blocks_in(take::Take::open(folder / "n.mien").value()), 0U) << "the switch is off";

  const Outcome own = run(live({"--rig", project_path("rigs/microphone.toml"), "--audio", "network"}));
  EXPECT_EQ(own.status, 2);
  EXPECT_THAT(own.err, HasSubstr("this machine's own"));
}

TEST_F(SoundProgram, AMicrophoneOnTheNetworkThatNeverSendsIsToldOfOnce) {
  const pid_t process = start(live({"--rig", project_path("rigs/imu_microphone.toml"), "--audio", "network"}),
                              folder / "out", folder / "err");
  ASSERT_GT(process, 0);
  const std::string to = listening_at(folder / "out");
  EXPECT_NE(to, "") << content(folder / "err");
  // Who wears no microphone.
  if (!to.empty()) {
    const Outcome performed = run({"perform", "--script", "free", "--seconds", "12", "--rig",
                                   project_path("rigs/default.toml"), "--prologue", "none", "--to", to});
    EXPECT_EQ(performed.status, 0) << performed.err;
  }
  ::kill(process, SIGINT);
  int status = 0;
  ::waitpid(process, &status, 0);
  const std::string told = content(folder / "out"),
                    part = "nothing comes from the microphone 'microphone' yet";
  EXPECT_THAT(told, HasSubstr(part + ": is it on, and does it send here as 02:4D:49:53:4E:01, "));
  EXPECT_EQ(told.find(part), told.rfind(part)) << told;
}

TEST_F(SoundProgram, NothingIsHeardUnasked) {
  const Outcome outcome = run(live({"--record", folder / "quiet.mien", "--for", "0.5"}));
  EXPECT_EQ(outcome.status, 1) << "no device sends: " << outcome.out;
  const auto take = take::Take::open(folder / "quiet.mien");
  ASSERT_TRUE(take) << take.error().message() << outcome.err;
  EXPECT_FALSE(take->rig().find("microphone"));
  const Outcome exported = run({"take", "sound", folder / "quiet.mien", "--out", folder / "quiet.wav"});
  EXPECT_EQ(exported.status, 2);
  EXPECT_THAT(exported.err, HasSubstr("the take has no sound"));
}

TEST_F(SoundProgram, BadSoundIsOneLine) {
  const auto line = [&](const std::string& name, const std::string& part) {
    const Outcome outcome = run(live({"--audio", folder / name, "--for", "0.2"}));
    EXPECT_EQ(outcome.status, 2) << name << outcome.out;
    EXPECT_THAT(outcome.err, HasSubstr(part)) << name;
    EXPECT_THAT(outcome.err, HasSubstr(name));
    EXPECT_EQ(std::ranges::count(outcome.err, '\n'), 1) << outcome.err;
  };
  const std::vector<std::byte> good = format_wav(tone(8'000));
  const auto with = [&](std::size_t at, std::uint32_t value, std::size_t bytes) {
    std::vector<std::byte> changed = good;
    std::memcpy(changed.data() + at, &value, bytes);
    return changed;
  };
  line("missing.wav", "there is no such file");
  write_sound("nothing.wav", {});
  line("nothing.wav", "nothing.wav: ");
  write_sound("empty.wav", format_wav({.rate_hz = 16'000, .samples = {}}));
  line("empty.wav", "there is no sound in it");
  write_sound("slow.wav", with(24, 1, 4));  // 1 Hz.
  line("slow.wav", "Hz");
  write_sound("deep.wav", with(34, 24, 2));  // 24 bits.
  line("deep.wav", "16");
  write(folder / "text.wav", "this is no sound\n");
  line("text.wav", "RIFF");
  // A header that promises more than is there: what is there is heard, as of a recorder that was killed.
  write_sound("lying.wav", with(40, 0x7FFF'FFFF, 4));
  const Outcome cut = run(live({"--audio", folder / "lying.wav", "--for", "1"}));
  EXPECT_EQ(cut.status, 0);
  EXPECT_THAT(cut.err, HasSubstr("lying.wav: the file is cut short: 1.0 of "));
  EXPECT_EQ(std::ranges::count(cut.err, '\n'), 1) << cut.err;
  const Outcome nameless = run(live({"--audio", ""}));
  EXPECT_EQ(nameless.status, 2);
  EXPECT_THAT(nameless.err, HasSubstr("the sound has no name"));
  // A take has its sound.
  const Outcome outcome = run({"live", "--replay", folder / "text.wav", "--audio", folder / "lying.wav"});
  EXPECT_EQ(outcome.status, 2);
  EXPECT_THAT(outcome.err, HasSubstr("--audio"));
}

}  // namespace
}  // namespace mien::app::test::sound_test
