// Other programs: what they are given, what they say, and that none is left behind.
#include "app/child_program.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "tests/app/program.h"

namespace mien::app::test::child_program_test {
namespace {

std::vector<std::string> shell(const std::string& script) {
  return {"/bin/sh", "-c", script};
}

std::span<const std::uint8_t> bytes_of(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

TEST(Child, TellsWhatWasSaidAndHowItEnded) {
  const auto said = run_child(shell("echo one; echo two >&2; exit 3"));
  ASSERT_TRUE(said) << said.error().message();
  EXPECT_EQ(said->out, "one\n");
  EXPECT_EQ(said->complaints, "two\n");
  EXPECT_EQ(said->status, 3);
  EXPECT_FALSE(said->succeeded());
}

TEST(Child, TellsTheSignalThatEndedIt) {
  const auto said = run_child(shell("kill -9 $$"));
  ASSERT_TRUE(said) << said.error().message();
  EXPECT_EQ(said->status, 128 + SIGKILL);
}

TEST(Child, IsAskedToStopAndKilledWhereItGoesOn) {
  auto obeys = Child::start(shell("trap 'echo bye; exit 4' TERM; echo on; while :; do sleep 0.01; done"),
                            Child::Input::none);
  ASSERT_TRUE(obeys) << obeys.error().message();
  std::this_thread::sleep_for(std::chrono::milliseconds(200));  // It has nothing to say when it is ready.
  const auto said = obeys->stop(std::chrono::minutes(1));
  ASSERT_TRUE(said) << said.error().message();
  EXPECT_EQ(said->status, 4);
  EXPECT_EQ(said->out, "on\nbye\n");
  // An ignored signal stays ignored by the program that a shell becomes.
  auto goes_on = Child::start(shell("trap '' TERM; exec sleep 60"), Child::Input::none);
  ASSERT_TRUE(goes_on) << goes_on.error().message();
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  const auto killed = goes_on->stop(std::chrono::milliseconds(50));
  ASSERT_FALSE(killed);
  EXPECT_NE(killed.error().message().find("was killed"), std::string::npos);
  EXPECT_FALSE(goes_on->stop(std::chrono::milliseconds(50))) << "it has ended";
}

TEST(Child, IsAskedToStopBeforeItIsWaitedFor) {
  auto child = Child::start(shell("trap 'exit 4' TERM; while :; do sleep 0.01; done"), Child::Input::none);
  ASSERT_TRUE(child) << child.error().message();
  std::this_thread::sleep_for(std::chrono::milliseconds(200));  // It has nothing to say when it is ready.
  child->ask_to_stop();
  const auto said = child->wait();
  ASSERT_TRUE(said) << said.error().message();
  EXPECT_EQ(said->status, 4);
  child->ask_to_stop();  // It is gone; nobody else is asked in its place.
}

TEST(Child, HasNothingToReadUnlessItIsFed) {
  const auto said = run_child({"cat"});
  ASSERT_TRUE(said) << said.error().message();
  EXPECT_TRUE(said->succeeded());
  EXPECT_EQ(said->out, "");
}

TEST(Child, HasTheEnvironmentThatItIsGiven) {
  const auto said = run_child(shell("echo \"$MIEN_A-$HOME\""), {"MIEN_A=1"});
  ASSERT_TRUE(said) << said.error().message();
  EXPECT_EQ(said->out, "1-\n");
}

TEST(Child, ReadsWhatItIsFed) {
  auto child = Child::start({"cat"}, Child::Input::fed);
  ASSERT_TRUE(child) << child.error().message();
  // More than any pipe holds, there and back.
  const std::string text(1 << 20, 'x');
  EXPECT_TRUE(child->send(bytes_of(text)));
  EXPECT_TRUE(child->send(bytes_of("y")));
  const auto said = child->wait();
  ASSERT_TRUE(said) << said.error().message();
  EXPECT_TRUE(said->succeeded());
  EXPECT_TRUE(said->out == text + "y");
}

TEST(Child, MayComplainMuchWhileItIsFed) {
  auto child = Child::start(shell("head -c 1000000 /dev/zero >&2; cat"), Child::Input::fed);
  ASSERT_TRUE(child) << child.error().message();
  const std::string text(1 << 20, 'x');
  EXPECT_TRUE(child->send(bytes_of(text)));
  const auto said = child->wait();
  ASSERT_TRUE(said) << said.error().message();
  EXPECT_EQ(said->complaints.size(), 1'000'000U);
  EXPECT_EQ(said->out.size(), text.size());
}

TEST(Child, ThatListensNoMoreIsAnErrorAndNoSignal) {
  auto child = Child::start(shell("exec <&-; echo 'no more' >&2; exit 2"), Child::Input::fed);
  ASSERT_TRUE(child) << child.error().message();
  const std::string text(1 << 20, 'x');
  const auto sent = child->send(bytes_of(text));
  ASSERT_FALSE(sent);
  EXPECT_EQ(sent.error().code, ErrorCode::io);
  const auto said = child->wait();
  ASSERT_TRUE(said) << said.error().message();
  EXPECT_EQ(said->status, 2);
  EXPECT_EQ(said->complaints, "no more\n");
}

TEST(Child, IsWaitedForOnce) {
  auto child = Child::start({"true"}, Child::Input::none);
  ASSERT_TRUE(child) << child.error().message();
  EXPECT_TRUE(child->wait());
  const auto again = child->wait();
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().code, ErrorCode::io);
}

TEST(Child, ThatNobodyWaitsForIsStopped) {
  const Folder folder;
  const std::string began = folder / "began", stopped = folder / "stopped";
  ASSERT_EQ(::mkfifo(began.c_str(), 0600), 0);
  {
    auto child = Child::start(shell("trap 'echo > " + stopped + "; exit' TERM; echo > " + began + "; read x"),
                              Child::Input::fed);
    ASSERT_TRUE(child) << child.error().message();
    EXPECT_EQ(content(began), "\n");  // Waits for it.
  }
  EXPECT_TRUE(std::filesystem::exists(stopped));
}

TEST(Child, ThatIsNotThereIsNotFound) {
  for (const char* name : {"mien-no-such-program", "/nowhere/mien-no-such-program"}) {
    const auto said = run_child({name});
    ASSERT_FALSE(said);
    EXPECT_EQ(said.error().code, ErrorCode::not_found);
    EXPECT_NE(said.error().what.find(name), std::string::npos);
  }
}

TEST(Child, NoProgramCannotBeBecome) {
  const auto become = become_program("/nowhere/mien-no-such-program", {"mien"}, {"A=1"});
  ASSERT_FALSE(become);
  EXPECT_EQ(become.error().code, ErrorCode::io);
  EXPECT_EQ(become.error().where, "/nowhere/mien-no-such-program");
}

}  // namespace
}  // namespace mien::app::test::child_program_test
