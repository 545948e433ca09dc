// `mien calibrate` against a real session behind the page's server, on virtual devices and a quick time.
#include "tests/app/staged_session.h"
//
#include <gmock/gmock.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/wait.h>

#include "tests/app/program.h"

namespace mien::app::test::calibrate_test {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

/// Seconds into it a performer of session::test::performance() has calibrated the session and talks.
constexpr double kTalking_s = 16;

Outcome calibrate(const StagedSession& session, std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "calibrate");
  arguments.insert(arguments.end(), {"--at", session.at()});
  return run(arguments);
}

TEST(Calibrate, LeadsThroughTheStepsAndShowsTheScores) {
  StagedSession session(obedient(10), 0.5, 15);
  const Outcome outcome = calibrate(session, {"short"});
  EXPECT_EQ(outcome.status, 0) << outcome.out << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("Calibration 1, guided: "));
  EXPECT_THAT(outcome.out, HasSubstr("the nod was large enough"));
  EXPECT_THAT(outcome.out, Not(HasSubstr("FAILED")));
  const std::size_t neutral = outcome.err.find("neutral: Look ahead, relax your face and hold still");
  const std::size_t nod = outcome.err.find("nod: Keep your face still and nod twice, down first");
  const std::size_t shake = outcome.err.find("shake: Keep your face still and shake your head twice");
  ASSERT_NE(shake, std::string::npos) << outcome.err;
  EXPECT_LT(neutral, nod);
  EXPECT_LT(nod, shake);
  EXPECT_EQ(session.report().calibration.in_force, 1);
}

TEST(Calibrate, OneJsonObjectSaysVersionScoresAndPassed) {
  StagedSession session(obedient(10), 0.5, 15);
  const Outcome outcome = calibrate(session, {"--json"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  const json said = json::parse(outcome.out);
  EXPECT_EQ(said.at("version"), 1);
  EXPECT_EQ(said.at("origin"), "guided");
  EXPECT_EQ(said.at("passed"), true);
  const std::vector<sensor::Score> scores = session.report().calibration.versions.at(0).scores;
  ASSERT_EQ(said.at("scores").size(), scores.size());
  EXPECT_EQ(said.at("scores").at(0).at("sentence"), scores[0].sentence);
}

TEST(Calibrate, AFullOneWhoseExpressionsWereNotSeenIsAFailure) {
  StagedSession session(obedient(40), 0.5, 30);
  const Outcome outcome = calibrate(session, {"full"});
  EXPECT_EQ(outcome.status, 1) << outcome.out;
  EXPECT_THAT(outcome.err, HasSubstr("anchor: Puff your cheeks"));
  EXPECT_THAT(outcome.err, HasSubstr("not every score passed"));
  EXPECT_THAT(outcome.out, HasSubstr("FAILED  anchor cheek_puff"));
}

TEST(Calibrate, ATalkingFaceFailsWithTheReasonAndChangesNothing) {
  StagedSession session(session::test::performance(30).entries, kTalking_s, 15);
  ASSERT_EQ(session.report().calibration.in_force, 1);
  const Outcome outcome = calibrate(session, {"--json"});
  EXPECT_EQ(outcome.status, 1);
  const session::Report::Calibration after = session.report().calibration;
  EXPECT_EQ(after.state, "failed");
  EXPECT_THAT(outcome.err, HasSubstr("mien: calibration: " + after.prompt));
  const json said = json::parse(outcome.out);
  EXPECT_TRUE(said.at("version").is_null());
  EXPECT_EQ(said.at("passed"), false);
  EXPECT_EQ(said.at("error"), after.prompt);
  EXPECT_EQ(after.in_force, 1);
  // A failure that stands there from before is not taken for the next one's.
  const Outcome again = calibrate(session, {});
  EXPECT_EQ(again.status, 1);
  EXPECT_THAT(again.err, HasSubstr("nod: Keep your face still"));
}

TEST(Calibrate, CtrlCCancelsOnTheSessionAndChangesNothing) {
  StagedSession session(session::test::performance(30).entries, kTalking_s, 1);
  const Folder folder;
  const pid_t process = start({"calibrate", "--at", session.at()}, folder / "out", folder / "err");
  ASSERT_GT(process, 0);
  const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  while (content(folder / "err").find("neutral:") == std::string::npos &&
         std::chrono::steady_clock::now() < give_up)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_EQ(session.report().calibration.state, "running");
  const Outcome second = calibrate(session, {});
  EXPECT_EQ(second.status, 1);
  EXPECT_THAT(second.err, HasSubstr("one runs already"));
  ::kill(process, SIGINT);
  int status = 0;
  ::waitpid(process, &status, 0);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 1);
  EXPECT_THAT(content(folder / "err"), HasSubstr("cancelled; nothing was changed"));
  const session::Report::Calibration after = session.report().calibration;
  EXPECT_EQ(after.state, "done");
  EXPECT_EQ(after.versions.size(), 1U);
}

TEST(Calibrate, WithoutASensorItGivesUpAndSaysWhichAreMissing) {
  StagedSession session({}, 0, 1);
  const Outcome outcome = calibrate(session, {"--wait", "1", "--json"});
  EXPECT_EQ(outcome.status, 1);
  EXPECT_THAT(outcome.err, HasSubstr("mien: calibration: no frame came for 1 s, nothing from silent: "));
  EXPECT_THAT(outcome.err, HasSubstr("mentalis"));
  EXPECT_THAT(outcome.err, HasSubstr("cancelled; nothing was changed"));
  EXPECT_TRUE(json::parse(outcome.out).at("version").is_null());
  EXPECT_EQ(session.report().calibration.state, "watching");
  EXPECT_THAT(session.report().calibration.versions, IsEmpty());
}

TEST(Calibrate, AfterAWhileItSaysWhatItWaitsFor) {
  StagedSession session({}, 0, 1);
  const Outcome outcome = calibrate(session, {"--wait", "11"});
  EXPECT_EQ(outcome.status, 1);
  EXPECT_THAT(outcome.err, HasSubstr("still waiting for frames, nothing from silent: "));
  EXPECT_THAT(outcome.err, HasSubstr("--wait"));
}

TEST(Calibrate, WhereEverySensorIsLostItIsRefusedAtOnce) {
  std::vector<take::LogEntry> entries =
      session::test::performance(4).entries;  // They fall silent after 16.5 s.
  StagedSession session(std::move(entries), 18, 10);
  const session::Report::Calibration before = session.report().calibration;
  const Outcome outcome = calibrate(session, {});
  EXPECT_EQ(outcome.status, 1);
  EXPECT_THAT(outcome.err, HasSubstr("no sensor sends any more (lost: "));
  EXPECT_EQ(std::ranges::count(outcome.err, '\n'), 1) << outcome.err;
  EXPECT_EQ(session.report().calibration.state, before.state);
  EXPECT_EQ(session.report().calibration.in_force, before.in_force);
}

TEST(Calibrate, VersionsAreListedComparedAndUndone) {
  StagedSession session(session::test::performance(30).entries, kTalking_s, 10);
  const Outcome centred = calibrate(session, {"recentre", "--json"});
  EXPECT_EQ(centred.status, 0) << centred.err;
  EXPECT_EQ(json::parse(centred.out).at("version"), 2);
  EXPECT_EQ(json::parse(centred.out).at("origin"), "recentre");
  EXPECT_TRUE(json::parse(centred.out).at("passed").is_null());

  const Outcome list = calibrate(session, {"list"});
  EXPECT_EQ(list.status, 0) << list.err;
  EXPECT_THAT(list.out, HasSubstr("self"));
  EXPECT_THAT(list.out, HasSubstr("not judged"));
  EXPECT_THAT(list.out, HasSubstr(" ago"));
  EXPECT_EQ(json::parse(calibrate(session, {"list", "--json"}).out).at("in_force"), 2);

  const Outcome used = calibrate(session, {"use", "1"});
  EXPECT_EQ(used.status, 0) << used.err;
  EXPECT_EQ(used.out, "Calibration 1 (self) is in force.\n");
  EXPECT_EQ(session.report().calibration.in_force, 1);

  const Outcome compared = calibrate(session, {"compare", "1", "2", "--json"});
  EXPECT_EQ(compared.status, 0) << compared.err;
  const json scores = json::parse(compared.out).at("scores");
  ASSERT_FALSE(scores.empty());
  EXPECT_TRUE(scores[0].at("values").at(0).is_number());
  EXPECT_TRUE(scores[0].at("values").at(1).is_null());
  EXPECT_THAT(calibrate(session, {"compare", "1", "1"}).out, HasSubstr("1 (self)"));

  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"use", "9"}, {"compare", "1", "9"}}) {
    const Outcome unknown = calibrate(session, arguments);
    EXPECT_EQ(unknown.status, 2);
    EXPECT_THAT(unknown.err, HasSubstr("there is no calibration 9"));
    EXPECT_THAT(unknown.out, IsEmpty());
  }
}

TEST(Calibrate, RecentringWithoutSensorsSaysSo) {
  std::vector<take::LogEntry> entries =
      session::test::performance(4).entries;  // They fall silent after 16.5 s.
  StagedSession session(std::move(entries), 18, 10);
  const Outcome outcome = calibrate(session, {"recentre"});
  EXPECT_EQ(outcome.status, 1);
  EXPECT_THAT(outcome.err, HasSubstr("no sensor sent anything; the neutral face stays as it was"));
}

TEST(Calibrate, ATokenIsAskedForAndTakenFromThePagesAddress) {
  StagedSession session({}, 0, 1, "0123456789abcdef");
  const Outcome without = calibrate(session, {"list"});
  EXPECT_EQ(without.status, 2);
  EXPECT_THAT(without.err, HasSubstr("--token"));
  EXPECT_EQ(calibrate(session, {"list", "--token", "0123456789abcdef"}).status, 0);
  const Outcome whole = run({"calibrate", "list", "--at", session.page()});
  EXPECT_EQ(whole.status, 0) << whole.err;
  EXPECT_THAT(whole.out, HasSubstr("There is no calibration yet. Look ahead"));
}

/// Sets a variable of the environment, which programs that are started inherit, for as long as it lives.
class Variable {
 public:
  Variable(const char* name, const std::string& value) : name_(name) { ::setenv(name, value.c_str(), 1); }
  ~Variable() { ::unsetenv(name_); }
  Variable(const Variable&) = delete;
  Variable& operator=(const Variable&) = delete;

 private:
  const char* name_;
};

TEST(Calibrate, ATokenIsReadFromAFileOrTheEnvironment) {
  const std::string token = "0123456789abcdef", wrong = "fedcba9876543210";
  StagedSession session({}, 0, 1, token);
  const Folder folder;
  write(folder / "token", "  " + token + " \r\nand more\n");
  write(folder / "wrong", wrong);
  write(folder / "short", "abc\n");
  write(folder / "blank", "\n" + token + "\n");
  EXPECT_EQ(calibrate(session, {"list", "--token-file", folder / "token"}).status, 0);
  for (const std::string& file : {folder / "wrong", folder / "short", folder / "blank", folder / "none"}) {
    const Outcome outcome = calibrate(session, {"list", "--token-file", file});
    EXPECT_EQ(outcome.status, 2) << file;
    EXPECT_EQ(std::ranges::count(outcome.err, '\n'), 1) << outcome.err;
    EXPECT_EQ(outcome.err.find("abc"), std::string::npos) << "a token is not shown: " << outcome.err;
  }
  const Outcome both = calibrate(session, {"list", "--token-file", folder / "token", "--token", token});
  EXPECT_EQ(both.status, 2);
  EXPECT_THAT(both.err, HasSubstr("cannot be given together"));

  {
    const Variable set("MIEN_TOKEN", token);
    EXPECT_EQ(calibrate(session, {"list"}).status, 0);
    EXPECT_EQ(calibrate(session, {"list", "--token-file", folder / "wrong"}).status, 2)
        << "the file goes before";
    EXPECT_EQ(calibrate(session, {"list", "--token", wrong}).status, 2) << "so does the option";
  }
  const Variable set("MIEN_TOKEN", wrong);
  EXPECT_EQ(calibrate(session, {"list"}).status, 2);
  EXPECT_EQ(run({"calibrate", "list", "--at", session.page()}).status, 0) << "so does the page's address";
}

TEST(Calibrate, NobodyThereIsOneLineWithTheWayOut) {
  std::string at;
  {
    const StagedSession gone({}, 0, 1);
    at = gone.at();
  }
  for (const char* what : {"short", "list", "recentre"}) {
    const Outcome outcome = run({"calibrate", what, "--at", at});
    EXPECT_EQ(outcome.status, 1);
    EXPECT_EQ(outcome.err, "mien: " + at +
                               ": no session is there; start mien live first, or say where it is with --at "
                               "HOST:PORT\n");
    EXPECT_THAT(outcome.out, IsEmpty());
  }
  for (const char* wrong : {"", ":8740", "127.0.0.1:99999", "udp://127.0.0.1:8740", "127.0.0.1:8740/there"}) {
    const Outcome outcome = run({"calibrate", "list", "--at", wrong});
    EXPECT_EQ(outcome.status, 2) << wrong;
  }
  EXPECT_EQ(run({"calibrate", "long", "--at", at}).status, 2);
  EXPECT_EQ(run({"calibrate", "use", "--at", at}).status, 2);
  EXPECT_EQ(run({"calibrate", "list", "--at", at, "--token", "a b"}).status, 2);
}

TEST(Calibrate, SomethingElseThereIsNotBelieved) {
  boost::asio::io_context network(1);
  live::PageSettings settings;
  settings.port = 0;
  for (const char* nonsense :
       {"no JSON", "[]", R"({"type": "status", "time": 0, "calibration": {"state": "done"}})"}) {
    const auto page =
        live::PageServer::open(
            network, settings, [&] { return std::string(nonsense); }, [](std::uint64_t, std::string_view) {})
            .value();
    std::thread thread([&network] { network.run(); });
    const Outcome outcome = run({"calibrate", "list", "--at", page->address()});
    EXPECT_EQ(outcome.status, 1) << nonsense;
    EXPECT_THAT(outcome.err, HasSubstr("speaks no session's language"));
    network.stop();
    thread.join();
    network.restart();
  }
}

}  // namespace
}  // namespace mien::app::test::calibrate_test
