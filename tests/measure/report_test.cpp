#include "mien/measure/report.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <regex>
#include <string>

namespace mien::measure::report_test {
namespace {

int count(const std::string& text, const std::string& part) {
  int n = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++n;
  return n;
}

Report whole() {
  Report report("A <title> & more", "beneath");
  report.key_figures({{"PVE", "0.75 mm", "ridge 0.89"}});
  report.heading("One");
  report.text("a < b");
  report.table({"Rows", {"name", "value"}, {{"x", "1.5"}, {"y", "2 \xC2\xB1 1"}}, {0}});
  report.plot({"Plot", "t (s)", "y", {{"a", {0, 1, 2}, {0, 1, 0}}, {"b", {0, 1, 2}, {1, 0, 1}}}, {}, {}});
  report.bars({"Bars", "mm", {"a"}, {{"g", {1.0}, {0.5}}}});
  report.image(std::array<std::byte, 3>{std::byte{1}, std::byte{2}, std::byte{3}}, "a \"picture\"");
  return report;
}

TEST(Report, IsWellFormed) {
  const std::string html = whole().html();
  std::vector<std::string> open;
  const std::regex tag("<(/?)([a-z0-9]+)([^>]*)>");
  for (std::sregex_iterator it(html.begin(), html.end(), tag), end; it != end; ++it) {
    const std::string name = (*it)[2], rest = (*it)[3];
    if (name == "meta" || name == "img" || rest.ends_with('/')) continue;
    if ((*it)[1].length() == 0) {
      open.push_back(name);
    } else {
      ASSERT_FALSE(open.empty()) << name;
      EXPECT_EQ(open.back(), name);
      open.pop_back();
    }
  }
  EXPECT_TRUE(open.empty());
}

TEST(Report, NeedsNothingFromOutsideAndRunsNoScript) {
  const std::string html = whole().html();
  EXPECT_EQ(count(html, "<script"), 0);
  EXPECT_EQ(count(html, "src=\""), count(html, "src=\"data:"));
  EXPECT_EQ(count(html, "href="), 0);
  EXPECT_EQ(count(html, "url("), 0);
  EXPECT_NE(html.find("prefers-color-scheme: dark"), std::string::npos);
  EXPECT_NE(html.find("data:image/png;base64,AQID"), std::string::npos);
}

TEST(Report, EscapesWhatPeopleWrite) {
  const std::string html = whole().html();
  EXPECT_NE(html.find("<h1>A &lt;title&gt; &amp; more</h1>"), std::string::npos);
  EXPECT_NE(html.find("<p>a &lt; b</p>"), std::string::npos);
  EXPECT_NE(html.find("alt=\"a &quot;picture&quot;\""), std::string::npos);
}

TEST(Report, StandsNumbersToTheRight) {
  const std::string html = whole().html();
  EXPECT_NE(html.find("<td>x</td><td class=\"number\">1.5</td>"), std::string::npos);
  EXPECT_NE(html.find("<tr class=\"strong\"><td>x"), std::string::npos);
}

TEST(AxisTicks, AreRoundAndInside) {
  EXPECT_EQ(axis_ticks(0, 1, 5), (std::vector<double>{0, 0.2, 0.4, 0.6000000000000001, 0.8, 1}));
  EXPECT_EQ(axis_ticks(-3, 12, 5), (std::vector<double>{-2, 0, 2, 4, 6, 8, 10, 12}));
  for (const double high : {1e-6, 0.037, 3.0, 17.0, 912.0, 5e7}) {
    const auto ticks = axis_ticks(0, high, 5);
    EXPECT_GE(ticks.size(), 3U) << high;
    EXPECT_LE(ticks.size(), 9U) << high;
    EXPECT_LE(ticks.back(), high * (1 + 1e-9));
  }
  EXPECT_EQ(axis_ticks(2, 2, 5).size(), 1U);
  EXPECT_EQ(axis_ticks(0, std::numeric_limits<double>::quiet_NaN(), 5).size(), 1U);
}

TEST(LinePlot, BreaksWhereThereIsNoNumber) {
  const double none = std::numeric_limits<double>::quiet_NaN();
  const std::string drawing =
      svg(LinePlot{"p", "x", "y", {{"a", {0, 1, 2, 3, 4}, {1, 2, none, 2, 1}}}, {}, {}});
  const std::size_t path = drawing.find(" d=\"");
  const std::string d = drawing.substr(path, drawing.find('"', path + 4) - path);
  EXPECT_EQ(count(d, "M"), 2);
  EXPECT_EQ(count(d, "L"), 2);
  EXPECT_EQ(count(drawing, "nan"), 0);
}

TEST(LinePlot, MarksThePointsOfALineThatAsksForIt) {
  const double none = std::numeric_limits<double>::quiet_NaN();
  LinePlot plot{"p", "x", "y", {{"a", {0, 1, 2}, {1, none, 2}}}, {}, {}};
  EXPECT_EQ(count(svg(plot), "<circle"), 0);
  plot.lines[0].points = true;
  EXPECT_EQ(count(svg(plot), "<circle"), 2) << "where there is a number";
}

TEST(LinePlot, KeepsEverySpikeOfALongCurve) {
  LinePlot plot{"p", "x", "y", {{"a", {}, {}}}, 0.0, 10.0};
  for (int i = 0; i < 100'000; ++i) {
    plot.lines[0].x.push_back(i);
    plot.lines[0].y.push_back(i == 54'321 ? 10 : 0);
  }
  const std::string drawing = svg(plot);
  EXPECT_LT(drawing.size(), 60'000U);
  EXPECT_NE(drawing.find(" 10.0L"), std::string::npos) << "the spike reaches the top of the drawing";
}

TEST(LinePlot, SurvivesHavingNothingToShow) {
  for (const LinePlot& plot : {LinePlot{}, LinePlot{"p", "x", "y", {{"a", {}, {}}}, {}, {}},
                               LinePlot{"p", "x", "y", {{"a", {1}, {1}}}, {}, {}}})
    EXPECT_EQ(count(svg(plot), "nan") + count(svg(plot), "inf"), 0);
}

TEST(BarPlot, LiesDownWhenNamesAreMany) {
  BarPlot plot{"p", "mm", {"a", "b"}, {}};
  for (int i = 0; i < 30; ++i) plot.groups.push_back({"mouthLowerDown_L", {1.0, 2.0}, {}});
  const std::string drawing = svg(plot);
  EXPECT_EQ(count(drawing, "<rect"), 60);
  EXPECT_NE(drawing.find("text-anchor=\"end\">mouthLowerDown_L"), std::string::npos);
  plot.groups.resize(2);
  EXPECT_NE(svg(plot).find("text-anchor=\"middle\">mouthLowerDown_L"), std::string::npos);
}

TEST(BarPlot, LeavesAGapForWhatIsNoNumber) {
  const BarPlot plot{"p", "mm", {"a", "b"}, {{"g", {1.0, std::numeric_limits<double>::infinity()}, {}}}};
  EXPECT_EQ(count(svg(plot), "<rect"), 1);
}

TEST(PlainText, AlignsColumnsAndLetsHeadsRunAcross) {
  const Table table{
      "Who",
      {"", "mm", "what"},
      {{"a head that is longer than any column"}, {"one", "0.5 \xC2\xB1 0.1", "x"}, {"three", "12", "-y"}},
      {0}};
  EXPECT_EQ(plain_text(table),
            "Who\n\n"
            "              mm  what\n"
            "\n"
            "a head that is longer than any column\n"
            "one    0.5 \xC2\xB1 0.1  x\n"
            "three         12  -y\n");
  Report report("t");
  report.table(table);
  EXPECT_NE(report.html().find("<td colspan=\"3\">a head"), std::string::npos);
}

}  // namespace
}  // namespace mien::measure::report_test
