// Pairing: the key's file, the line of firmware, and virtual boards that seal what they send to `mien live`.
#include "app/live/pairing_key.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/stat.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "tests/app/program.h"
#include "tests/project_path.h"
#include "tests/virtual/three_sensors.h"

namespace mien::app::test::pairing_test {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

mode_t mode_of(const std::filesystem::path& path) {
  struct stat found {};
  EXPECT_EQ(::stat(path.c_str(), &found), 0) << path;
  return found.st_mode & 0777;
}

/// An environment variable, as it was before when this goes.
class Variable {
 public:
  Variable(const char* name, const std::string& value) : name_(name) {
    if (const char* const before = std::getenv(name)) before_ = before;
    ::setenv(name, value.c_str(), 1);
  }
  ~Variable() {
    if (before_)
      ::setenv(name_, before_->c_str(), 1);
    else
      ::unsetenv(name_);
  }
  Variable(const Variable&) = delete;
  Variable& operator=(const Variable&) = delete;

 private:
  const char* name_;
  std::optional<std::string> before_;
};

TEST(PairingKey, StandsWhereTheUsersSettingsDo) {
  const Variable home("HOME", "/home/somebody");
  {
    const Variable config("XDG_CONFIG_HOME", "/elsewhere");
    EXPECT_EQ(default_pairing_key().value(), "/elsewhere/mien/pairing.key");
  }
  const Variable config("XDG_CONFIG_HOME", "");
  EXPECT_EQ(default_pairing_key().value(), "/home/somebody/.config/mien/pairing.key");
  const Variable none("HOME", "");
  EXPECT_FALSE(default_pairing_key());
}

TEST(PairingKey, IsMadeOnceAndForItsOwnerAlone) {
  const Folder folder;
  const std::filesystem::path file = folder / "config/mien/pairing.key";
  const auto key = make_pairing_key(file);
  ASSERT_TRUE(key) << key.error().message();
  EXPECT_EQ(mode_of(file), 0600);
  EXPECT_EQ(mode_of(file.parent_path()), 0700);
  EXPECT_EQ(mode_of(file.parent_path().parent_path()), 0700);
  EXPECT_EQ(std::ranges::distance(std::filesystem::directory_iterator(file.parent_path())), 1);
  const auto again = make_pairing_key(file);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->secret, key->secret);
  EXPECT_EQ(read_pairing_key(file)->secret, key->secret);
  EXPECT_NE(make_pairing_key(folder / "another.key")->secret, key->secret);
  write(folder / "no.key", "open sesame\n");
  EXPECT_EQ(make_pairing_key(folder / "no.key").error().code, ErrorCode::malformed);
  EXPECT_EQ(content(folder / "no.key"), "open sesame\n");
}

TEST(PairingKey, ThatOthersCanReadIsSaid) {
  const Folder folder;
  const std::filesystem::path file = folder / "pairing.key";
  ASSERT_TRUE(make_pairing_key(file));
  const auto said = [&file] {
    ::testing::internal::CaptureStderr();
    EXPECT_TRUE(read_pairing_key(file));
    return ::testing::internal::GetCapturedStderr();
  };
  EXPECT_EQ(said(), "");
  std::filesystem::permissions(file, std::filesystem::perms(0640));
  EXPECT_THAT(said(), HasSubstr("pairing.key: other users of this machine can read this key; run chmod 600"));
}

TEST(PairingKey, IsOneLineOfFirmwareAndOneCommand) {
  sensor::SealKey key{.id = 3, .secret = {}};
  for (std::size_t i = 0; i < key.secret.size(); ++i) key.secret[i] = static_cast<std::byte>(16 * i);
  const std::string line = firmware_line(key);
  EXPECT_THAT(line, StartsWith("static const uint8_t kMienKey[33] = {3, 0x00, 0x10, 0x20, "));
  EXPECT_TRUE(line.ends_with(", 0xe0, 0xf0};")) << line;
  EXPECT_EQ(std::ranges::count(line, ','), 32);
  EXPECT_EQ(line.find('\n'), std::string::npos);
  EXPECT_EQ(keyed_command("/home/me/.config/mien/pairing.key"),
            "mien live --key /home/me/.config/mien/pairing.key");
  EXPECT_EQ(keyed_command("/my home/it's"), "mien live --key '/my home/it'\\''s'");
}

class PairedProgram : public ::testing::Test {
 protected:
  void SetUp() override {
    for (const char* model : {"models/live.safetensors", "models/eyewear.safetensors"})
      if (!std::filesystem::exists(std::filesystem::path(project_path(model))))
        GTEST_SKIP() << "there is no " << model;
    write(folder_ / "rig.toml", virt::test::kRig);
    ASSERT_TRUE(make_pairing_key(key_));
  }
  /// A session with the key, and a performance to it; the session ends when that has.
  struct Both {
    Outcome performed;
    int status = -1;
    std::string err;
    nlohmann::json summary;
  };
  Both session(const std::string& rig, const std::vector<std::string>& performance) {
    std::vector<std::string> live = {"live",
                                     "--rig",
                                     rig,
                                     "--listen",
                                     "udp://127.0.0.1:0",
                                     "--key",
                                     key_,
                                     "--page",
                                     "off",
                                     "--json",
                                     "--out",
                                     "csv:" + (folder_ / "face.csv")};
    const pid_t process = start(live, folder_ / "out", folder_ / "err");
    std::string port;
    for (int i = 0; i < 3000 && port.empty(); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      const std::string said = content(folder_ / "err");
      const std::size_t at = said.find("udp://127.0.0.1:");
      if (at != std::string::npos && said.find('\n', at) != std::string::npos)
        port = said.substr(at, said.find('\n', at) - at);
    }
    Both both;
    std::vector<std::string> arguments = {"perform", "--rig", rig, "--to", port, "--json"};
    arguments.insert(arguments.end(), performance.begin(), performance.end());
    both.performed = run(arguments);
    ::kill(process, SIGINT);
    int status = 0;
    ::waitpid(process, &status, 0);
    both.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    both.err = content(folder_ / "err");
    both.summary = nlohmann::json::parse(content(folder_ / "out"), nullptr, false);
    return both;
  }

  Folder folder_;
  std::string key_ = folder_ / "pairing.key";
};

TEST_F(PairedProgram, SealedBoardsMoveTheFace) {
  const Both both = session(folder_ / "rig.toml", {"--key", key_, "--script", "free", "--seconds", "2"});
  EXPECT_EQ(both.performed.status, 0) << both.performed.err;
  EXPECT_EQ(nlohmann::json::parse(both.performed.out)["answered"], 3);
  EXPECT_EQ(both.status, 0) << both.err;
  EXPECT_THAT(both.err, HasSubstr("Only devices with the key are received"));
  EXPECT_GT(both.summary["frames"], 600);
  EXPECT_EQ(both.summary["calibrations"], 1);
  EXPECT_EQ(both.summary["sealed"], true);
  EXPECT_EQ(both.summary["refused"], 0);
  EXPECT_THAT(content(folder_ / "face.csv"), HasSubstr(",0.1")) << "no shape ever moved";
}

TEST_F(PairedProgram, SealedGlassesAreReceived) {
  const Both both = session(project_path("rigs/eyewear.toml"),
                            {"--key", key_, "--script", "free", "--seconds", "2", "--prologue", "none"});
  EXPECT_EQ(both.performed.status, 0) << both.performed.err;
  const auto performed = nlohmann::json::parse(both.performed.out);
  EXPECT_EQ(performed["answered"], performed["nodes"]);
  EXPECT_EQ(both.status, 0) << both.err;
  EXPECT_GT(both.summary["frames"], 60);
  EXPECT_EQ(both.summary["refused"], 0);
}

TEST_F(PairedProgram, WhoHasNoKeyIsRefusedAndThatIsSaid) {
  const Both both = session(folder_ / "rig.toml",
                            {"--script", "free", "--seconds", "1", "--prologue", "none", "--wait", "0"});
  EXPECT_EQ(both.performed.status, 0) << both.performed.err;
  EXPECT_EQ(nlohmann::json::parse(both.performed.out)["answered"], 0);
  EXPECT_EQ(both.status, 1);
  EXPECT_EQ(both.summary["frames"], 0);
  EXPECT_GT(both.summary["refused"], 100);
  EXPECT_THAT(both.err, HasSubstr("not sealed with the session's key"));
}

TEST_F(PairedProgram, SlimeVrsBoardsHaveNoKeys) {
  const Outcome refused = run({"perform", "--to", "slimevr://127.0.0.1:6969", "--key", key_});
  EXPECT_EQ(refused.status, 2);
  EXPECT_THAT(refused.err, HasSubstr("SlimeVR's boards have no keys"));
  EXPECT_EQ(run({"perform", "--to", "udp://127.0.0.1:5005", "--key", folder_ / "rig.toml"}).status, 2);
}

}  // namespace
}  // namespace mien::app::test::pairing_test
