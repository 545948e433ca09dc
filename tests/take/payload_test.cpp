// Payloads in the take file: beside their entries, in a table that only takes with payloads have.
#include <gmock/gmock.h>

#include <string>

#include "mien/take/summary.h"
#include "mien/take/take.h"
#include "tests/take/example_take.h"

namespace mien::take::payload_test {
namespace {

using ::testing::HasSubstr;

const std::string kHash = std::string(63, 'a') + "7";

std::vector<std::byte> bytes_of(std::size_t size, int first) {
  std::vector<std::byte> bytes(size);
  for (std::size_t i = 0; i < size; ++i)
    bytes[i] = static_cast<std::byte>((static_cast<std::size_t>(first) + i) & 0xFFU);
  return bytes;
}

/// Entries 1 to 40; every fourth has a payload, and of these every second is a reduction.
void write_payloads(const std::filesystem::path& path) {
  auto writer = TakeWriter::create(path, test::example_header(), true);
  ASSERT_TRUE(writer);
  for (int id = 1; id <= 40; ++id) {
    const std::vector<std::byte> payload =
        id % 4 == 0 ? bytes_of(id == 40 ? sensor::kMaxPayload : static_cast<std::size_t>(id), id)
                    : std::vector<std::byte>();
    writer->add_entry(test::host_ms(id), "camera", test::example_bytes(id),
                      {payload, id % 8 == 0 ? std::string_view(kHash) : std::string_view()});
  }
  const auto done = writer->finish();
  ASSERT_TRUE(done) << done.error().message();
}

class Payloads : public ::testing::Test {
 protected:
  void SetUp() override {
    static const std::string example = [] {
      const test::Folder folder(test::Folder::On::memory);
      write_payloads(folder / "a.mien");
      return test::read_raw(folder / "a.mien");
    }();
    test::write_raw(path_, example);
  }
  /// The error of opening the take and reading all of its payloads; "" for none.
  [[nodiscard]] std::string problem() const {
    const auto take = Take::open(path_);
    if (!take) return take.error().message();
    auto reader = take->payloads();
    if (!reader) return reader.error().message();
    const auto last = reader->of(40);
    return last ? std::string() : last.error().message();
  }

  test::Folder folder_{test::Folder::On::memory};
  std::filesystem::path path_ = folder_ / "a.mien";
};

TEST_F(Payloads, StandBesideTheirEntries) {
  const auto take = Take::open(path_);
  ASSERT_TRUE(take) << take.error().message();
  auto reader = take->payloads().value();
  for (int id = 1; id <= 40; ++id) {
    const auto payload = reader.of(id);
    ASSERT_TRUE(payload) << payload.error().message();
    if (id % 4 != 0) {
      EXPECT_TRUE(payload->bytes.empty()) << id;
      continue;
    }
    EXPECT_TRUE(std::ranges::equal(
        payload->bytes, bytes_of(id == 40 ? sensor::kMaxPayload : static_cast<std::size_t>(id), id)));
    EXPECT_EQ(payload->reducer, id % 8 == 0 ? kHash : "");
  }
  EXPECT_TRUE(reader.of(41).value().bytes.empty());
  EXPECT_TRUE(take->check());
  const Summary summary = summarise(*take).value();
  EXPECT_EQ(summary.payloads, 10u);
  EXPECT_EQ(summary.payload_bytes, sensor::kMaxPayload + 4 + 8 + 12 + 16 + 20 + 24 + 28 + 32 + 36);

  // Any may be left out.
  auto some = take->payloads().value();
  EXPECT_EQ(some.of(12).value().bytes.size(), 12u);
  EXPECT_EQ(some.of(12).value().bytes.size(), 12u);
  EXPECT_EQ(some.of(32).value().bytes.size(), 32u);
}

TEST_F(Payloads, ATakeWithoutAnyIsWrittenAsEver) {
  test::copy_example(path_);
  const std::string raw = test::read_raw(path_);
  EXPECT_EQ(raw[63], 1) << "the layout's version";
  EXPECT_EQ(raw.find("payload"), std::string::npos);
  const auto take = Take::open(path_);
  ASSERT_TRUE(take);
  EXPECT_TRUE(take->payloads().value().of(5).value().bytes.empty());
  EXPECT_TRUE(take->check());
}

TEST_F(Payloads, TheVersionSaysWhichTablesThereAre) {
  EXPECT_EQ(test::read_raw(path_)[63], 2);
  test::run_sql(path_, "PRAGMA user_version=1");
  EXPECT_THAT(problem(), HasSubstr("which no take has"));
  test::copy_example(path_);
  test::run_sql(path_, "PRAGMA user_version=2");
  EXPECT_THAT(problem(), HasSubstr("a table is missing"));
}

TEST_F(Payloads, RefusesRowsThatBreakTheRules) {
  const std::string clean = test::read_raw(path_);
  for (const auto& [sql, said] :
       {std::pair{"UPDATE payload SET entry=41 WHERE entry=40", "payload 41: entry is 41"},
        std::pair{"UPDATE payload SET entry=0 WHERE entry=4", "payload 0: entry is 0"},
        std::pair{"UPDATE payload SET bytes=x'' WHERE entry=8", "payload 8: it has no bytes"},
        std::pair{"UPDATE payload SET bytes=zeroblob(262145) WHERE entry=8", "payload 8"},
        std::pair{"UPDATE payload SET reducer='abc' WHERE entry=8", "its reducer is no SHA-256"},
        std::pair{"UPDATE payload SET reducer=upper(reducer) WHERE entry=8", "its reducer is no SHA-256"},
        std::pair{"UPDATE payload SET reducer=reducer||'0' WHERE entry=8", "payload 8"}}) {
    test::write_raw(path_, clean);
    test::run_sql(path_, sql);
    EXPECT_THAT(problem(), HasSubstr(said)) << sql;
    EXPECT_FALSE(test::read_everything(path_).empty()) << sql;
  }
  test::write_raw(path_, clean);
  test::run_sql(path_, "DELETE FROM payload WHERE entry=12");
  EXPECT_THAT(test::read_everything(path_), HasSubstr("when it was finished it held"));
}

TEST_F(Payloads, TheWriterRefusesWhatNoReaderTakes) {
  const std::vector<std::byte> long_one(sensor::kMaxPayload + 1);
  for (const auto& [payload, said] :
       {std::pair{sensor::Payload{long_one, {}}, "the payload of log entry 2 is longer than 262144 bytes"},
        std::pair{sensor::Payload{std::span(long_one).first(9), "abc"}, "a reducer that is no SHA-256"},
        std::pair{sensor::Payload{{}, kHash}, "has no bytes"}}) {
    auto writer = TakeWriter::create(path_, test::example_header(), true);
    ASSERT_TRUE(writer);
    const std::vector<std::byte> good = bytes_of(30, 1);
    writer->add_entry(test::host_ms(1), "camera", {}, {good, {}});
    writer->add_entry(test::host_ms(2), "camera", {}, payload);
    const auto done = writer->finish();
    ASSERT_FALSE(done);
    EXPECT_THAT(done.error().message(), HasSubstr(said));
    const auto take = Take::open(path_);
    ASSERT_TRUE(take) << take.error().message();
    EXPECT_EQ(take->entries().value().size(), 1u);
    EXPECT_EQ(take->payloads().value().of(1).value().bytes.size(), 30u);
  }
}

}  // namespace
}  // namespace mien::take::payload_test
